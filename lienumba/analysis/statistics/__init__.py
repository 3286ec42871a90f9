"""Means, covariances and intervals over runs, for rotations on their group."""
