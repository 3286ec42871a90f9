"""Parameters, and formulas in place of numbers."""
