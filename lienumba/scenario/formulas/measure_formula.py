"""A formula of a whole run, taken apart: what has to be kept while the run goes on, and the arithmetic at its end."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lienumba.mechanics.mechanism.model import FIRST, LAST, Kept, Measure, Timed
from lienumba.numerics.expressions import Formula

NEVER = {FIRST: np.inf, LAST: -np.inf}
VALUE, WHEN = "value", "time"  # what is known of what is kept, as the outer formula names it


class MeasureFormula(NamedTuple):
    """text: as it is written; signals: formulas of quantities, parameters and t, some of them conditions; kept: of
    these; outer: the number that it is, of names such as `kept[0].value`."""

    text: str
    signals: tuple[Formula, ...]
    kept: tuple[Kept, ...]
    outer: Formula

    @property
    def used(self) -> frozenset[str]:
        """The names of parameters, tables and quantities that it depends on."""
        return frozenset().union(*(signal.used for signal in self.signals))

    def to_model(self, number: Callable[[Formula], Timed]) -> Measure:
        """What the model keeps of it; number: what a formula is with the parameters of the runs."""
        return Measure(tuple(map(number, self.signals)), self.kept)

    @property
    def times(self) -> bool:
        """Whether it depends on when a condition holds first or last."""
        kinds = {name_of(n, WHEN): kept.kind for n, kept in enumerate(self.kept)}
        return any(kinds.get(name) in NEVER for name in self.outer.used)

    def number(self, rows: np.ndarray) -> np.ndarray:
        """What it is in each run, of what was kept (runs, kept, 2), whose times are infinite where there was none; NaN
        where that is undefined. What never holds does so first later than at any time, and last earlier."""
        names = {}
        for n, kept in enumerate(self.kept):
            value, time = rows[:, n, 0], rows[:, n, 1]
            names[name_of(n, VALUE)] = value
            names[name_of(n, WHEN)] = np.where(np.isinf(time), NEVER.get(kept.kind, np.nan), time)
        with np.errstate(all="ignore"):
            found = self.outer(0.0, **{name: x for name, x in names.items() if name in self.outer.used})
        return np.broadcast_to(np.asarray(found, float), (len(rows),))


def name_of(n: int, what: str) -> str:
    """The name in outer formulas of what is known of something that is kept."""
    return f"kept[{n}].{what}"
