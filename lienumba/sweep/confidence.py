"""Confidence intervals over the runs of a sweep, of means and of quantiles, from how many runs have a value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    Numbers = float | np.ndarray
    Counts = int | np.ndarray


def half_width(deviation: Numbers, n: Counts, confidence: float) -> Numbers:
    """Of a mean, by Student's t: exact for normal values, and nearly so for the mean of many others; n above 1."""
    from scipy import stats

    return stats.t.ppf(0.5 + 0.5 * confidence, n - 1) * deviation / np.sqrt(n)


def ranks(n: Counts, probability: float, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """The places, from 0, of the two of n sorted values between which a quantile lies: by the binomial distribution of
    how many values it exceeds, which assumes nothing of how they are distributed. Below 0, or from n on: there is none.
    """
    from scipy import stats

    tail, below = 0.5 * (1.0 - confidence), stats.binom(n, probability)
    low, high = (np.asarray(below.ppf(part)).astype(np.int64) for part in (tail, 1.0 - tail))
    return low - 1, high
