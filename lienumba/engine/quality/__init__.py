"""How good results are: warnings about runs that are called good, and how large a dataset will be."""
