"""Lie groups of rigid bodies as plain functions of numbers."""
