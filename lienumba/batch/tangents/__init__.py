"""Tangents of runs along what they went through."""
