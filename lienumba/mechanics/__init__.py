"""Rigid bodies and ideal joints: every law is one plain function of numbers."""
