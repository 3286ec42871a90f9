"""A mechanism of moves of its joints: its chart, its state, and its tracer."""
