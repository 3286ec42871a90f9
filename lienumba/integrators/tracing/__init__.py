"""From a mechanism and a method to kernels: the step, run once on symbols."""
