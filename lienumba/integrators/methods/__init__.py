"""Tableaus, charts, the Munthe-Kaas step, step control: methods as plain functions of numbers."""
