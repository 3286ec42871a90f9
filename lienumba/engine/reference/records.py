"""What the engine "numba" stores, as records of the dataset: everything that is computed from a stored state, its
accelerations and its multipliers."""

from collections.abc import Callable
from typing import Any

import numpy as np

from lienumba.groups.state import ALGEBRA, ELEMENT
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.tracing.augmented_state import AugmentedState
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.observed import said
from lienumba.integrators.tracing.program import Outline
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.system.kkt import Structure
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, Observation
from lienumba.reference.mechanism import Records

Named = dict[str, list[Any]]


def records_of(
    model: Model,
    runs: np.ndarray,
    stored: Records,
    h: float,
    angles: dict[int, int],
    observe: Callable[[Model, Instant, list[Any], list[Any]], Named],
) -> tuple[np.ndarray, dict[str, tuple[int, int]]]:
    """Records (1, outputs, rows, N) as `lienumba.batch.records` reads them, and the first row and the size of each
    variable that is computed; runs (N,): indices; h: the step in s; angles: the coordinate of each joint whose turns
    are counted."""
    k, shape = len(model.bodies), (len(stored.steps), len(runs))
    states = stored.states[:, : ELEMENT * k]
    rows = _rows(states)
    bodies = tuple(tuple(rows[ELEMENT * i : ELEMENT * (i + 1)]) for i in range(k))
    near, times = _rows(stored.near), np.repeat(stored.steps * h, len(runs))
    now = Instant(bodies, times, {joint: near[n] for joint, n in angles.items()})
    with np.errstate(all="ignore"):  # runs that have ended are NaN
        every = _of_runs(model, np.tile(runs, len(stored.steps)))
        named = observe(every, now, _rows(stored.accelerations), _rows(stored.multipliers))
    places: dict[str, tuple[int, int]] = {}
    found: list[np.ndarray] = []
    for name, numbers in named.items():
        places[name] = (len(found), len(numbers))
        found += [np.broadcast_to(np.asarray(x, float), times.shape).reshape(shape) for x in numbers]
    seen = np.where(np.isnan(stored.work)[:, None], np.nan, np.array(found).reshape(-1, *shape).swapaxes(0, 1))
    return np.concatenate([states, stored.work[:, None], seen, stored.iterations], axis=1)[None], places


def _rows(records: np.ndarray) -> list[np.ndarray]:
    """Records (outputs, rows, N) row by row, each for all outputs and runs."""
    return [records[:, n].reshape(-1) for n in range(records.shape[1])]


def observer(structure: Structure, reactions: bool) -> Callable[[Model, Instant, list[Any], list[Any]], Named]:
    """What computes the numbers of every variable of stored states; structure: of all constraint rows; reactions:
    whether forces of joints and drivers are stored."""

    def observe(model: Model, now: Instant, accelerations: list[Any], multipliers: list[Any]) -> Named:
        seen = Observation(model, now, lambda: said(structure, model, now, accelerations, multipliers))
        variables = {name: x.rows for name, x in OUTPUT_VARIABLES.items() if reactions or not x.reaction}
        named = {name: list(rows(seen)) for name, rows in variables.items() if rows is not None}
        return named | dict(quantities.observe(model, now, seen.observed))

    return observe


def outline_of(bodies: int, stages: int, observed: dict[str, tuple[int, int]]) -> Outline:
    """Where rows of a record lie: the bodies, the work, and what is observed of them."""
    rows = sum(count for _, count in observed.values())
    sizes = Sizes(bodies, 1, 1, 0, 0, ALGEBRA, stages, 0, 0, 0, observed=rows)
    return Outline(sizes, AugmentedState((), True, 0, (), {}), LawStates({}), (), observed, False, (), (), ())


def _of_runs(model: Model, runs: np.ndarray) -> Model:
    """The model with the numbers of these runs (indices)."""

    def part(x: Any) -> Any:
        return x.part(runs) if isinstance(x, RunNumbers) else x

    return map_numbers(model, lambda x, _: x[runs] if np.ndim(x) else x, part)
