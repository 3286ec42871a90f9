"""The uniform numbers behind samples, one stream for each run and path."""
