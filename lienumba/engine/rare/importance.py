"""Importance sampling about all points where failures are likely."""

import numpy as np

from lienumba.engine.rare.centres import DEFENSIVE, mixture, spread, valleys
from lienumba.engine.rare.design_points import design_points
from lienumba.engine.rare.estimate import REPLICAS, Estimate, Margins, around, finite
from lienumba.sweep.confidence import freedom, proportion, student


def importance(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """As many runs about each centre (see `centres`) as it is likely, and some as the inputs are, weighted by the
    mixture of these normal densities. Each part is a Latin hypercube whose first axis leads to its centre. Centres are
    found with other runs: unbiased wherever the limit lies. The interval is that of independent runs, whose mean
    scatters as much or more (A. B. Owen, SIAM J. Numer. Anal. 34 (1997) 1884): Student's of a mean, with the freedom of
    its terms, about its logarithm, since means of skew terms lie low where they seem to scatter little."""
    points, _, taken = design_points(margins, dimensions, seed)
    rng = np.random.default_rng([seed, REPLICAS + 1])
    centres, more = spread(margins, points, rng)
    z, own = mixture(centres).drawn(runs, rng)
    fails = finite(margins(z)) <= 0.0
    terms = np.where(fails, own.weights(z), 0.0)
    mean = float(terms.mean())
    if not mean > 0.0:  # none of so many; weights are at most 1/DEFENSIVE
        low, high = 0.0, min(float(proportion(0, runs, confidence)[1]) / DEFENSIVE, 1.0)
    else:
        free = min(freedom(terms - mean), runs - 1)
        low, high = around(mean, float(student(terms.std(ddof=1), runs, free, confidence)) / mean)
    probable = valleys(centres, z[fails])
    distances = np.linalg.norm(probable, axis=1)
    return Estimate("importance", mean, low, high, confidence, taken + more + runs, probable, distances)
