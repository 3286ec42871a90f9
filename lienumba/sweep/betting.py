"""Bounds of the mean of numbers from 0 to a largest one that hold at whatever run one stops to look.

Whoever bets a part c of his money on "the mean is below q", at odds that are fair where it is q, has after each number
x so many times as much as 1 - c + c (1 - x/most)/(1 - q/most); on "above q", 1 - c + c x/q. Where he is wrong that is a
nonnegative supermartingale, and so is its mean over several c: it ever reaches 1/alpha with a probability of at most
alpha (Ville). It grows with q, or falls, for any numbers, so that what is refused is an interval. Of x that are 0 or
`most` it is the ratio of likelihoods of `sequential`, and nearly so is the prior. I. Waudby-Smith, A. Ramdas, J. R.
Stat. Soc. B 86 (2024) 1.
"""

from __future__ import annotations

import numpy as np

EDGES = np.linspace(-14.0, 6.0, 61)  # of the logits of c
TOGETHER = 16  # factors whose product is taken before its logarithm
HALVINGS = 50  # of the interval in which a bound is searched


def _prior(of_rest: bool) -> tuple[np.ndarray, np.ndarray]:
    """Parts c that are bet, and the logarithms of how much money is bet so: the roots of c are spread evenly, or of
    1 - c, as those of a probability near 0 are by Jeffreys."""
    middles = 0.5 * (EDGES[1:] + EDGES[:-1])
    roots = (1.0 / (1.0 + np.exp(EDGES if of_rest else -EDGES))) ** 0.5
    roots[[0, -1]] = (1.0, 0.0) if of_rest else (0.0, 1.0)
    return 1.0 / (1.0 + np.exp(-middles)), np.log(abs(np.diff(roots)))


ABOVE, BELOW = _prior(False), _prior(True)


def gains(x: np.ndarray, most: float, q: float) -> tuple[np.ndarray, np.ndarray]:
    """What the logarithms of the money have grown by after numbers (n,), for each part (60,): of the bets on "above q",
    and on "below q"."""
    zeros, others = int(np.count_nonzero(x == 0.0)), x[x != 0.0] / most
    p = q / most
    found = []
    for (c, _), odds, none in ((ABOVE, others / p, 0.0), (BELOW, (1.0 - others) / (1.0 - p), 1.0 / (1.0 - p))):
        own = zeros * np.log1p(c * (none - 1.0))
        for first in range(0, len(odds), TOGETHER * 1024):
            some = odds[first : first + TOGETHER * 1024]
            whole = np.concatenate([some, np.ones(-len(some) % TOGETHER)]).reshape(TOGETHER, -1)
            own = own + np.log((1.0 + c * (whole[..., None] - 1.0)).prod(axis=0)).sum(axis=0)
        found.append(own)
    return found[0], found[1]


def evidence(above: np.ndarray, below: np.ndarray) -> tuple[float, float]:
    """The logarithms of the money of both bettors: against "at most q", and against "at least q"."""
    mixed = (gain + share for gain, (_, share) in ((above, ABOVE), (below, BELOW)))
    one, other = (float(np.logaddexp.reduce(x)) for x in mixed)
    return one, other


def bounds(x: np.ndarray, most: float, confidence: float) -> tuple[float, float]:
    """The least and the largest mean that numbers (n,) leave, of those from 0 to 1: each holds at all n together with
    the confidence."""
    enough, ends = -np.log1p(-confidence), []
    estimate = min(float(x.mean()), 1.0) if len(x) else 0.5
    for side, far in ((0, 0.0), (1, 1.0)):
        refused, kept = far, estimate
        for _ in range(HALVINGS):
            middle = 0.5 * (refused + kept)
            if 0.0 < middle < 1.0 and evidence(*gains(x, most, middle))[side] >= enough:
                refused = middle
            else:
                kept = middle
        ends.append(refused)
    return ends[0], ends[1]
