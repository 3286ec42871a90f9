"""What a number can do: named operations, sin and cos of our own, derivatives, formulas."""
