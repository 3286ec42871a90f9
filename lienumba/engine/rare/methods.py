"""The probability that a margin is below 0, of standard normal numbers: subset simulation, FORM, importance sampling.

Margins are functions of many points at once, (n, d) to (n,); one that is not finite is a failure. All is decided by
the seed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, inf, sqrt
from typing import Any

import numpy as np
from scipy import stats

from lienumba.errors import ScenarioError
from lienumba.sweep.confidence import half_width

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
    each; the interval is Student's of their logarithms, since neighbours in a chain are too alike for any other."""
    each, taken = max(runs // REPLICAS, 10), 0
    found = []
    for replica in range(REPLICAS):
        value, count = _subset(margins, dimensions, each, np.random.default_rng([seed, replica]))
        found.append(value)
        taken += count
    mean = float(np.mean(found))
    if not mean > 0.0:
        return Estimate("subset", 0.0, 0.0, LEVEL**LEVELS, confidence, taken, np.empty((0, dimensions)), np.empty(0))
    logarithms = np.log(np.maximum(found, LEVEL**LEVELS))
    half = float(half_width(logarithms.std(ddof=1), REPLICAS, confidence))
    low, high = mean * exp(-half), min(mean * exp(half), 1.0)
    return Estimate("subset", mean, low, high, confidence, taken, np.empty((0, dimensions)), np.empty(0))


def _subset(margins: Margins, d: int, n: int, rng: np.random.Generator) -> tuple[float, int]:
    """The estimate of one simulation, and the runs that it took."""
    z = rng.standard_normal((n, d))
    g, taken, probability = _finite(margins(z)), n, 1.0
    chains = max(round(LEVEL * n), 2)
    scale = SPREAD
    for _ in range(LEVELS):
        failed = int((g <= 0.0).sum())
        if failed >= chains:
            return probability * failed / n, taken
        order = np.argsort(g, kind="stable")[:chains]
        limit = float(g[order[-1]])
        if not limit < np.max(g):  # nothing comes nearer
            return probability * failed / n, taken
        probability *= chains / n
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
    return probability * float((g <= 0.0).mean()), taken


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
    """Importance sampling about all design points: a mixture of normal densities there, as likely as the points, and
    of that of the inputs. Unbiased wherever the limit lies; the interval is that of a mean."""
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
    share = np.append((1.0 - DEFENSIVE) * share / share.sum(), DEFENSIVE)
    centres = np.vstack([points, np.zeros(dimensions)])
    rng = np.random.default_rng([seed, REPLICAS + 1])
    drawn = rng.choice(len(centres), size=runs, p=share)
    z = centres[drawn] + rng.standard_normal((runs, dimensions))
    exponents = z @ centres.T - 0.5 * (centres**2).sum(axis=1)  # of each density over that of the inputs
    top = exponents.max(axis=1)
    weights = np.exp(-top - np.log(np.exp(exponents - top[:, None]) @ share))
    terms = np.where(_finite(margins(z)) <= 0.0, weights, 0.0)
    mean = float(terms.mean())
    half = float(half_width(terms.std(ddof=1), runs, confidence))
    low, high = max(mean - half, 0.0), min(mean + half, 1.0)
    return Estimate("importance", mean, low, high, confidence, taken + runs, points, distances)


METHODS: dict[str, Callable[[Margins, int, int, int, float], Estimate]] = {
    "subset": subset, "importance": importance, "form": form,
}  # fmt: skip


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
