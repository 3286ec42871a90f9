"""What every contestant simulates: a scenario with runs that differ, and the same equations written out for heyoka."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.prepare import Prepared, prepare

Array = np.ndarray


@dataclass(frozen=True)
class Form:
    """One way of writing the equations.

    equations(hy): pairs of a state and its rate, with `hy.par`; states, parameters: one row for each (rows, runs), at
    the start, in extended precision; centres(states, parameters, t): of all bodies (bodies, 3, runs), m, global axes;
    long: whether its code without loops compiles for long.
    """

    key: str
    label: str
    equations: Callable[[Any], list[tuple[Any, Any]]]
    states: Array
    parameters: Array
    centres: Callable[[Array, Array, Any], Array]
    long: bool = False


@dataclass(frozen=True)
class Problem:
    """data: the scenario with its sweep; the first of the forms gives the reference."""

    key: str
    label: str
    data: Mapping[str, Any]
    end: float
    runs: int
    forms: Sequence[Form]


def started(data: Mapping[str, Any], runs: int) -> Prepared:
    """The samples and the start of a scenario."""
    return prepare(resolve(data), list(range(runs)))


def rows(runs: int, *values: Any) -> Array:
    """Numbers, or one for each run, as rows in extended precision."""
    return np.stack([np.broadcast_to(np.asarray(x, np.longdouble), (runs,)) for x in values])
