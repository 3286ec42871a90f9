"""From a checked scenario to a model with its numbers, at its start."""
