"""Monte-Carlo sweeps: distributions, one stream of random numbers per run and path, the design table."""
