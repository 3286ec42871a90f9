"""A mechanism by the freedoms of its joints: a tree of links, and the constraints that close its loops."""
