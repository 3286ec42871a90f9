"""The times on which the steps of a run must land, so that a method keeps its order: where something jumps."""

from collections.abc import Iterator
from math import floor
from typing import TYPE_CHECKING, Any

from lienumba.compiler.jets import Jet, lift
from lienumba.expressions import Formula
from lienumba.mechanics.model import Law, Model

if TYPE_CHECKING:
    import numpy as np

SAME = 1e-9  # of a time: rounding


def landings(model: Model, end: float) -> "list[np.ndarray]":
    """The points of tables whose argument is a straight line in t, the times at which such lines are compared, and the
    samples of laws, of runs to this end: (n,) or (runs, n) each."""
    import numpy as np

    found = []
    for formula, numbers, state in _formulas(model):
        lines = [(line, numbers[name].knots) for name, line in formula.table_calls()]
        lines += [(line, (0.0,)) for line in formula.switches(state)]
        for line, knots in lines:
            if knots and line.is_line(state | {name for name in numbers if name in formula.tables}):
                with np.errstate(all="ignore"):
                    x = lift(line(Jet(0.0, 1.0), **{name: numbers[name] for name in line.used & numbers.keys()}))
                    a, b = (np.asarray(y, float)[..., None] for y in (x.a, x.b))
                    times = np.atleast_1d((np.array(knots) - a) / b)
                found.append(times[0] if times.ndim == 2 and len(times) == 1 else times)
    intervals = {force.code.every for force in model.forces if force.code is not None and force.code.every is not None}
    return found + [np.arange(1, floor(end / every * (1.0 + SAME)) + 1) * every for every in sorted(intervals)]


def _formulas(model: Model) -> Iterator[tuple[Formula, dict[str, Any], frozenset[str]]]:
    """Every formula that varies in time, its numbers and tables, and the names in it that are no numbers."""
    timed: list[Any] = [*model.gravity, *(q.value for q in model.quantities)]
    for driver in model.drivers:
        timed += driver.value
    for force in model.forces:
        for x in force.numbers.values():
            timed += x if isinstance(x, tuple) else (x,)
    for x in timed:
        if isinstance(x, Formula):
            yield x, {}, frozenset()
        elif isinstance(x, Law) and isinstance(x.function, Formula):
            yield x.function, x.numbers, frozenset(x.quantities)
