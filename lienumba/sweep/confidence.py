"""Confidence intervals over the runs of a sweep, of means, quantiles and proportions.

By scipy.special: it is there in a tenth of the time that scipy.stats takes, and a verdict needs no more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

ROUNDING = 1e-13  # of a probability

if TYPE_CHECKING:
    Numbers = float | np.ndarray
    Counts = float | np.ndarray


def half_width(deviation: Numbers, n: Counts, confidence: float) -> Numbers:
    """Of a mean, by Student's t: exact for normal values, and nearly so for the mean of many others; n above 1."""
    return student(deviation, n, n - 1, confidence)


def student(deviation: Numbers, n: Counts, free: Counts, confidence: float) -> Numbers:
    """The same, of a deviation that is known with so many degrees of freedom."""
    from scipy.special import stdtrit

    return stdtrit(free, 0.5 + 0.5 * confidence) * deviation / np.sqrt(n)


def freedom(terms: np.ndarray) -> float:
    """The degrees of freedom of a variance that is estimated from independent terms (n,) with mean 0: those of the
    chi-squared distribution that varies as much (F. E. Satterthwaite, Biometrics Bull. 2 (1946) 110), by their
    kurtosis; fewer where few of them are most of it."""
    squares = terms * terms
    spread = len(terms) * float(squares @ squares) - float(squares.sum()) ** 2
    return max(2.0 * len(terms) * float(squares.sum()) ** 2 / spread, 1.0) if spread > 0.0 else float(len(terms))


def ranks(n: Counts, probability: float, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """The places, from 0, of the two of n sorted values between which a quantile lies: by the binomial distribution of
    how many values it exceeds, which assumes nothing of how they are distributed. Below 0, or from n on: there is none.
    """
    tail = 0.5 * (1.0 - confidence)
    return binomial(tail, n, probability) - 1, binomial(1.0 - tail, n, probability)


def binomial(part: float, n: Counts, probability: float) -> np.ndarray:
    """The least of so many successes of n that at most so many come with so large a probability."""
    from scipy.special import bdtr, bdtrik

    k = np.nan_to_num(np.ceil(bdtrik(part, n, probability)))  # of none, or by no chance: none
    fewer = bdtr(np.maximum(k - 1, 0), n, probability) >= part * (1.0 - ROUNDING)
    return np.where(fewer, k - 1, k).clip(0).astype(np.int64)


def proportion(successes: Counts, n: Counts, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """The ends for a probability, of which n independent runs had so many successes: those at which so many, or more
    extreme ones, still have half of what is left of the confidence (C. J. Clopper, E. S. Pearson, Biometrika 26 (1934)
    404). It holds at least what it says. Of no runs it is all of 0 to 1."""
    from scipy.special import betaincinv

    tail, k = 0.5 * (1.0 - confidence), np.asarray(successes)
    with np.errstate(invalid="ignore"):
        low = np.where(k > 0, betaincinv(np.where(k > 0, k, 1), n - k + 1, tail), 0.0)
        high = np.where(k < n, betaincinv(k + 1, np.where(k < n, n - k, 1), 1.0 - tail), 1.0)
    return low, high


def bounds(successes: Counts, n: Counts, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """The same, where each end holds by itself with the confidence: at least so much, and at most so much."""
    return proportion(successes, n, 2.0 * confidence - 1.0)
