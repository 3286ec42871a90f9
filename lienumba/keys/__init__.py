"""What the keys of a scenario may hold: numbers, vectors, rotations, formulas of the time."""
