"""Observed orders, and work against precision."""
