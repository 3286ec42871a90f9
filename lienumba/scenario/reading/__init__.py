"""Where scenarios come from: files, what they extend, tables."""
