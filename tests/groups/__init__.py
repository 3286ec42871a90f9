"""The group functions, in every way that they can be run."""
