"""Kernels that evaluate a mechanism at one state, for loops of the user's own."""
