"""What is kept of a run as a whole, step by step."""
