"""Mechanisms against independent solutions in minimal coordinates."""
