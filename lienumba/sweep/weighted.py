"""Statistics of runs with weights: estimates of what runs without any would show, divided by the sum of the weights,
and their confidence intervals.

An interval of a proportion is that of Clopper and Pearson of so many runs without weights as have its variance (E. L.
Korn, B. I. Graubard, Survey Methodology 24 (1998) 193); that of a quantile follows from it by the inverse of the
weighted distribution function (R. S. Woodruff, J. Amer. Statist. Assoc. 47 (1952) 635).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from lienumba.sweep import confidence


@dataclass(frozen=True)
class Interval:
    """A statistic between the ends of its interval."""

    value: float
    low: float
    high: float

    @property
    def width(self) -> float:
        return self.high - self.low


def effective(weights: np.ndarray) -> float:
    """How many runs with equal weights tell as much of a mean that has nothing to do with the weights (L. Kish)."""
    return float(weights.sum() ** 2 / (weights @ weights))


def share(true: np.ndarray, weights: np.ndarray) -> float:
    """By weight, of which part of the runs something is true (n,: 1 or 0): just 1, or 0, where of all, or of none."""
    yes, no = float(weights[true > 0.0].sum()), float(weights[true <= 0.0].sum())
    return yes / (yes + no)


def runs_that_tell(true: np.ndarray, weights: np.ndarray) -> float:
    """How many runs without weights would know as well which part is true (n,: 1 or 0). Where all are alike, as many
    as if each weighed as much as the heaviest."""
    total, part = float(weights.sum()), share(true, weights)
    if not 0.0 < part < 1.0:
        return total / float(weights.max())
    rest = weights * (true - part)
    return part * (1.0 - part) * total**2 / float(rest @ rest)


def proportion(true: np.ndarray, weights: np.ndarray, sure: float) -> Interval:
    """The part of all runs of which something is true (n,: 1 or 0)."""
    if not len(true) or not weights.any():
        return Interval(nan, 0.0, 1.0)
    n, part = runs_that_tell(true, weights), share(true, weights)
    low, high = confidence.proportion(part * n, n, sure)
    return Interval(part, float(low), float(high))


def mean(x: np.ndarray, weights: np.ndarray, sure: float) -> Interval:
    """The mean of values (n,): Student's t of the jackknife, with the freedom of the effective number of runs, or, if
    that is less, as many times fewer as weights make that of their terms."""
    if len(x) < 2 or not weights.any():
        return Interval(float(x[0]) if len(x) else nan, -inf, inf)
    total, n, tells = float(weights.sum()), len(x), max(effective(weights), 1.0 + 1e-9)
    middle = float(weights @ x) / total
    rest = weights * (x - middle) / np.maximum(total - weights, 1e-12 * total)  # without each of the runs in turn
    fewer = confidence.freedom(rest) / confidence.freedom(x - middle)
    error, tells = (float(rest @ rest) * (n - 1) / n) ** 0.5, min(tells, max((n - 1) * fewer, 1.0) + 1.0)
    half = float(confidence.half_width(error * tells**0.5, tells, sure))
    return Interval(middle, middle - half, middle + half)


def deviation(x: np.ndarray, weights: np.ndarray) -> float:
    """The standard deviation of values (n,)."""
    tells = effective(weights) if weights.any() else 0.0
    if not tells > 1.0:
        return nan
    rest = x - np.average(x, weights=weights)
    return float((np.average(rest * rest, weights=weights) * tells / (tells - 1.0)) ** 0.5)


def quantiles(x: np.ndarray, weights: np.ndarray | None, probabilities: tuple[float, ...]) -> np.ndarray:
    """Of values (n,), linear between the middles of their weights, if they have some; NaN where all of these are 0."""
    if weights is None:
        return np.quantile(x, probabilities)
    if not weights.any():
        return np.full(len(probabilities), nan)
    order = np.argsort(x, kind="stable")
    w = weights[order]
    middles = (np.cumsum(w) - 0.5 * w) / w.sum()
    return np.interp(probabilities, middles, x[order])


def quantile(x: np.ndarray, weights: np.ndarray, probability: float, sure: float) -> Interval:
    """A quantile of values (n,), one of them; an end is infinite where runs are too few for it."""
    if not len(x) or not weights.any():
        return Interval(nan, -inf, inf)
    order = np.argsort(x, kind="stable")
    x, w = x[order], weights[order]
    upto = np.cumsum(w) / w.sum()
    value = float(x[min(int(np.searchsorted(upto, probability)), len(x) - 1)])
    n = runs_that_tell((x <= value).astype(float), w)
    low, high = (float(end) for end in confidence.proportion(probability * n, n, sure))
    first, last = int(np.searchsorted(upto, low, side="right")), int(np.searchsorted(upto, high))
    return Interval(
        value,
        float(x[first - 1]) if first > 0 else -inf,
        float(x[last]) if last < len(x) and high < 1.0 else inf,
    )
