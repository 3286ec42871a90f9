"""The method of Terze, Mueller and Zlatar (2015) by the paper's own formulas, in plain Numba: an independent check of
the engine, with which it shares neither graph, elimination, derivatives nor drivers."""
