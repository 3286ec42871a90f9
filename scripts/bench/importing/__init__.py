"""The pieces of `scripts/import_check`."""
