"""How an input may vary: one class for each distribution."""
