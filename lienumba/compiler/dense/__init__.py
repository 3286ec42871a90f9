"""Small dense matrices of all runs, decomposed by routines of our own."""
