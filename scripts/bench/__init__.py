"""The pieces of `scripts/benchmark`."""
