"""Bounds of a probability that hold at whatever run one stops to look: confidence sequences.

For a probability p0 the likelihood of k successes in n runs under p, over that under p0, is a nonnegative
supermartingale wherever the truth is at most p0 and p above it; so is its mean over a prior of such p. By Ville's
inequality it ever reaches 1/alpha with a probability of at most alpha: whoever rejects "at most p0" as soon as it does
is wrong no more often, after whichever run. Likewise from the other side. The prior is Jeffreys', cut at p0, so that
the means are ratios of beta functions. H. Robbins, Ann. Math. Statist. 41 (1970) 1397; S. R. Howard, A. Ramdas, J.
McAuliffe, J. Sekhon, Ann. Statist. 49 (2021) 1055.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    Numbers = float | np.ndarray

PRIOR = 0.5  # of Jeffreys, both exponents of the beta distribution
HALVINGS = 60  # of the interval in which a bound is searched


def evidence(k: Numbers, n: Numbers, p0: Numbers) -> tuple[Numbers, Numbers]:
    """The logarithms of the two means for k successes in n runs: against "at most p0", and against "at least p0"."""
    from scipy.special import betainc, betaincc, betaln

    a, b = PRIOR + k, PRIOR + n - k
    whole = betaln(a, b) - betaln(PRIOR, PRIOR) - k * np.log(p0) - (n - k) * np.log1p(-p0)
    with np.errstate(divide="ignore"):  # what is no evidence at all
        above, below = (np.log(part(a, b, p0) / part(PRIOR, PRIOR, p0)) for part in (betaincc, betainc))
    return whole + above, whole + below


def shown(k: float, n: float, p0: float, confidence: float) -> tuple[bool, bool]:
    """Whether k successes in n runs show that the probability is above p0, and that it is below."""
    enough = -np.log1p(-confidence)
    above, below = evidence(k, n, p0)
    return bool(above >= enough), bool(below >= enough)


def bounds(k: float, n: float, confidence: float) -> tuple[float, float]:
    """The least and the largest probability that k successes in n runs leave: each holds at all n together with the
    confidence. Of no runs they are 0 and 1."""
    if not n:
        return 0.0, 1.0
    estimate = k / n
    ends = []
    for side, far in ((0, 0.0), (1, 1.0)):
        refused, kept = far, estimate
        for _ in range(HALVINGS):
            middle = 0.5 * (refused + kept)
            if 0.0 < middle < 1.0 and shown(k, n, middle, confidence)[side]:
                refused = middle
            else:
                kept = middle
        ends.append(refused)
    return ends[0], ends[1]
