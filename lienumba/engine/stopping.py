"""Ends a sweep where it has runs enough: decided after every so many runs in the order of their labels, whatever order
they finish in, so that the same sweep always ends at the same run."""

from collections.abc import Generator, Iterator
from math import inf
from typing import Any

import numpy as np

from lienumba.engine.requirements import Column
from lienumba.engine.results import Piece, Results
from lienumba.errors import BadValueError, ScenarioError
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.sweep import Stop
from lienumba.store.layout import MET, WEIGHT
from lienumba.store.names import find_one
from lienumba.store.shards import LABEL
from lienumba.sweep import weighted
from lienumba.sweep.confidence import ranks
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.weighted import Interval


class Stopping:
    """Takes the runs of a sweep as they finish, of which there may be so many; `end`: how many of them are enough, None
    as long as that is not known; interval: of these. Without a rule there are never enough. at: of which variable, and
    where in it, the number is that the rule is about; weighted: whether runs have weights; independent: which runs
    count (runs,), all by default."""

    def __init__(
        self,
        rule: Stop | None,
        runs: int,
        nominal: bool,
        at: tuple[str, tuple[int, ...]] | None = None,
        weighted: bool = False,
        independent: np.ndarray | None = None,
    ) -> None:
        self.rule = rule
        self.variable, self.place = at or ("" if rule is None else rule.variable, ())
        self._waiting = nominal  # for the nominal run, which is not counted
        self.end: int | None = None
        self.interval: Interval | None = None
        self._values = np.full(runs if rule else 0, np.nan)
        self._weights = self._values.copy() if weighted else None
        self._known = np.zeros(len(self._values), bool)
        self._independent = ~self._known if independent is None else independent
        self._checked = 0

    def until(self, pieces: Generator[Piece, None, None]) -> Iterator[Piece]:
        """The pieces as they come, until there are enough."""
        for piece in pieces:
            yield piece
            if self.rule is not None:
                records = piece.tables["run"]
                values: Any = records[self.variable]
                weights = None if self._weights is None else records[WEIGHT]
                self._take(records[LABEL], values[(..., *self.place)], weights)
                if self.end is not None and not self._waiting:
                    pieces.close()
                    return

    def know(self, labels: np.ndarray, column: Column) -> None:
        """Take runs that are there already."""
        if self.rule is not None and len(labels):
            weights = None if self._weights is None else column(WEIGHT, labels)
            values: Any = column(self.variable, labels)
            self._take(labels, values[(..., *self.place)], weights)

    def kept(self, labels: np.ndarray) -> np.ndarray:
        """Which of these runs are among those that are enough (runs,)."""
        return labels < (self.end if self.end is not None else inf)

    def decided(self, labels: np.ndarray) -> int:
        """How many of these runs (labels, ascending) are kept for sure."""
        return len(labels) if self.rule is None else int(np.searchsorted(labels, self._checked))

    def attributes(self) -> dict[str, str]:
        """What the dataset says of it."""
        return {"stopped": self.sentence()} if self.end is not None else {}

    def _take(self, labels: np.ndarray, values: np.ndarray, weights: np.ndarray | None) -> None:
        assert self.rule is not None
        self._waiting = self._waiting and not (labels < 0).any()
        own = (labels >= 0) & (labels < len(self._values))
        self._values[labels[own]] = values[own]
        if self._weights is not None and weights is not None:
            self._weights[labels[own]] = weights[own]
        self._known[labels[own]] = True
        while self.end is None and self._checked + self.rule.every <= len(self._values):
            upto = self._checked + self.rule.every
            if not self._known[self._checked : upto].all():
                break
            self._checked = upto
            counts = np.flatnonzero(self._independent[:upto])
            if self._enough(self._values[counts], None if self._weights is None else self._weights[counts]):
                self.end = upto

    def _enough(self, values: np.ndarray, weights: np.ndarray | None) -> bool:
        """Whether these runs are enough."""
        assert self.rule is not None
        counting = np.where(values < 0.0, np.nan, values) if self.variable == MET else values
        self.interval = interval(counting, self.rule, weights)
        return self.interval.width <= self.rule.width

    def sentence(self) -> str:
        """What made it end."""
        assert self.rule is not None
        assert self.interval is not None
        rule, found = self.rule, self.interval
        what = "mean" if rule.statistic == "mean" else f"{100 * (rule.probability or 0):g} % quantile"
        return (
            f"enough after {self.end:,} runs: the {what} of {rule.variable} is {found.value:.6g}, "
            f"from {found.low:.6g} to {found.high:.6g} with a confidence of {100 * rule.confidence:g} %"
        )


def stopping_of(resolved: Scenario, results: Results) -> Stopping:
    """The rule of a scenario; a ScenarioError if it is about nothing of which each run has one number."""
    data = resolved.data
    rule = data.sweep.stop
    if rule is None:
        return Stopping(rule, data.sweep.runs, data.sweep.nominal)
    drawn = sum(kind.dimensions > 0 for kind in data.sweep.vary.values())
    independent = SAMPLERS[data.sweep.sampler].counting(np.arange(data.sweep.runs), drawn)
    try:
        found = find_one(rule.variable, results.names)
    except BadValueError as error:
        raise ScenarioError(error.at("sweep.stop.variable", rule.variable)) from None
    place = found.variable, found.place
    return Stopping(rule, data.sweep.runs, data.sweep.nominal, place, resolved.weighted, independent)


def interval(values: np.ndarray, rule: Stop, weights: np.ndarray | None = None) -> Interval:
    """The confidence interval over the runs that have a value: by Student's t of a mean, by the binomial distribution
    of the ranks of a quantile, which assumes nothing of how values are distributed; with weights see `weighted`. Means
    are of finite values; a quantile may be an infinite one (a margin of what never happens)."""
    known = np.isfinite(values) if rule.statistic == "mean" else ~np.isnan(values)
    x = values[known]
    if rule.statistic == "mean":
        return weighted.mean(x, np.ones(len(x)) if weights is None else weights[known], rule.confidence)
    assert rule.probability is not None
    if weights is not None:
        return weighted.quantile(x, weights[known], rule.probability, rule.confidence)
    x = np.sort(x)
    if len(x) < 2:
        return Interval(np.nan, -inf, inf)
    low, high = map(int, ranks(len(x), rule.probability, rule.confidence))
    with np.errstate(invalid="ignore"):
        value = float(np.quantile(x, rule.probability))
    return Interval(
        value if np.isfinite(value) else float(np.quantile(x, rule.probability, method="nearest")),
        float(x[low]) if low >= 0 else -inf,
        float(x[high]) if high < len(x) else inf,
    )
