"""A prepared scenario as functions for code under Numba's `@njit`."""
