"""The share of each input in the variance of outputs."""
