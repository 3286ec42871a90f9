"""Paths, places, problems, and the texts of scenarios."""
