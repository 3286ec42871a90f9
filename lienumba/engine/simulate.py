"""Simulates the runs of a scenario: prepared portion by portion, compiled once, dealt out in chunks, kept in memory."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from lienumba.batch.actions import at_events, plan
from lienumba.batch.execute import Cost, Task, execute, tasks
from lienumba.batch.integrate import Batch, Chunk, Pace
from lienumba.batch.statuses import GOOD
from lienumba.engine.fields import changes_told
from lienumba.engine.results import Piece, Results
from lienumba.groups.state import ELEMENT
from lienumba.integrators.codes import RESELECT
from lienumba.integrators.methods import METHODS, step_control
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.tracing import program as tracing
from lienumba.integrators.tracing.augmented_state import AugmentedState
from lienumba.integrators.tracing.compiled import Compiled, compiled
from lienumba.integrators.tracing.joint import states as joint_states
from lienumba.integrators.tracing.machine import Machine
from lienumba.integrators.tracing.program import Method, Outline, Program
from lienumba.integrators.tracing.row_selection import RowSelection, initial_selection
from lienumba.integrators.tracing.template import split
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.discontinuities import discontinuities
from lienumba.mechanics.system.kkt import Structure
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.mechanics.system.switches import permanent, switches_of
from lienumba.mechanics.tree.spanning import closing_rows
from lienumba.scenario.checks.integrator import order_of, relative_of
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.output import Output
from lienumba.scenario.schema.scenario import Absolute, Integrator, Tolerance
from lienumba.scenario.start.prepare import Nominal, Prepared, prepare
from lienumba.scenario.start.stored_start import start_numbers
from lienumba.store.layout import FULL
from lienumba.store.shards import LABEL

PORTION = 2**15  # runs of one body that are prepared at a time
# Where no first step is given: so much of the run, and no body turns further than this (rad); it is soon corrected.
FIRST_PART, FIRST_TURN = 1e-3, 0.01


@dataclass(frozen=True)
class Progress:
    """What a progress callable receives: the stage ("prepare", "compile" where needed, "run", "write"), and runs
    done and failed of total; those that go again are not yet done."""

    stage: str
    done: int
    total: int
    failed: int


Tell = Callable[[Progress], None]


@dataclass(frozen=True)
class Runs:
    """Runs to be simulated: labels (runs,), samples by path (runs,), and where the scenario starts."""

    labels: np.ndarray
    samples: dict[str, np.ndarray]
    nominal: Nominal

    def part(self, which: slice | np.ndarray) -> "Runs":
        return Runs(self.labels[which], {path: x[which] for path, x in self.samples.items()}, self.nominal)

    def portions(self, bodies: int) -> "Iterator[Runs]":
        size = max(PORTION // bodies, 64)
        for first in range(0, len(self.labels), size):
            yield self.part(slice(first, first + size))


# compute(runs, fixed, report) yields what these runs give, each once, in any order; fixed: see
# `lienumba.integrators.tracing.program.build`; report(runs done) is called a few times per second; begin() where
# something has to be compiled.
Compute = Callable[[Runs, bool, Callable[[float], None], Callable[[], None]], Iterator[Piece]]


def simulate(
    runs: Runs, tell: Tell, compute: Compute, before: tuple[int, int] = (0, 0)
) -> Generator[Piece, None, None]:
    """Yield the runs as they finish; of each the status is final. before: runs done and failed already."""
    (done, failed), remaining = before, runs
    total, told, waiting = done + len(runs.labels), done, 0  # waiting: how many are to go again

    def report(count: float) -> None:
        nonlocal told
        told = max(told, done + int(count) - waiting)
        tell(Progress("run", told, total, failed))

    def compiling() -> None:
        tell(Progress("compile", done, total, failed))

    for fixed in (True, False):  # the few runs that need other constraint rows on their way go again, with all of them
        again: list[np.ndarray] = []
        for piece in compute(remaining, fixed, report, compiling):
            going = piece.codes == RESELECT
            failed += int(np.count_nonzero(~np.isin(piece.codes, GOOD) & ~going))
            if going.any():
                again.append(piece.tables["run"][LABEL][going])
                waiting += int(np.count_nonzero(going))
                piece = piece.of(~going)
            yield piece
        if not again:
            return
        remaining = remaining.part(np.isin(remaining.labels, np.concatenate(again)))
        done, waiting = total - len(remaining.labels), 0


@dataclass(frozen=True)
class Threads:
    """Computes on threads of this process.

    results: what is kept of runs; prepared: where portions come from, if they are known.
    """

    results: Results
    workers: int
    prepared: Callable[[Runs], Iterable[Prepared]] | None = None

    def __call__(
        self, runs: Runs, fixed: bool, report: Callable[[float], None], begin: Callable[[], None]
    ) -> Iterator[Piece]:
        prepared = iter((self.prepared or partial(portions, self.results.resolved))(runs))
        first = next(prepared)  # a sweep of which no run can be prepared ends here, before anything is compiled
        every = chunks(self.results, chain([first], prepared), fixed, self.workers, report, begin)
        return execute(every, self.workers, report)


def portions(resolved: Scenario, runs: Runs) -> Iterator[Prepared]:
    data = resolved.data
    for portion in runs.portions(len(data.model.bodies)):
        yield prepare(resolved, portion.labels.tolist(), portion.samples, runs.nominal, len(runs.labels))


def chunks(
    results: Results,
    portions: Iterable[Prepared],
    fixed: bool,
    workers: int,
    report: Callable[[float], None],
    begin: Callable[[], None] = lambda: None,
) -> Iterator[Task[Piece]]:
    """The chunks of all portions; the first of these is what is compiled, where it is not yet."""
    resolved = results.resolved
    if resolved.data.integrator.engine is not None:
        from lienumba.engine.reference import runs as reference  # Numba takes half a second

        shaped = ((x, method_of(resolved, x.model), selection_of(resolved, x)) for x in portions)
        yield from reference.chunks(results, shaped, workers, begin)
        return
    program, cost = None, Cost()
    for prepared in portions:
        if program is None:
            program, machine = compiled_of(resolved, prepared, fixed, begin)
            report(0)
        batch = batch_of(resolved, prepared, program, machine)
        yield from tasks(batch, workers, partial(_piece, results, program, prepared, fixed), cost)


def _piece(results: Results, program: "Outline", prepared: Prepared, fixed: bool, chunk: "Chunk") -> Piece:
    if results.derivatives is not None:
        chunk = replace(chunk, tangents=results.derivatives.of(prepared, chunk.runs, chunk.codes, fixed))
    return results.piece(chunk, program, np.array(prepared.labels)[chunk.runs])


def by_joints(resolved: Scenario) -> bool:
    """Whether the coordinates of the joints are integrated."""
    return resolved.data.integrator.coordinates == JOINT


def selection_of(resolved: Scenario, prepared: Prepared) -> RowSelection:
    """Which of the redundant rows of constraints the program uses."""
    nominal = prepared.nominal
    exchangeable, lasting = nominal.lasting.exchangeable, permanent(nominal.model)
    if by_joints(resolved):
        closing = closing_rows(lasting)
        exchangeable = tuple(row for row in exchangeable if row in closing)
    selection = initial_selection(lasting, exchangeable, nominal.typical)
    return replace(selection, singular=nominal.singular)


def method_of(resolved: Scenario, model: Model) -> Method:
    """What beside the mechanism shapes the kernels of a scenario."""
    data = resolved.data
    integrator, projection, adaptive = data.integrator, data.projection, data.integrator.step is None
    method = METHODS[integrator.method]
    changes = bool(model.events or switches_of(model))
    queued = adaptive or changes or method.series or method.implicit
    return Method(
        tableau=integrator.method, position=projection.position, velocity=projection.velocity,
        dexpinv=integrator.dexpinv, chord=projection.chord, group=integrator.group, coordinates=integrator.coordinates,
        baumgarte=projection.baumgarte, queued=queued, adaptive=adaptive,
        reactions=_stores_reactions(data.output), joint_coordinates=data.output.joint_coordinates,
        order=order_of(integrator) or 0, rho=integrator.rho_infinity,
        extended=(queued or bool(resolved.parameters.measures)) and not method.series,
    )  # fmt: skip


def _stores_reactions(output: Output) -> bool:
    """Whether a variable of them is stored, or a component of it."""
    asked = {*output.variables, *(name.partition(".")[0] for name in (*output.summary, *output.at_events))}
    return any(variable.reaction and name in asked for name, variable in OUTPUT_VARIABLES.items())


def program_of(resolved: Scenario, prepared: Prepared, fixed: bool) -> Program:
    """The program of these runs; fixed: see `program.build`."""
    return tracing.build(prepared.model, method_of(resolved, prepared.model), selection_of(resolved, prepared), fixed)


def compiled_of(
    resolved: Scenario, prepared: Prepared, fixed: bool, begin: Callable[[], None] = lambda: None
) -> Compiled:
    """The program of these runs, and that as machine code; begin: see `compiled.compiled`."""
    return compiled(prepared.model, method_of(resolved, prepared.model), selection_of(resolved, prepared), fixed, begin)


def compile_early(
    resolved: Scenario, prepared: Prepared, fixed: bool, begin: Callable[[], None] = lambda: None
) -> None:
    """Compile the program of these runs before they are timed, if it is what integrates them."""
    if resolved.data.integrator.engine is None:
        compiled_of(resolved, prepared, fixed, begin)


def batch_of(resolved: Scenario, prepared: Prepared, program: Outline, machine: Machine) -> Batch:
    """The runs, ready to be executed."""
    data = resolved.data
    augmented = _augmented(resolved, prepared, program.augmented)
    if by_joints(resolved):
        states = [joint_states.start(prepared.model, program.law_states, len(prepared.states)), augmented]
    else:
        laws = program.law_states.start(prepared.model, len(prepared.states))
        states = [prepared.states, laws, augmented]
    return Batch(
        machine=machine,
        parameters=split(prepared.model)[1],
        states=np.concatenate(states, axis=1),
        codes=prepared.codes,
        end=data.integrator.end_time,
        h=data.integrator.step,
        outputs=np.unique([0.0, *resolved.times]),  # the start too: energies count from it
        tolerance=data.projection.tolerance,
        iterations=data.projection.max_iterations,
        discontinuities=tuple(discontinuities(prepared.model, data.integrator.end_time)),
        pace=_pace(data.integrator, prepared),
        plan=plan(prepared.model, program.held),
        changes=changes_told(prepared.model, data.output.max_changes),
        at_events=bool(data.output.at_events),
        kept_at_events=at_events(prepared.model) if prepared.model.measures else (),
        bodies=len(prepared.model.bodies),
        placed=prepared.states if by_joints(resolved) else None,
        rests=prepared.rests,
        starts=None if prepared.rests is None else start_numbers(prepared),
    )


def _pace(integrator: Integrator, prepared: Prepared) -> Pace | None:
    """How a tolerance chooses steps. If it is not given, the first one turns no body by more than a small angle."""
    tolerance = integrator.tolerance
    if tolerance is None:
        return None
    relative = relative_of(tolerance)
    absolute = tolerance.absolute.model_dump(exclude_none=True) if isinstance(tolerance, Tolerance) else {}
    kinds = Absolute.model_fields
    longest = integrator.max_step or integrator.end_time
    first = integrator.first_step
    if first is None:
        w = prepared.states.reshape(len(prepared.states), -1, ELEMENT)[:, :, 15:18]
        fastest = np.sqrt(w[..., 0] * w[..., 0] + w[..., 1] * w[..., 1] + w[..., 2] * w[..., 2]).max(axis=1)
        first = FIRST_PART * integrator.end_time
        first = np.minimum(first, FIRST_TURN / np.maximum(fastest, FIRST_TURN / first))
    return Pace(
        step_control.Tolerance(relative, **{kind: absolute.get(kind, relative) for kind in kinds}),
        np.minimum(first, longest), longest, integrator.min_step or 0.0,
    )  # fmt: skip


def _augmented(resolved: Scenario, prepared: Prepared, state: AugmentedState) -> np.ndarray:
    """What every run has beside its bodies and law states at the start (runs, rows)."""
    selection, runs = selection_of(resolved, prepared), len(prepared.states)
    if not prepared.nominal.singular:
        return state.start(prepared.angles, selection, runs)
    structure = Structure.of(prepared.model, (), selection.dropped)
    mask = [0.0 if row in selection.dropped else 1.0 for row in range(structure.rows)]
    bodies = tuple(tuple(body.T) for body in prepared.states.reshape(runs, -1, 18).transpose(1, 0, 2))
    now = Instant(bodies, 0.0, prepared.angles)
    from lienumba.mechanics.system.singular import limiting_accelerations

    with np.errstate(all="ignore"):
        last, rates = limiting_accelerations(prepared.model, structure, now, mask)
        if by_joints(resolved):
            last = joint_states.rate_changes(prepared.model, now, last)
            rates = [np.zeros(runs) for _ in last]
    return state.start(prepared.angles, selection, runs, [np.nan_to_num(a) for a in (*last, *rates)])


class Memory:
    """Keeps what runs give, for datasets that are not written and for the points of a study.

    arrays: what was taken, by variable, in the order of the labels; seconds: that cores were busy with it.
    """

    def __init__(self, labels: Sequence[int]) -> None:
        self.labels = np.asarray(labels, np.int64)
        self.arrays: dict[str, np.ndarray] = {}
        self.seconds = 0.0
        self._full: list[np.ndarray] = []

    def take(self, piece: Piece) -> None:
        self.seconds += piece.seconds
        records = piece.tables["run"]
        rows = positions(self.labels, records[LABEL])
        for name in _fields(records):
            if name not in self.arrays:
                self.arrays[name] = np.empty((len(self.labels), *records.dtype[name].shape), records.dtype[name].base)
            self.arrays[name][rows] = records[name]
        if FULL in piece.tables:
            self._full.append(piece.tables[FULL])

    def columns(self, kept: np.ndarray) -> dict[str, np.ndarray]:
        """Every column of every table, of the runs (a mask) that are kept."""
        arrays = self.arrays if kept.all() else {name: x[kept] for name, x in self.arrays.items()}
        if not self._full:
            return arrays
        records = np.concatenate(self._full)
        records = records[np.isin(records[LABEL], self.labels[kept])]
        records = records[np.argsort(positions(self.labels, records[LABEL]))]
        return arrays | {name: np.ascontiguousarray(records[name]) for name in _fields(records)}

    def column(self, name: str, labels: np.ndarray) -> np.ndarray:
        """The values of a variable of these runs."""
        return self.arrays[name][positions(self.labels, labels)]


def _fields(records: np.ndarray) -> list[str]:
    names: Any = records.dtype.names
    return [name for name in names if name != LABEL]


def positions(labels: np.ndarray, some: np.ndarray) -> np.ndarray:
    """Where each of some labels stands among all."""
    order = np.argsort(labels, kind="stable")
    found: np.ndarray = order[np.searchsorted(labels, some, sorter=order)]
    return found
