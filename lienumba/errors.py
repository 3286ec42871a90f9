"""Errors that a user of lienumba meets."""


class ScenarioError(Exception):
    """Bad input: `str(error)` is the finished message, one problem per line."""


class ClusterError(Exception):
    """A cluster is gone in the middle of its work: `str(error)` is the finished message."""
