"""Constraints that a run turns on and off: what they demand, and how those that slide are solved."""
