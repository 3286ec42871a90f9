"""Which inputs matter for which output."""
