"""Numbers of the model that fit what was measured."""
