"""Methods, the driver and the projection, against exact motions, the naive twin and general optimisers."""
