"""Errors that a user of lienumba meets."""


class ScenarioError(Exception):
    """Bad input: `str(error)` is the finished message, one problem per line."""
