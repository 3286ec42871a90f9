"""What a dataset says: summaries."""
