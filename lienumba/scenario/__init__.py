"""Scenarios: from a TOML file, a dict or a System to checked data, and from there to a model with numbers."""
