"""Functions of another compiler in a graph: `lienumba.jit`."""
