"""The pieces of `scripts/accuracy`: orders, work against precision, tolerances and long runs."""
