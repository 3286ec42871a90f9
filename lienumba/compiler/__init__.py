"""From plain functions of numbers to straight-line vector code: symbols, jets, lanes, emission, cache."""
