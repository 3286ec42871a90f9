"""What samples say of one input and one output: their rank correlation, and how far the output moves with the input.

Rank correlations are Spearman's, which sees any monotonic effect. Their interval is that of Fisher's z with the
variance of D. G. Bonett and T. A. Wright, Psychometrika 65 (2000): (1 + r^2/2)/(n - 3).

A tornado is of means: of the output over the runs whose input lies in its lowest tenth, and in its highest tenth, while
the other inputs vary as they do. The interval of the change is Student's t with Welch's degrees of freedom and the
variance of the influence function ((y - m) [x in the tenth])/0.1, where m is the mean output at the end of the tenth:
this end is a quantile of the same runs, which Welch's variance leaves out. These are the conditional means of which
first Sobol' indices are the variance.
"""

from __future__ import annotations

from math import nan

import numpy as np

CONFIDENCE = 0.95
TENTH = 0.1


def standard_ranks(x: np.ndarray) -> np.ndarray:
    """The ranks of values (n,), equal ones sharing theirs, with mean 0 and length 1; NaN if all are equal."""
    from scipy.stats import rankdata

    ranks = rankdata(x) - 0.5 * (len(x) + 1)
    length = (ranks @ ranks) ** 0.5
    return ranks / length if length else np.full(len(x), nan)


def rank_interval(r: float, n: int) -> tuple[float, float]:
    """The 95 % interval of a rank correlation r of n independent runs."""
    from scipy.special import ndtri

    half = ndtri(0.5 + 0.5 * CONFIDENCE) * ((1.0 + 0.5 * r * r) / (n - 3)) ** 0.5 if n > 3 else np.inf
    with np.errstate(divide="ignore"):
        z = np.arctanh(min(max(r, -1.0), 1.0))  # rounding may leave r beyond 1
    return float(np.tanh(z - half)), float(np.tanh(z + half))


def tornado(x: np.ndarray, y: np.ndarray) -> dict[str, float]:
    """The tornado of outputs y (n,) over an input x (n,), by the names of `sensitivity`; none where the tenths of a
    discrete input are one."""
    from scipy.special import stdtrit

    ends = np.quantile(x, (TENTH, 1.0 - TENTH))
    if not ends[0] < ends[1]:
        return {}
    tenths = x <= ends[0], x >= ends[1]
    low, high = (float(y[tenth].mean()) for tenth in tenths)
    half = nan
    fewest = min(int(tenth.sum()) for tenth in tenths)
    if fewest > 1:
        own = np.array([y[tenth].var(ddof=1) / tenth.sum() for tenth in tenths])  # of the means
        if own.any():
            freedom = own.sum() ** 2 / sum(v * v / (tenth.sum() - 1) for v, tenth in zip(own, tenths, strict=True))
            below, above = (
                (y - _mean_at(x, y, end)) * tenth / tenth.mean() for end, tenth in zip(ends, tenths, strict=True)
            )
            variance = (above - below).var() / len(y) * fewest / (fewest - 1)
            half = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE) * variance**0.5)
    change = high - low
    return {
        "input_low": float(ends[0]), "input_high": float(ends[1]), "low": low, "high": high, "change": change,
        "change_low": change - half, "change_high": change + half,
    }  # fmt: skip


def _mean_at(x: np.ndarray, y: np.ndarray, at: float) -> float:
    """The mean output where the input is so: a line through the n^0.6 nearest runs, or the mean of runs with just this
    input."""
    count = min(max(8, round(len(x) ** 0.6)), len(x))
    near = np.argpartition(abs(x - at), count - 1)[:count]
    t, own = x[near] - at, y[near]
    if not np.ptp(t) > 0.0:
        return float(own.mean())
    middle = t.mean()
    slope = (t - middle) @ own / ((t - middle) @ (t - middle))
    return float(own.mean() - slope * middle)
