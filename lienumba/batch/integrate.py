"""The runs of one chunk, from arrays by run to a driver's rows of lanes, and back."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from time import thread_time
from typing import Any, NamedTuple

import numpy as np

from lienumba.batch.records import per_run
from lienumba.batch.statuses import STOPPED
from lienumba.compiler.rows import W
from lienumba.integrators.drivers.trail import Trail
from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import (
    ACT_NUMBERS,
    KEPT_NUMBERS,
    KEPT_PEAK,
    KEPT_ROWS,
    KEPT_TIME,
    KEPT_UNDEFINED,
    KEPT_VALUE,
    NEWTON,
    SWITCH_NUMBERS,
    on_row,
    record_rows,
    state_rows,
)
from lienumba.integrators.methods.step_control import Tolerance
from lienumba.integrators.tracing.machine import (
    Machine,
    aligned,
    measure,
    observe,
    observe_events,
    place,
    prepare,
    read,
)
from lienumba.mechanics.mechanism.tables import Numbers, RunNumbers
from lienumba.mechanics.system.discontinuities import Discontinuity

COINCIDENT = 1e-9  # times nearer to each other than this fraction of a step are one
NO_TRAIL = Trail(np.empty((0, 0, 0)), np.zeros(0, np.int64))
NO_EVENTS = Plan(
    np.zeros(0, np.int64), np.zeros((0, ACT_NUMBERS), np.int64), np.zeros(0, np.int64),
    np.zeros((0, SWITCH_NUMBERS), np.int64), np.zeros((0, KEPT_NUMBERS), np.int64), np.zeros(0, np.int64),
    np.zeros(0, np.int64),
)  # fmt: skip
EXACT = Tolerance(*(1e-11,) * 6)  # of implicit stages in steps of one length
SKIPPED = -1.0  # the code of lanes behind the last run


@dataclass(frozen=True)
class Pace:
    """Of steps that a tolerance chooses: the first (s), one number or (runs,), the longest and the shortest."""

    tolerance: Tolerance
    first: Any
    longest: float
    shortest: float


@dataclass(frozen=True)
class Batch:
    """Everything the runs need.

    parameters: floats, arrays (runs,), a table's Numbers, or RunNumbers; states (runs, 18 k + augmented) at the start;
    codes (runs,): 0 for those to be integrated; end: of the runs (s); h: the length of steps (s), or None with a pace;
    outputs: the times to be stored (s), from 0 to the end; discontinuities: where steps must end;
    plan: what events do; changes: how many of a run are told; at_events: whether states at events are wanted;
    kept_at_events: see `actions.at_events`; bodies: how many; placed: their states at the start (runs, 18 k), where
    those of the moves are read from them; rests (runs,): the kinds of equilibria in which they start, if they do in
    such, and starts (runs, n): their numbers there; until: how far runs go (s), if not to their end; trail: where what
    they go through is noted, with a queue, if somebody asks.
    """

    machine: Machine
    parameters: list[Any]
    states: np.ndarray
    codes: np.ndarray
    end: float
    h: float | None
    outputs: np.ndarray
    tolerance: float
    iterations: int
    discontinuities: tuple[Discontinuity, ...] = ()
    pace: Pace | None = None
    plan: Plan = NO_EVENTS
    changes: int = 0
    at_events: bool = False
    kept_at_events: tuple[tuple[int, int, int], ...] = ()
    bodies: int = 0
    placed: np.ndarray | None = None
    rests: np.ndarray | None = None
    starts: np.ndarray | None = None
    until: float | None = None
    trail: Trail | None = None

    @property
    def last(self) -> float:
        """How far runs go (s): no step that begins there or later is made."""
        return self.end if self.until is None else self.until

    @property
    def runs(self) -> int:
        return len(self.states)

    @property
    def record_rows(self) -> int:
        """A state, what is observed of it, and the iterations of the two projections."""
        return record_rows(self.machine.sizes)

    def part(self, runs: np.ndarray) -> "Batch":
        """The batch of these runs (indices) alone."""
        pace = None if self.pace is None else replace(self.pace, first=_of(self.pace.first, runs))
        return replace(
            self,
            parameters=[_of(p, runs) for p in self.parameters],
            discontinuities=tuple(times.part(runs) for times in self.discontinuities),
            states=self.states[runs],
            placed=None if self.placed is None else self.placed[runs],
            codes=self.codes[runs],
            rests=None if self.rests is None else self.rests[runs],
            starts=None if self.starts is None else self.starts[runs],
            pace=pace,
        )


def _of(number: Any, runs: np.ndarray) -> Any:
    if isinstance(number, RunNumbers):
        return number.part(runs)
    return number[runs] if np.ndim(number) else number


@dataclass(frozen=True)
class Chunk:
    """Finished runs: records (blocks, outputs, rows, W), of which lanes behind the last run mean nothing; stopped
    (blocks, 1, rows, W): records of where an event ended a run, at the times stopped_at (blocks, W), NaN of other runs,
    None where there are only those; states (runs, 18 k and more): where each run ended; (runs,): codes, simulated time
    (s), steps, rejected steps; (runs, events): the time of the first, NaN if there is none, and how many; at_events
    (blocks, events, rows, W): records of the first, before what it changes, None where nobody asks; modes (runs,
    switches): how each is on where the run ended; changes (runs, n, 5): time, kind
    (`codes.KINDS`), event or switch, impulse and lost energy (J) of the first, NaN behind the last; (runs,): how many
    changes, and the energy lost in them (J); kept (runs, n, 2): the value of what is kept of
    them as a whole, and its time (s); rests (runs,): the kind of equilibrium in which it started
    (`codes.EQUILIBRIA`), and starts (runs, n): its numbers there; seconds: how long a core was busy with them;
    variables: those of the records that somebody asked for, by name; see `records.Layout.variable`; tangents: a
    `Tangents` of `engine.sensitivities`, where a scenario asks for some."""

    runs: slice
    records: np.ndarray
    stopped: np.ndarray | None
    stopped_at: np.ndarray
    states: np.ndarray
    codes: np.ndarray
    ends: np.ndarray
    steps: np.ndarray
    rejected: np.ndarray
    event_times: np.ndarray
    event_counts: np.ndarray
    at_events: np.ndarray | None
    modes: np.ndarray
    changes: np.ndarray
    change_counts: np.ndarray
    energy_lost: np.ndarray
    kept: np.ndarray
    rests: np.ndarray
    starts: np.ndarray
    seconds: float
    variables: dict[str, np.ndarray] = field(default_factory=dict)
    tangents: Any = None


def integrate(batch: Batch, runs: slice, progress: np.ndarray, stop: np.ndarray) -> Chunk:
    """Integrate these runs; see `fixed_step.drive` for progress and stop."""
    machine, count = batch.machine, runs.stop - runs.start
    blocks = -(-count // W)
    own = {n: p.part(runs).rows() for n, p in enumerate(batch.parameters) if isinstance(p, RunNumbers)}
    states, parameters = begin(batch, runs, machine.sizes.parameters, own)
    jumps = discontinuities(batch, runs, blocks)
    records = aligned(blocks, len(batch.outputs), batch.record_rows, W)
    codes = _lanes(batch.codes[runs, None].astype(float), blocks)[:, 0].copy()
    drive = _queued if machine.queued else _together
    started = thread_time()
    told = Told.of(batch, blocks)
    counted = drive(batch, runs, states, parameters, jumps, records, codes, told, progress, stop)
    seconds = thread_time() - started
    stopped_at = np.where(codes == STOPPED, counted[0], np.nan)
    stopped = _stopped(batch, states, parameters, stopped_at)
    ends, steps, rejected = (x.reshape(blocks * W)[:count] for x in counted)
    times, counts, changes, changed, lost = (
        per_run(x, count)
        for x in (told.event_times, told.event_counts, told.changes, told.change_counts, told.energy_lost)
    )
    _keep_at_events(batch, told, parameters)
    kept = per_run(told.kept, count).reshape(count, -1, KEPT_ROWS)
    never = np.isnan(kept[:, :, KEPT_TIME]) & (kept[:, :, KEPT_UNDEFINED] == 0.0)
    kept = np.where(kept[:, :, KEPT_UNDEFINED, None] == 0.0, kept[:, :, :KEPT_PEAK], np.nan)
    kept[never, KEPT_TIME] = np.inf
    at_events, on = _at_events(batch, told, parameters), on_row(machine.sizes)
    modes = per_run(states[:, on : on + machine.sizes.switches], count)
    last = place(machine, states, parameters, batch.bodies).transpose(0, 2, 1).reshape(blocks * W, -1)[:count]
    codes = codes.reshape(-1)[:count].astype(np.int8)
    steps, rejected = steps.astype(np.int64), rejected.astype(np.int64)
    rests = np.zeros(count, np.int8) if batch.rests is None else batch.rests[runs]
    starts = np.zeros((count, 0)) if batch.starts is None else batch.starts[runs]
    return Chunk(
        runs, records, stopped, stopped_at, last, codes, ends, steps, rejected, times, counts, at_events, modes,
        changes, changed, lost, kept, rests, starts, seconds,
    )  # fmt: skip


def begin(batch: Batch, runs: slice, rows: int, own: Mapping[int, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The states (blocks, state rows, W) in which these runs begin, and their parameters (blocks, `rows`, W), prepared;
    own: of parameters of which each run has many, these."""
    count = runs.stop - runs.start
    blocks = -(-count // W)
    numbers = [_numbers(own.get(n, p), batch.runs, runs) for n, p in enumerate(batch.parameters)]
    table = np.stack(numbers or [np.zeros(count)], axis=1)
    parameters = aligned(blocks, rows, W)
    parameters[:, : table.shape[1]] = _lanes(table, blocks)
    prepare(batch.machine, parameters)
    states = _lanes(batch.states[runs], blocks)
    if batch.placed is not None:
        read(batch.machine, _lanes(batch.placed[runs], blocks), parameters, states)
    return states, parameters


class Told(NamedTuple):
    """What happened: the last fields of a `lane_queue.ChunkRuns`."""

    event_times: np.ndarray
    event_counts: np.ndarray
    event_states: np.ndarray
    changes: np.ndarray
    change_counts: np.ndarray
    energy_lost: np.ndarray
    kept: np.ndarray

    @staticmethod
    def of(batch: Batch, blocks: int) -> "Told":
        """Nothing yet."""
        events = len(batch.plan.stops)
        times, changes = np.full((blocks, events, W), np.nan), np.full((blocks, batch.changes, 5, W), np.nan)
        wanted = events if batch.at_events or batch.kept_at_events else 0
        states = aligned(blocks, wanted, state_rows(batch.machine.sizes), W)
        kept = np.full((blocks, KEPT_ROWS * batch.machine.sizes.kept, W), np.nan)
        return Told(times, np.zeros_like(times), states, changes, np.zeros((blocks, W)), np.zeros((blocks, W)), kept)


def _together(batch: Batch, runs: slice, *arrays: Any) -> tuple[np.ndarray, ...]:
    """By the driver of steps of one length. Returns (blocks, W), as `Chunk` has them."""
    machine, (states, parameters, jumps, records, codes, told, progress, stop) = batch.machine, arrays
    assert batch.h is not None
    number, outputs = round(batch.last / batch.h), np.rint(batch.outputs / batch.h).astype(np.int64)
    steps, ends = np.zeros((2, *codes.shape))
    machine.drive(
        machine.kernels, machine.nodes, machine.sizes, number, batch.h, outputs, batch.iterations, batch.tolerance,
        states, parameters, jumps, records, codes, steps, ends, told.kept, batch.plan, machine.buffer(),
        np.zeros(W, np.int64), progress, stop,
    )  # fmt: skip
    return np.where(steps == number, batch.last, ends), steps, np.zeros_like(codes)


def _queued(batch: Batch, runs: slice, *arrays: Any) -> tuple[np.ndarray, ...]:
    """By the driver of a queue. Returns (blocks, W), as `Chunk` has them, and says in `told` what happened."""
    machine, (states, parameters, jumps, records, codes, told, progress, stop) = batch.machine, arrays
    codes.reshape(-1)[runs.stop - runs.start :] = SKIPPED
    first = 0.0 if batch.pace is None else batch.pace.first
    firsts = _lanes(np.broadcast_to(first, (batch.runs,))[runs, None].astype(float), len(codes))[:, 0].copy()
    ends, steps, rejected, stored, within = np.zeros((5, *codes.shape))
    every = (  # a `lane_queue.ChunkRuns`
        states, parameters, jumps, firsts, records, codes, ends, steps, rejected, stored, within, *told,
        batch.trail or NO_TRAIL,
    )  # fmt: skip
    outputs, pace = _on_grid(batch.outputs, batch.h), _pace(batch)
    machine.drive(
        machine.kernels, machine.nodes, machine.sizes, every, outputs, pace, batch.plan, batch.iterations,
        batch.tolerance, machine.buffer(), np.zeros((5, W), np.int64), progress, stop,
    )  # fmt: skip
    return np.where(ends == pace[0], batch.end, ends), steps, rejected


def _stopped(batch: Batch, states: np.ndarray, parameters: np.ndarray, times: np.ndarray) -> np.ndarray | None:
    """See `Chunk`; times (blocks, W): of the states (blocks, rows, W), NaN where these are not wanted."""
    wanted = ~np.isnan(times)[:, None]
    if not wanted.any():
        return None
    found = np.full((len(states), 1, batch.record_rows, W), np.nan)
    seen, behind = observe(batch.machine, states, parameters, times), states.shape[1]
    for first, x in ((0, states), (behind, seen)):  # no iterations: these belong to intervals between outputs
        known = wanted & ~np.isnan(x)  # a NaN that was computed has any sign
        found[:, 0, first : first + x.shape[1]] = np.where(known, x, np.nan)
    return found


def _keep_at_events(batch: Batch, told: "Told", parameters: np.ndarray) -> None:
    """Take the values of records at events from the states where these first happened; NaN where none did."""
    for record, event, signal in batch.kept_at_events:
        times, row = told.event_times[:, event], KEPT_ROWS * record
        values = measure(batch.machine, told.event_states[:, event], parameters, times)[:, signal]
        told.kept[:, row + KEPT_VALUE] = np.where(np.isnan(times), np.nan, values)
        told.kept[:, row + KEPT_TIME], told.kept[:, row + KEPT_UNDEFINED] = times, 0.0


def _at_events(batch: Batch, told: "Told", parameters: np.ndarray) -> np.ndarray | None:
    """See `Chunk`."""
    blocks, events = told.event_states.shape[:2]
    if not batch.at_events or not events:
        return None
    records = aligned(blocks, events, batch.record_rows, W)
    observe_events(
        batch.machine, told.event_states, told.event_times, parameters, records, batch.iterations, batch.tolerance
    )
    return records


def _on_grid(times: Any, h: float | None) -> Any:
    """The nearest ends of steps of one length; the times themselves where a tolerance chooses steps."""
    return times if h is None else np.rint(times / h) * h


def _pace(batch: Batch) -> np.ndarray:
    """See `variable_step.drive`."""
    if batch.h is not None:
        given = [_on_grid(batch.end, batch.h), batch.h, 0.0, 0.0, _on_grid(batch.last, batch.h)]
        return np.array([*given, *EXACT.numbers] if batch.machine.kernels[NEWTON] else given)
    assert batch.pace is not None
    pace = batch.pace
    return np.array([batch.end, 0.0, pace.longest, pace.shortest, batch.last, *pace.tolerance.numbers])


def _lanes(values: np.ndarray, blocks: int) -> np.ndarray:
    """(runs, rows) as (blocks, rows, W); the lanes behind the last run repeat it."""
    padded = values[np.minimum(np.arange(blocks * W), len(values) - 1)]
    out = aligned(blocks, values.shape[1], W)
    out[:] = padded.reshape(blocks, W, -1).transpose(0, 2, 1)
    return out


def discontinuities(batch: Batch, runs: slice, blocks: int) -> np.ndarray:
    """The times on which steps must end (blocks, n, W), those of a run ascending, with an infinite one behind them.

    Those outside the run are left out; those at the end of a step of fixed length are that end to the bit.
    """
    count = runs.stop - runs.start
    if not batch.discontinuities:
        return _lanes(np.full((count, 1), np.inf), blocks)
    every = [times.part(runs).times(count) for times in batch.discontinuities]
    times = np.concatenate([*every, np.full((count, 1), np.inf)], axis=1)
    end = _on_grid(batch.end, batch.h)
    times = np.where(np.abs(times - end) <= COINCIDENT * end, end, times)
    times = np.where((times > 0.0) & (times <= end), times, np.inf)
    if batch.h is not None:
        finite = np.where(np.isfinite(times), times, 0.0)
        ends = _on_grid(finite, batch.h)
        times = np.where(np.isfinite(times) & (np.abs(finite - ends) <= COINCIDENT * batch.h), ends, times)
    times.sort(axis=1)
    used = int(np.isfinite(times).sum(axis=1).max()) + 1
    return _lanes(times[:, :used], blocks)


def _numbers(parameter: Any, count: int, runs: slice) -> np.ndarray:
    """A parameter as the kernels read it, of these runs of as many: tables by their address; (runs, n): what each run
    has of its own, by the address of its row."""
    if np.ndim(parameter) == 2:
        addresses: np.ndarray = parameter.ctypes.data + parameter.strides[0] * np.arange(len(parameter))
        return addresses.view(np.float64)
    number = parameter.address if isinstance(parameter, Numbers) else parameter
    return np.broadcast_to(np.asarray(number, float), (count,))[runs]
