"""docs/accuracy.md is true."""
