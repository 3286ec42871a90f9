"""A sweep on the disk: shards, the dataset written meanwhile, resume, merge."""
