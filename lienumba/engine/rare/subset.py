"""Subset simulation: levels of runs, each where the last one was worst."""

from math import exp, sqrt
from typing import NamedTuple

import numpy as np

from lienumba.engine.rare.estimate import REPLICAS, Estimate, Margins, around, finite
from lienumba.sweep.confidence import half_width, proportion

LEVEL = 0.1  # the part of the runs of a level that begins the next one
SPREAD = 0.6  # of what is proposed, in standard deviations
TARGET = 0.44  # the part of proposals that should be taken
LEVELS = 20


def subset(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """Subset simulation (S.-K. Au, J. L. Beck, Probabilistic Engineering Mechanics 16 (2001) 263) with adaptive
    conditional sampling (I. Papaioannou et al., ibid. 41 (2015) 89). Several independent ones of `runs` runs in a level
    each; the interval is Student's of their logarithms, since neighbours in a chain are too alike for any other. Few
    may agree by chance: they are taken to scatter at least as they would if their runs were independent. Where enough
    runs fail without any level, these are independent, and the interval is Clopper's and Pearson's; so it is of the
    runs of the first levels where none fails."""
    each = max(runs // REPLICAS, 10)
    ends = [_subset(margins, dimensions, each, np.random.default_rng([seed, replica])) for replica in range(REPLICAS)]
    found, taken = [x.probability for x in ends], sum(x.taken for x in ends)
    mean = float(np.mean(found))
    if all(x.reached == 1.0 for x in ends):
        low, high = map(float, proportion(sum(x.failed for x in ends), taken, confidence))
    elif mean > 0.0:
        logarithms, least = np.log(np.maximum(found, LEVEL**LEVELS)), float(np.mean([x.variance for x in ends]))
        low, high = around(mean, float(half_width(max(logarithms.std(ddof=1), sqrt(least)), REPLICAS, confidence)))
    else:  # levels say nothing of what they never came to; their first ones are plain runs
        low, high = 0.0, float(proportion(0, REPLICAS * each, confidence)[1])
    return Estimate("subset", mean, low, high, confidence, taken, np.empty((0, dimensions)), np.empty(0))


class _Last(NamedTuple):
    """Where one subset simulation ends: in a level that is so probable, with so many runs of which some fail; the
    variance that the logarithm of its probability would have if runs were independent, and all runs that it took."""

    reached: float
    runs: int
    failed: int
    variance: float
    taken: int

    @property
    def probability(self) -> float:
        return self.reached * self.failed / self.runs


def _subset(margins: Margins, d: int, n: int, rng: np.random.Generator) -> _Last:
    """One simulation, with n runs in each level."""
    z = rng.standard_normal((n, d))
    g, taken, probability, variance = finite(margins(z)), n, 1.0, 0.0
    chains = max(round(LEVEL * n), 2)
    scale = SPREAD
    for level in range(LEVELS + 1):
        failed = int((g <= 0.0).sum())
        order = np.argsort(g, kind="stable")[:chains]
        limit = float(g[order[-1]])
        if failed >= chains or level == LEVELS or not limit < np.max(g):  # enough fail, or nothing comes nearer
            break
        probability *= chains / n
        variance += 1.0 / chains - 1.0 / n
        seeds, values = z[order], g[order]
        parts = [(seeds, values)]
        steps = -(-n // chains) - 1
        for step in range(steps):
            spread = min(scale, 1.0)
            moved = sqrt(1.0 - spread * spread) * seeds + spread * rng.standard_normal(seeds.shape)
            new = finite(margins(moved))
            taken += len(moved)
            accepted = new <= limit
            seeds, values = np.where(accepted[:, None], moved, seeds), np.where(accepted, new, values)
            parts.append((seeds, values))
            scale *= exp((float(accepted.mean()) - TARGET) / sqrt(step + 1.0))
        z, g = (np.concatenate(x) for x in zip(*parts, strict=True))
        n = len(z)
    return _Last(probability, n, failed, variance + 1.0 / max(failed, 1) - 1.0 / n, taken)
