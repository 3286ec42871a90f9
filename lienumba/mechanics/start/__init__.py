"""The initial state: where joints are, and what closes the mechanism."""
