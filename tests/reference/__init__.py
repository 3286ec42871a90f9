"""The naive twins: plain NumPy, dense, written from the paper alone, sharing no code with lienumba."""
