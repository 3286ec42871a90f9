"""What is wrong with a scenario: one module for each part of it."""
