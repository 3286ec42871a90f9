"""A mechanism as data, and what a law sees of it."""
