"""The times on which steps of a run must end, so that a method keeps its order: where something jumps."""

from collections.abc import Iterator, Mapping
from math import floor
from typing import Any, NamedTuple

import numpy as np

from lienumba.mechanics.mechanism.model import Law, Model
from lienumba.mechanics.tolerances import (
    MAX_WHOLE_NUMBERS,
    SAME_TIME_RTOL,
)
from lienumba.numerics.expressions import Formula
from lienumba.numerics.jets import Jet, lift


class Discontinuity(NamedTuple):
    """The times at which a + b t reaches any of these knots; a and b are floats, or arrays (runs,)."""

    knots: np.ndarray
    a: Any = 0.0
    b: Any = 1.0

    def part(self, runs: "slice | np.ndarray") -> "Discontinuity":
        """The discontinuity of some of the runs (indices or a slice)."""
        return Discontinuity(self.knots, *(x[runs] if hasattr(x, "shape") and x.shape else x for x in (self.a, self.b)))

    def times(self, runs: int) -> np.ndarray:
        """(runs, n), in s; not finite where it never gets there."""
        a, b = (np.broadcast_to(x, (runs,))[:, None] for x in (self.a, self.b))
        with np.errstate(all="ignore"):
            times: np.ndarray = (self.knots - a) / b
        return times


def discontinuities(model: Model, end: float) -> list[Discontinuity]:
    """The points of tables whose argument is a straight line in t, the times at which such lines are compared, by
    laws, measures and events that act, or reach the whole numbers at which functions jump, and the samples of laws, of
    runs to this end."""
    found = []
    for formula, numbers, state, chooses in _formulas(model):
        lines = [(line, numbers[name].knots) for name, line in formula.table_calls()]
        lines += [(line, (0.0,)) for line in (formula.switches(state) if chooses else [])]
        for line, knots in lines:
            if knots and line.is_line(state | {name for name in numbers if name in formula.tables}):
                found.append(Discontinuity(np.array(knots), *line_of(line, numbers)))
        for line in formula.wholes(state):
            a, b = line_of(line, numbers)
            if (knots := _whole_numbers(a, b, end)).size:
                found.append(Discontinuity(knots, a, b))
    intervals = {force.code.every for force in model.forces if force.code is not None and force.code.every is not None}
    samples = [np.arange(1, floor(end / every * (1.0 + SAME_TIME_RTOL)) + 1) * every for every in sorted(intervals)]
    return found + [Discontinuity(times) for times in samples]


def line_of(line: Formula, numbers: Mapping[str, Any]) -> tuple[Any, Any]:
    """a and b of a straight line a + b t."""
    with np.errstate(all="ignore"):
        x = lift(line(Jet(0.0, 1.0), **{name: numbers[name] for name in line.used & numbers.keys()}))
    return x.a, x.b


def _whole_numbers(a: Any, b: Any, end: float) -> np.ndarray:
    """The whole numbers that a + b t reaches until the end in any run; none where they are too many to land on."""
    with np.errstate(all="ignore"):
        ends = np.stack(np.broadcast_arrays(a, a + b * end))
    ends = ends[:, np.isfinite(ends).all(axis=0)] if ends.ndim > 1 else ends[np.isfinite(ends)]
    if not ends.size or not np.ptp(ends) < MAX_WHOLE_NUMBERS:
        return np.empty(0)
    return np.arange(np.floor(ends.min()), np.ceil(ends.max()) + 1.0)


def _formulas(model: Model) -> Iterator[tuple[Formula, dict[str, Any], frozenset[str], bool]]:
    """Every formula that varies in time, its numbers and tables, the names in it that are no numbers, and whether
    something jumps where it compares: the conditions of measures are found where they turn, as those of events are."""
    timed: list[Any] = [*model.gravity, *(q.value for q in model.quantities)]
    timed += [event.when for event in model.events if event.acts]
    for driver in model.drivers:
        timed += driver.value
    for numbers in (*(force.numbers for force in model.forces), *(q.numbers for q in model.quantities)):
        for x in numbers.values():
            timed += x if isinstance(x, tuple) else (x,)
    measured = [x for measure in model.measures for x in measure.signals]
    for n, x in enumerate([*timed, *measured]):
        if isinstance(x, Formula):
            yield x, {}, frozenset(), n < len(timed) or not x.condition
        elif isinstance(x, Law) and isinstance(x.function, Formula):
            yield x.function, x.numbers, frozenset(x.quantities), n < len(timed) or not x.function.condition
