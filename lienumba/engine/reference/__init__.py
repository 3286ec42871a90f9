"""The engine "numba" (`lienumba.reference`), from prepared runs to what is kept of them."""
