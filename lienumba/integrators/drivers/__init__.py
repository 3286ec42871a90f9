"""The loops over time, compiled by Numba once ever: they know rows of numbers, and no mechanics."""
