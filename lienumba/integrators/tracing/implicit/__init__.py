"""Steps whose stages are equations."""
