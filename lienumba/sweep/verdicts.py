"""Whether runs show that a requirement is met: as large a part of all runs as is wanted, with the confidence wanted.

A verdict asks one bound at a time: the part that meets it is at least so large (met), or at most (not met), each with
the confidence. Bounds are those of Clopper and Pearson. With weights of runs (n,) they are those of the effective
number of runs (`weighted.runs_that_tell`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from math import floor, log10
from typing import Any

import numpy as np

from lienumba.sweep import confidence, weighted
from lienumba.words import plural

MET, NOT_MET, OPEN = "met", "not met", "not enough runs"
MOST = 1e12  # runs that anybody would ask for


@dataclass(frozen=True)
class Wanted:
    """A requirement as statistics see it: its name, and which part of all runs shall meet it, with which confidence."""

    name: str
    probability: float
    confidence: float


@dataclass(frozen=True)
class Verdict:
    """Of a requirement. verdict: "met", "not met" or "not enough runs"; runs: that count, of which so many passed;
    part: of these, by their weights; at_least, at_most: bounds of the probability to meet it, each with the confidence;
    more_runs: about how many more would decide it if the part stays as it is, 0 if it is decided, None if none would;
    fewest_more: how many more there must be at least before it can be met; margin: the tolerance bound, which so large
    a part of all runs as is wanted keeps with the confidence, None of too few runs; effective: the effective number of
    runs of a mean, None if they have no weights."""

    requirement: str
    verdict: str
    runs: int
    passed: int
    probability: float
    confidence: float
    part: float
    at_least: float
    at_most: float
    more_runs: int | None
    fewest_more: int | None
    margin: float | None
    effective: float | None = None

    @property
    def met(self) -> bool:
        return self.verdict == MET

    @property
    def failed(self) -> int:
        return self.runs - self.passed

    def to_dict(self) -> dict[str, Any]:
        """Plain keys and values."""
        return asdict(self)

    def sentence(self) -> str:
        """The verdict and what it is from."""
        wanted, sure = percent(self.probability), f"{100 * self.confidence:g} % confidence"
        count = f"{self.failed:,} of {plural(self.runs, 'run', 'runs')} failed it" if self.runs else "no run counts"
        low, high = percent(self.at_least, floor_=True), percent(self.at_most, floor_=False)
        named = f'"{self.requirement}"'
        if self.verdict == MET:
            return f"{named} is met: at least {low} of all runs meet it with {sure}, {wanted} are wanted; {count}"
        if self.verdict == NOT_MET:
            return f"{named} is not met: at most {high} of all runs meet it with {sure}, {wanted} are wanted; {count}"
        return (
            f"{named} is not decided: {low} to {high} of all runs meet it, {wanted} are wanted; {count}; {self.advice}"
        )

    @property
    def advice(self) -> str:
        """How many more runs would decide it; empty if it is decided."""
        if self.verdict != OPEN:
            return ""
        least = f"it takes at least {self.fewest_more:,} more before it can be met" if self.fewest_more else ""
        if self.more_runs is None or not self.runs:
            return least or "more runs decide it only if the part that meets it changes"
        about = f"about {_rounded(self.more_runs):,} more would decide it if this part stays"
        return f"{about}; {least}" if least else about


def judge(wanted: Wanted, met: np.ndarray, margin: np.ndarray, weights: np.ndarray | None = None) -> Verdict:
    """Return the verdict on runs of which each meets it (1), does not (0), or does not count (NaN), with its margin
    (n,)."""
    counts = np.isfinite(met)
    met, margin = met[counts], np.where(np.isnan(margin[counts]), -np.inf, margin[counts])
    own = None if weights is None else weights[counts]
    n, rule = len(met), _Rule(wanted)
    passed, tells = _counted(met, own)
    low, high = rule.bounds(passed, tells)
    verdict = rule.shown(passed, tells) or OPEN
    each = n / tells if tells else 1.0  # runs for one that tells as much without weights
    more, fewest = (0, 0) if verdict != OPEN else (rule.more(passed, tells), rule.fewest(passed, tells))
    more, fewest = (x if x is None or own is None else int(np.ceil(x * each)) for x in (more, fewest))
    return Verdict(
        wanted.name, verdict, n, int(np.count_nonzero(met)), wanted.probability, wanted.confidence,
        passed / tells if tells else float("nan"), low, high, more, fewest,
        _kept(margin, met, lambda kept: rule.shown(*_counted(kept.astype(float), own)) == MET),
        None if own is None or not own.any() else weighted.effective(own),
    )  # fmt: skip


def _counted(true: np.ndarray, weights: np.ndarray | None) -> tuple[float, float]:
    """Of how many of how many runs something is true (n,: 1 or 0), of runs with weights as many as tell as much."""
    if weights is None or not len(true):
        return float(np.count_nonzero(true)), float(len(true))
    if not weights.any():
        return float("nan"), float(len(true))
    tells = weighted.runs_that_tell(true, weights)
    return weighted.share(true, weights) * tells, tells


def _kept(margin: np.ndarray, met: np.ndarray, shown: Callable[[np.ndarray], bool]) -> float | None:
    """The largest margin of which it is shown that so large a part of all runs keeps it, as the verdict is: that of the
    runs (n,) that meet it is asked of first, so that it is good where they show enough, and only there."""
    every, meets = np.unique(margin), margin[met > 0.0]
    limit = int(np.searchsorted(every, meets.min())) if len(meets) else len(every)
    keep = limit < len(every) and shown(margin >= every[limit])
    low, high = (limit, len(every)) if keep else (-1, limit)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if shown(margin >= every[middle]) else (low, middle)
    return float(every[low]) if low >= 0 and np.isfinite(every[low]) else None


@dataclass(frozen=True)
class _Rule:
    """What runs show, and the bounds of it."""

    wanted: Wanted

    def shown(self, k: float, n: float) -> str | None:
        """Whether k of n runs that meet it show that it is met, or that it is not; None: neither."""
        low, high = self.bounds(k, n)
        return MET if low >= self.wanted.probability else NOT_MET if high < self.wanted.probability else None

    def bounds(self, k: float, n: float) -> tuple[float, float]:
        low, high = confidence.bounds(k, n, self.wanted.confidence) if n else (0.0, 1.0)
        return float(low), float(high)

    def more(self, k: float, n: float) -> int | None:
        """How many more runs would decide it if the part stays as it is."""
        if not n or k / n == self.wanted.probability:
            return None
        return _smallest(n, lambda runs: self.shown(k * runs / n, runs) is not None)

    def fewest(self, k: float, n: float) -> int | None:
        """How many more runs there must be, all of which meet it, before it is met."""
        return _smallest(n, lambda runs: self.shown(k + runs - n, runs) == MET)


def _smallest(n: float, enough: Callable[[float], bool]) -> int | None:
    """How many runs more than n are enough, if more runs stay enough; None: more than anybody would ask for."""
    high = max(2.0 * n, 16.0)
    while not enough(high):
        high *= 2.0
        if high > MOST:
            return None
    low, top = 0, int(np.ceil(high - n))
    while top - low > 1:
        middle = (low + top) // 2
        low, top = (low, middle) if enough(n + middle) else (middle, top)
    return top


def percent(x: float, floor_: bool | None = None) -> str:
    """A probability in percent, with three digits of what it misses to 0 or 100 %; rounded down, up, or to the
    nearest."""
    if x != x:
        return "-"
    rest = min(x, 1.0 - x)
    if rest < 1e-12:
        return f"{100 * round(x):g} %"
    decimals = max(0, 2 - floor(log10(100 * rest)))
    unit = 10.0**-decimals
    scaled = 100 * x / unit
    whole = round(scaled) if floor_ is None or abs(scaled - round(scaled)) < 1e-6 else floor(scaled) + (not floor_)
    return f"{whole * unit:.{decimals}f}".rstrip("0").rstrip(".") + " %" if decimals else f"{whole:g} %"


def _rounded(n: int) -> int:
    """Two digits of it, upwards."""
    unit = 10 ** max(len(str(n)) - 2, 0)
    return -(-n // unit) * unit
