"""Kernels of straight-line parts and of loops that call them."""
