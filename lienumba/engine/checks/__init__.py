"""Runs of a scenario compared with those of other engines."""
