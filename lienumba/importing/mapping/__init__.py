"""A compiled model of MuJoCo as the elements of a scenario."""
