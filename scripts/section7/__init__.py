"""The pieces of `scripts/paper`: section 7 of Terze, Mueller, Zlatar (2015), its figures and its numbers."""
