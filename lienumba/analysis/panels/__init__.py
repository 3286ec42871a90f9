"""What is shown of a dataset: panels, and the numbers of their lines and bands."""
