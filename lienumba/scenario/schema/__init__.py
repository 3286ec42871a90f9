"""The scenario as data: which keys exist, their types, units and defaults."""
