"""The method of Terze, Mueller and Zlatar (2015) by the paper's own formulas, in plain Numba: a check of the engine.

`lienumba.engine.checks.engines` says what both have in common.
"""
