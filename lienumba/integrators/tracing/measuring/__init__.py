"""What is kept of runs as a whole: the kernels that look at signals."""
