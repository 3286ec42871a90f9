"""What switched constraints do at a change, of one run."""
