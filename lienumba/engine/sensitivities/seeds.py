"""How the start of runs, and the numbers of their model, change with each input.

What leads from inputs to a start is no motion yet: formulas, rotations, the assembly of joints, an equilibrium. Its
derivative is a difference of sixth order, of starts alone: errors near 1e-12 of what it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lienumba.batch.integrate import COINCIDENT, Batch, begin, discontinuities
from lienumba.batch.statuses import SUCCESS
from lienumba.batch.tangents.marcher import Start
from lienumba.engine.programs import batch_of, method_of, selection_of
from lienumba.integrators.tracing.compiled import compiled
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.mechanics.mechanism.tables import Numbers, RunNumbers
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal, Prepared, prepare

PLACES = np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])  # of a difference of sixth order, in steps,
WEIGHTS = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / 60.0  # and its weights
STEP = 1e-3  # of an input, relative to it
SMALLEST = 1e-6  # of the largest: an input that is smaller than this is 0 to a difference
ROUNDING = 1e-13  # of a number: what changes by less does not change


@dataclass(frozen=True)
class Starts:
    """Runs with the tangents of their starts.

    batch: of these runs alone; starts: of each; good (runs,): whether there is one; kept: what the addresses among the
    parameters of the starts lead to.
    """

    prepared: Prepared
    method: Method
    selection: RowSelection
    batch: Batch
    starts: list[Start]
    good: np.ndarray
    kept: Mapping[int, np.ndarray]

    @property
    def active(self) -> frozenset[int]:
        """The rows of the parameters that change with an input."""
        changed = [np.any(start.parameter_tangents != 0.0, axis=1) for start in self.starts]
        return frozenset(np.flatnonzero(np.any(changed, axis=0)).tolist()) if changed else frozenset()


def starts_of(
    resolved: Scenario, labels: Sequence[int], samples: Mapping[str, np.ndarray], by: Sequence[str], nominal: Nominal,
    fixed: bool,
) -> Starts:  # fmt: skip
    """The starts of these runs; samples (runs,): of all that varies, and of all inputs."""
    runs, copies = len(labels), 1 + len(PLACES) * len(by)
    steps = {path: _steps(samples[path]) for path in by}
    every = {path: np.repeat(x[:, None], copies, axis=1) for path, x in samples.items()}
    for n, path in enumerate(by):
        own = slice(1 + len(PLACES) * n, 1 + len(PLACES) * (n + 1))
        every[path][:, own] += PLACES * steps[path][:, None]
    flat = {path: np.ascontiguousarray(x.reshape(-1)) for path, x in every.items()}
    repeated = [label for label in labels for _ in range(copies)]
    prepared = prepare(resolved, repeated, flat, nominal, len(repeated))
    method, selection = method_of(resolved, prepared.model), selection_of(resolved, prepared)
    if not fixed:  # what a queue goes through is noted with its selections of rows
        method = replace(method, queued=True, extended=True)
    program, machine = compiled(prepared.model, method, selection, fixed)
    batch = batch_of(resolved, prepared, program, machine)
    own_numbers = {n: p.part(slice(0, batch.runs)).rows() for n, p in enumerate(batch.parameters) if _has_many(p)}
    states, rows = begin(batch, slice(0, batch.runs), machine.sizes.parameters, own_numbers)
    states, rows = (x.transpose(0, 2, 1).reshape(-1, x.shape[1])[: batch.runs] for x in (states, rows))
    rows = rows[:, : len(batch.parameters)]
    tables = [n for n, p in enumerate(batch.parameters) if isinstance(p, Numbers) or _has_many(p)]
    jumps = np.concatenate(
        [np.zeros((batch.runs, 0)), *(x.part(slice(0, batch.runs)).times(batch.runs) for x in batch.discontinuities)],
        axis=1,
    )
    starts = []
    for run in range(runs):
        mine = slice(copies * run, copies * (run + 1))
        changes = np.stack([steps[path][run] for path in by]) if by else np.zeros(0)
        parameter_tangents = differences(rows[mine], changes)
        parameter_tangents[tables] = 0.0
        first = mine.start
        given = discontinuities(batch, slice(first, first + 1), 1)[0, :-1, 0]
        known = np.flatnonzero((jumps[first] > 0.0) & (jumps[first] <= batch.end * (1.0 + COINCIDENT)))
        known = known[np.argsort(jumps[first, known], kind="stable")][: len(given)]
        moved = differences(np.where(np.isfinite(jumps[mine]), jumps[mine], 0.0), changes)[known]
        starts.append(
            Start(states[first], rows[first], given, differences(states[mine], changes), parameter_tangents, moved)
        )
    codes = prepared.codes.reshape(runs, copies)
    base = batch.part(np.arange(0, batch.runs, copies))
    return Starts(prepared, method, selection, base, starts, (codes == SUCCESS).all(axis=1), own_numbers)


def _has_many(parameter: object) -> bool:
    return isinstance(parameter, RunNumbers)


def _steps(values: np.ndarray) -> np.ndarray:
    """The steps of the differences."""
    sizes = np.abs(values)
    largest = sizes.max(initial=0.0)
    return STEP * np.where(sizes > SMALLEST * largest, sizes, largest or 1.0)


def differences(rows: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Derivatives (rows, inputs) of what a run has (copies, rows): first as it is, then moved along each input."""
    moved = rows[1:].reshape(len(steps), len(PLACES), rows.shape[1])
    with np.errstate(invalid="ignore"):
        changes = np.einsum("k,ikr->ri", WEIGHTS, moved - rows[0])
        noise = ROUNDING * np.abs(rows[0])[:, None]
        tangents: np.ndarray = np.where(np.abs(changes) > noise, changes, 0.0) / steps
    return tangents
