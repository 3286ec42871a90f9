"""Sweeps that are killed at random moments, and what comes of them."""
