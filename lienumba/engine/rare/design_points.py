"""Where failures are most probable, and the probability if the limit were a plane there."""

from math import inf, isfinite, sqrt
from typing import Any

import numpy as np
from scipy import stats

from lienumba.engine.rare.estimate import REPLICAS, Estimate, Margins, finite, gradient
from lienumba.errors import ScenarioError

ITERATIONS = 40
CLOSE = 1e-3  # to the limit, relative to the margin at the origin, or to where the point was
APART = 1.0  # distances from which design points are different ones
STARTS = 10
PARTS = np.ones(1), 0.5 ** np.arange(1.0, 6.0)  # of a step: all of it, and where that leads to nothing better


def form(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """The first-order reliability method: the limit is taken for a plane at the most probable point of failure. No
    interval: how far the limit is from a plane, nobody knows."""
    points, origin, taken = design_points(margins, dimensions, seed)
    distances = np.linalg.norm(points, axis=1)
    tail = float(stats.norm.sf(distances[0]))
    return Estimate("form", tail if origin > 0.0 else 1.0 - tail, 0.0, 1.0, confidence, taken, points, distances)


def design_points(margins: Margins, d: int, seed: int) -> tuple[np.ndarray, float, int]:
    """Design points (k, d), nearest first, the margin in the origin, and the runs that these took: by the
    iteration of Hasofer, Lind, Rackwitz and Fiessler (Computers and Structures 9 (1978) 489) with halved steps, from
    the origin, points about it, and the opposite of what was found."""
    rng = np.random.default_rng([seed, REPLICAS])
    waiting = [np.zeros(d), *(2.0 * _directions(rng, STARTS - 1, d))]
    taken = 1
    found: list[np.ndarray] = []
    origin = float(finite(margins(np.zeros((1, d))))[0])
    size = max(abs(origin), 1e-300)
    while waiting:
        point, count = _nearest(margins, waiting.pop(0), size)
        taken += count
        if point is not None and all(np.linalg.norm(point - x) > APART for x in found):
            found.append(point)
            if len(found) <= STARTS // 2:
                waiting.append(-point)
    if not found:
        raise ScenarioError(
            "no most probable point of failure was found: the margin jumps, is flat, or is never below 0 within reach; "
            'take method = "subset", which needs none'
        )
    found.sort(key=lambda x: float(np.linalg.norm(x)))
    return np.array(found), origin, taken


def _nearest(margins: Margins, z: np.ndarray, size: float) -> tuple[np.ndarray | None, int]:
    """From a start to the nearest point of the limit, None if it is not found; and the runs that this took."""
    taken = 0
    for _ in range(ITERATIONS):
        g, slope, count = gradient(margins, z)
        square, taken = float(slope @ slope), taken + count
        if not (0.0 < square < inf and isfinite(g)):
            return None, taken
        target = (slope @ z - g) / square * slope
        if abs(g) <= CLOSE * size and np.linalg.norm(target - z) <= CLOSE * max(float(np.linalg.norm(z)), 1.0):
            return z, taken
        weight = 2.0 * max(float(np.linalg.norm(z)), 1.0) / sqrt(square)

        def merit(x: np.ndarray, value: Any, weight: float = weight) -> Any:
            return 0.5 * (x * x).sum(axis=-1) + weight * abs(value)

        tried, merits = np.empty((0, len(z))), np.empty(0)
        for parts in PARTS:
            new = z + parts[:, None] * (target - z)
            values = margins(new)
            tried = np.vstack([tried, new])
            merits = np.append(merits, np.where(np.isfinite(values), merit(new, values), inf))
            better = np.flatnonzero(merits < merit(z, g))
            if len(better):
                break
        taken += len(tried)
        z = tried[better[0] if len(better) else int(np.argmin(merits))]
    return None, taken


def _directions(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    x = rng.standard_normal((n, d))
    unit: np.ndarray = x / np.linalg.norm(x, axis=1)[:, None]
    return unit
