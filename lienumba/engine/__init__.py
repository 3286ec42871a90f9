"""Runs scenarios: on threads or on a cluster, kept in memory or on the disk, resumed, merged, replayed, compared."""
