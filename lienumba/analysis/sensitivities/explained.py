"""How much of the variance of an output one input explains alone: first Sobol' indices of any independent runs.

The runs are put in the order of the input and cut into n^0.4 groups. Parabolas fitted to each group are E[y | x]; the
mean of their squares, without what noise adds to it (p s^2 for p coefficients and a residual variance s^2), over the
variance of y is the index. Its standard error has three parts: the influence function y^2 - (y - m)^2 - S y^2 of the
ratio, the variance of the noise that is taken off, and the difference to straight lines in place of parabolas, which
bounds what groups are too coarse for. Runs that are spread more evenly than by chance have less of this noise, how much
less nobody knows: half of it is taken off, and the interval has room for all and none. Student's t has the freedom of
the influence's kurtosis. S. Da Veiga, F. Gamboa, B. Iooss, C. Prieur, Basics and Trends in Sensitivity Analysis (SIAM
2021), chapter 4, has the influence function.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lienumba.sweep.confidence import freedom

CONFIDENCE = 0.95
FEWEST = 100  # runs, from which on intervals hold what they say (docs/statistics.md)
SMALLEST = 12  # group
DEGREE = 2


@dataclass(frozen=True)
class Fit:
    """E[y | x] of an output whose mean is 0: m (n,); the sum of its squares without what noise adds, that with lines in
    place of parabolas, what noise adds to squares, its variance, and how many coefficients were fitted."""

    m: np.ndarray
    squares: float
    of_lines: float
    added: float
    noise: float
    coefficients: int


def explained(x: np.ndarray, y: np.ndarray, evenly: bool = False) -> dict[str, float]:
    """The first index of an input x (n,) for an output y (n,) and the ends of its 95 % interval, by their names; none
    of too few runs. evenly: whether these are spread more so than by chance."""
    n = len(y)
    if n < FEWEST:
        return {}
    y = y - y.mean()
    found, variance = fit(x, y), float(y @ y) / (n - 1)
    index, of_lines = (total / (n - 1) / variance for total in (found.squares, found.of_lines))
    influence = (y * y - (y - found.m) ** 2 - index * y * y) / variance
    half = half_of(influence, found, variance, index - of_lines)
    if evenly:
        room = 0.5 * found.added / (n - 1) / variance
        index, half = index + room, half + room
    return {"first_order": index, "first_order_low": index - half, "first_order_high": index + half}


def half_of(influence: np.ndarray, found: Fit, variance: float, coarse: float) -> float:
    """Half of the interval of an index with this influence function (n,), whose groups may be too coarse by so much."""
    from scipy.special import stdtrit

    n = len(influence)
    sampling = (influence.var() * n + found.noise / variance**2) / (n * (n - found.coefficients))
    free = min(n - found.coefficients, freedom(influence - influence.mean()))
    factor = stdtrit(free, 0.5 + 0.5 * CONFIDENCE)
    return float(factor * (sampling + coarse**2) ** 0.5)


def fit(x: np.ndarray, y: np.ndarray) -> Fit:
    """That of groups of an input x (n,)."""
    n, order = len(y), np.argsort(x, kind="stable")
    x, y, m = x[order], y[order], np.empty(len(y))
    squares = of_lines = added = noise = 0.0
    coefficients = 0
    for first, end in pairwise(np.linspace(0, n, min(round(n**0.4), n // SMALLEST) + 1).astype(int)):
        basis = _polynomials(x[first:end])
        own, part = y[first:end], basis.T @ y[first:end]
        m[order[first:end]] = basis @ part
        p = len(part)
        rest = own - m[order[first:end]]
        s2 = float(rest @ rest) / (len(own) - p)
        squares += float(part @ part) - p * s2
        of_lines += float(part[:2] @ part[:2]) - min(p, 2) * s2
        added += p * s2
        noise += 2.0 * s2 * s2 * p * len(own) / (len(own) - p)
        coefficients += p
    return Fit(m, squares, of_lines, added, noise, coefficients)


def _polynomials(x: np.ndarray) -> np.ndarray:
    """Orthonormal ones (n, p) up to DEGREE on these points, as many as they tell apart."""
    basis = [np.full(len(x), len(x) ** -0.5)]
    t = x - x.mean()
    scale = abs(t).max()
    for degree in range(1, DEGREE + 1 if scale else 1):
        column = (t / scale) ** degree
        whole = np.linalg.norm(column)
        for _ in range(2):
            for other in basis:
                column = column - other * (other @ column)
        left = np.linalg.norm(column)
        if left > 1e-8 * whole:
            basis.append(column / left)
    return np.stack(basis, axis=1)
