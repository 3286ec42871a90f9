"""The probability that a margin is below 0, of standard normal numbers: subset simulation, FORM, importance sampling.

Margins are functions of many points at once, (n, d) to (n,); one that is not finite is a failure. All is decided by
the seed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, inf, log, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from lienumba.errors import ScenarioError
from lienumba.sweep.confidence import freedom, half_width, proportion, student

Margins = Callable[[np.ndarray], np.ndarray]

LEVEL = 0.1  # the part of the runs of a level that begins the next one
SPREAD = 0.6  # of what is proposed, in standard deviations
TARGET = 0.44  # the part of proposals that should be taken
LEVELS = 20
REPLICAS = 4  # independent subset simulations, whose scatter is the interval
STEP = 0.02  # of the differences of FORM, in standard deviations
ITERATIONS = 40
CLOSE = 1e-3  # to the limit, relative to the margin at the origin, or to where the point was
APART = 1.0  # distances from which design points are different ones
RELEVANT = 2.0  # how much farther than the nearest a design point may be, to be sampled about
DEFENSIVE = 0.1  # the part of the sample that is drawn as the inputs are
STARTS = 10
MANY = 4  # design points that are as near: there may be more


@dataclass(frozen=True)
class Estimate:
    """A probability with its interval. runs: that it took; design_points (k, d): where failures are most probable,
    nearest first, and their distances from the origin; of FORM and importance sampling."""

    method: str
    probability: float
    low: float
    high: float
    confidence: float
    runs: int
    design_points: np.ndarray
    distances: np.ndarray


def subset(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """Subset simulation (S.-K. Au, J. L. Beck, Probabilistic Engineering Mechanics 16 (2001) 263) with adaptive
    conditional sampling (I. Papaioannou et al., ibid. 41 (2015) 89). Several independent ones of `runs` runs in a level
    each; the interval is Student's of their logarithms, since neighbours in a chain are too alike for any other. Few
    may agree by chance: they are taken to scatter at least as they would if their runs were independent. Where enough
    runs fail without any level, these are independent, and the interval is Clopper's and Pearson's."""
    each = max(runs // REPLICAS, 10)
    ends = [_subset(margins, dimensions, each, np.random.default_rng([seed, replica])) for replica in range(REPLICAS)]
    found, taken = [x.probability for x in ends], sum(x.taken for x in ends)
    mean = float(np.mean(found))
    if all(x.reached == 1.0 for x in ends):
        low, high = map(float, proportion(sum(x.failed for x in ends), taken, confidence))
    elif mean > 0.0:
        logarithms, least = np.log(np.maximum(found, LEVEL**LEVELS)), float(np.mean([x.variance for x in ends]))
        low, high = _around(mean, float(half_width(max(logarithms.std(ddof=1), sqrt(least)), REPLICAS, confidence)))
    else:  # none of the runs of the last levels
        low, high = 0.0, max(x.reached * float(proportion(0, x.runs, confidence)[1]) for x in ends)
    return Estimate("subset", mean, low, high, confidence, taken, np.empty((0, dimensions)), np.empty(0))


def _around(mean: float, half: float) -> tuple[float, float]:
    """An interval of a probability, from half of the one of its logarithm."""
    return mean * exp(-half), mean * exp(half) if half < -log(mean) else 1.0


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
    g, taken, probability, variance = _finite(margins(z)), n, 1.0, 0.0
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
            new = _finite(margins(moved))
            taken += len(moved)
            accepted = new <= limit
            seeds, values = np.where(accepted[:, None], moved, seeds), np.where(accepted, new, values)
            parts.append((seeds, values))
            scale *= exp((float(accepted.mean()) - TARGET) / sqrt(step + 1.0))
        z, g = (np.concatenate(x) for x in zip(*parts, strict=True))
        n = len(z)
    return _Last(probability, n, failed, variance + 1.0 / max(failed, 1) - 1.0 / n, taken)


def design_points(margins: Margins, d: int, seed: int, starts: int = STARTS) -> tuple[np.ndarray, float, int]:
    """Design points (k, d), nearest first, the margin in the origin, and the runs that these took: by the
    iteration of Hasofer, Lind, Rackwitz and Fiessler (Computers and Structures 9 (1978) 489) with halved steps, from
    the origin, points about it, and the opposite of what was found."""
    rng = np.random.default_rng([seed, REPLICAS])
    waiting = [np.zeros(d), *(2.0 * _directions(rng, starts - 1, d))]
    taken = 1
    found: list[np.ndarray] = []
    origin = float(_finite(margins(np.zeros((1, d))))[0])
    size = max(abs(origin), 1e-300)
    while waiting:
        point, count = _nearest(margins, waiting.pop(0), size)
        taken += count
        if point is not None and all(np.linalg.norm(point - x) > APART for x in found):
            found.append(point)
            if len(found) <= starts // 2:
                waiting.append(-point)
    found.sort(key=lambda x: float(np.linalg.norm(x)))
    return np.array(found).reshape(-1, d), origin, taken


def _nearest(margins: Margins, z: np.ndarray, size: float) -> tuple[np.ndarray | None, int]:
    """From a start to the nearest point of the limit, None if it is not found; and the runs that this took."""
    d, taken = len(z), 0
    for _ in range(ITERATIONS):
        around = np.vstack([z, z + STEP * np.eye(d), z - STEP * np.eye(d)])
        g = margins(around)
        taken += len(around)
        if not np.isfinite(g).all():
            return None, taken
        slope = (g[1 : d + 1] - g[d + 1 :]) / (2.0 * STEP)
        square = float(slope @ slope)
        if not square > 0.0:
            return None, taken
        target = (slope @ z - g[0]) / square * slope
        if abs(g[0]) <= CLOSE * size and np.linalg.norm(target - z) <= CLOSE * max(float(np.linalg.norm(z)), 1.0):
            return z, taken
        weight = 2.0 * max(float(np.linalg.norm(z)), 1.0) / sqrt(square)

        def merit(x: np.ndarray, value: Any, weight: float = weight) -> Any:
            return 0.5 * (x * x).sum(axis=-1) + weight * abs(value)

        parts = 0.5 ** np.arange(6.0)
        tried = z + parts[:, None] * (target - z)
        values = margins(tried)
        taken += len(tried)
        merits = np.where(np.isfinite(values), merit(tried, values), inf)
        better = np.flatnonzero(merits < merit(z, g[0]))
        z = tried[better[0] if len(better) else int(np.argmin(merits))]
    return None, taken


def form(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """The first-order reliability method: the limit is taken for a plane at the most probable point of failure. No
    interval: how far the limit is from a plane, nobody knows."""
    points, origin, taken = design_points(margins, dimensions, seed)
    _need(points)
    distances = np.linalg.norm(points, axis=1)
    tail = float(stats.norm.sf(distances[0]))
    return Estimate("form", tail if origin > 0.0 else 1.0 - tail, 0.0, 1.0, confidence, taken, points, distances)


def importance(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """Importance sampling about all design points: as many runs about each of them as it is likely, and some as the
    inputs are, weighted by the mixture of these normal densities. Each part is a Latin hypercube whose first axis leads
    to its point. Unbiased wherever the limit lies; the interval is that of independent runs, whose mean scatters as
    much or more (A. B. Owen, SIAM J. Numer. Anal. 34 (1997) 1884): Student's of a mean, with the freedom of its terms,
    about its logarithm, since means of skew terms lie low where they seem to scatter little."""
    points, _, taken = design_points(margins, dimensions, seed)
    _need(points)
    distances = np.linalg.norm(points, axis=1)
    points, distances = (x[distances <= distances[0] + RELEVANT] for x in (points, distances))
    if len(points) > MANY:
        raise ScenarioError(
            f"failures are as likely in {len(points)} directions or more, too many to sample about each of them; "
            'take method = "subset"'
        )
    share = np.exp(-0.5 * (distances**2 - distances[0] ** 2))
    counts = np.diff(np.floor(runs * (1.0 - DEFENSIVE) * np.cumsum(share) / share.sum()).astype(int), prepend=0)
    counts = np.append(counts, runs - counts.sum())
    centres, share = np.vstack([points, np.zeros(dimensions)]), counts / runs
    rng = np.random.default_rng([seed, REPLICAS + 1])
    z = np.concatenate([_about(centre, n, rng) for centre, n in zip(centres, counts, strict=True)])
    exponents = z @ centres.T - 0.5 * (centres**2).sum(axis=1)  # of each density over that of the inputs
    top = exponents.max(axis=1)
    weights = np.exp(-top - np.log(np.exp(exponents - top[:, None]) @ share))
    terms = np.where(_finite(margins(z)) <= 0.0, weights, 0.0)
    mean = float(terms.mean())
    if not mean > 0.0:  # none of so many; weights are at most 1/DEFENSIVE
        low, high = 0.0, min(float(proportion(0, runs, confidence)[1]) / DEFENSIVE, 1.0)
    else:
        free = min(freedom(terms - mean), runs - 1)
        low, high = _around(mean, float(student(terms.std(ddof=1), runs, free, confidence)) / mean)
    return Estimate("importance", mean, low, high, confidence, taken + runs, points, distances)


METHODS: dict[str, Callable[[Margins, int, int, int, float], Estimate]] = {
    "subset": subset, "importance": importance, "form": form,
}  # fmt: skip


def _about(centre: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """n standard normal points about a centre, a Latin hypercube in axes of which the first leads from the origin to
    it: a reflection turns them there."""
    places = rng.permuted(np.tile(np.arange(n)[:, None], len(centre)), axis=0)
    within = rng.uniform(1e-9, 1.0 - 1e-9, places.shape)  # not on an end, which is infinitely far away
    z: np.ndarray = stats.norm.ppf((places + within) / n)
    mirror = centre + np.copysign(np.linalg.norm(centre), centre[0]) * np.eye(len(centre))[0]
    square = float(mirror @ mirror)
    return centre + (z - np.outer(z @ mirror, 2.0 / square * mirror) if square > 0.0 else z)


def _need(points: np.ndarray) -> None:
    if not len(points):
        raise ScenarioError(
            "no most probable point of failure was found: the margin jumps, is flat, or is never below 0 within reach; "
            'take method = "subset", which needs none'
        )


def _finite(g: np.ndarray) -> np.ndarray:
    """Margins, where runs that have none fail farther than any other."""
    finite = np.isfinite(g)
    least = float(g[finite].min()) if finite.any() else 0.0
    return np.where(finite, g, min(least, 0.0) - 1.0)


def _directions(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    x = rng.standard_normal((n, d))
    unit: np.ndarray = x / np.linalg.norm(x, axis=1)[:, None]
    return unit
