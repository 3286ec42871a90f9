"""Tableaus, the Munthe-Kaas step, and the one driver."""
