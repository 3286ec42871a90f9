"""What is wanted of runs: requirements, and when there are runs enough."""
