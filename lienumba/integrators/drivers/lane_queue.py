"""Lanes with a time of their own: which run each has, where it is in time, and what it has stored.

Rows of lanes, one number per lane; what happens rarely (a run begins, is stored, or is over) is done lane by lane.
"""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, choose, load, splat, store
from lienumba.compiler.routines.marks import Floats2, Floats3, Floats4, Integers1, apart, inlined
from lienumba.compiler.rows import W
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers.trail import Trail
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    ACCEPTED,
    BACK,
    BUSY,
    CUT,
    DUE,
    FRESH,
    GRID,
    ITERATIONS,
    JUMP,
    LANES,
    MARK,
    REJECTED,
    STALE,
    STATUS,
    TRIAL,
    TRIED,
    UNTIL,
    H,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes

NEVER = float("inf")
ROUNDING, FIRST_ROUNDING = 1e-15, 1e-18  # of the time, and of the end: no step is shorter
CREEP, PATIENCE = 1e-3, 1e5  # of the end; so many steps within it, and a run would take as good as for ever
# Of the pace; step: of steps of one length, else 0; last: a run that is there is over.
END, STEP, LONGEST, SHORTEST, LAST, TOLERANCE = range(6)


class ChunkRuns(NamedTuple):
    """All runs of a chunk. states (blocks, state rows, W): initial, left at the last good state; parameters
    (blocks, P, W), discontinuities (blocks, L, W), first steps (blocks, W); records (blocks, outputs, record rows, W);
    (blocks, W): statuses, simulated time, steps, rejected steps, how many outputs are stored, and whether the run ended
    within a step, where its state is yet to be projected; (blocks, events, W): the time of the first, and how many;
    (blocks, events or 0, state rows, W): states at the first; changes (blocks, n, 5, W): time, what it is
    (`codes.KINDS`), of which event or switch, impulse and lost energy (J) of the first; and (blocks, W): how many
    changes, and the energy lost in all of them; kept (blocks, KEPT_ROWS n, W): what is kept of each run as a whole;
    trail: what each run goes through, where somebody asks."""

    states: Floats3
    parameters: Floats3
    discontinuities: Floats3
    first_steps: Floats2
    records: Floats4
    statuses: Floats2
    ends: Floats2
    accepted: Floats2
    rejected: Floats2
    stored: Floats2
    within: Floats2
    event_times: Floats3
    event_counts: Floats3
    event_states: Floats4
    changes: Floats4
    change_counts: Floats2
    energy_lost: Floats2
    kept: Floats3
    trail: Trail


class Queue(NamedTuple):
    """(W,): of each lane the block and the lane where its run is kept, its next output and discontinuity; next (1,):
    run."""

    block: Integers1
    lane: Integers1
    output: Integers1
    discontinuity: Integers1
    next: Integers1


@apart
def fill(lane: int, rows: Rows, first: Workspace, runs: ChunkRuns, queue: Queue) -> bool:
    """Give a lane the next run that may run; whether there is one. rows: the memory of the driver."""
    blocks, n = runs.statuses.shape[0], queue.next[0]
    while n < blocks * W and runs.statuses[n // W, n % W] != 0.0:
        n += 1
    queue.next[0] = n + 1
    own = first.lanes
    if n >= blocks * W:
        for row in range(first.new):  # it goes on with ordinary numbers
            rows[first.state + row, lane] = rows[first.state + row, 0]
        for row in range(runs.parameters.shape[1]):
            rows[first.parameters + row, lane] = rows[first.parameters + row, 0]
        return False
    block, place = n // W, n % W
    queue.block[lane], queue.lane[lane], queue.output[lane], queue.discontinuity[lane] = block, place, 0, 0
    for row in range(runs.states.shape[1]):
        rows[first.state + row, lane] = runs.states[block, row, place]
    for row in range(runs.parameters.shape[1]):
        rows[first.parameters + row, lane] = runs.parameters[block, row, place]
    for row in range(LANES):
        rows[own + row, lane] = 0.0
    rows[own + BUSY, lane] = rows[own + FRESH, lane] = rows[own + STALE, lane] = 1.0
    rows[first.clock + layout.MEMORY, lane] = 0.0
    rows[own + H, lane] = runs.first_steps[block, place]
    rows[own + JUMP, lane] = runs.discontinuities[block, 0, place]
    rows[own + CUT, lane] = NEVER
    return True


@apart
def finish(lane: int, rows: Rows, first: Workspace, runs: ChunkRuns, queue: Queue) -> None:
    """The run of a lane is over."""
    own, block, place = first.lanes, queue.block[lane], queue.lane[lane]
    runs.statuses[block, place] = rows[own + STATUS, lane]
    runs.ends[block, place] = rows[own + T, lane]
    runs.accepted[block, place] = rows[own + ACCEPTED, lane]
    runs.rejected[block, place] = rows[own + REJECTED, lane]
    runs.stored[block, place] = queue.output[lane]
    inside = 0.0 < rows[own + T, lane] < rows[own + UNTIL, lane]
    runs.within[block, place] = 1.0 if rows[own + STATUS, lane] == codes.STOPPED and inside else 0.0
    for row in range(runs.states.shape[1]):
        runs.states[block, row, place] = rows[first.state + row, lane]
    for row in range(runs.kept.shape[1]):
        runs.kept[block, row, place] = rows[first.measures + row, lane]


@apart
def keep(
    lane: int, rows: Rows, first: Workspace, sizes: Sizes, runs: ChunkRuns, queue: Queue, outputs: np.ndarray,
    source: int, projected: bool,
) -> None:  # fmt: skip
    """Store a lane's state from the rows that begin at `source`; whether it is projected is said behind it, where
    `observe` finds it."""
    state = layout.state_rows(sizes)
    record, place = runs.records[queue.block[lane], queue.output[lane]], queue.lane[lane]
    for row in range(state):
        record[row, place] = rows[source + row, lane]
    record[state, place] = 1.0 if projected else 0.0
    for n in range(layout.PROJECTIONS):
        record[state + sizes.observed + n, place] = rows[first.lanes + ITERATIONS + n, lane]
        rows[first.lanes + ITERATIONS + n, lane] = 0.0
    queue.output[lane] += 1
    rows[first.lanes + DUE, lane] = outputs[queue.output[lane]] if queue.output[lane] < outputs.size else NEVER


@apart
def keep_state(rows: Rows, runs: ChunkRuns, queue: Queue, lane: int, event: int, source: int) -> None:
    """Keep the state at an event that is the first of its kind, where they are wanted."""
    block, place = queue.block[lane], queue.lane[lane]
    if event < runs.event_states.shape[1] and runs.event_counts[block, event, place] == 0.0:
        for row in range(runs.event_states.shape[2]):
            runs.event_states[block, event, row, place] = rows[source + row, lane]


@apart
def pass_discontinuities(lane: int, rows: Rows, first: Workspace, runs: ChunkRuns, queue: Queue) -> bool:
    """Whether a lane has come to a discontinuity; then it goes for the next one."""
    own, block, place = first.lanes, queue.block[lane], queue.lane[lane]
    reached = False
    while runs.discontinuities[block, queue.discontinuity[lane], place] <= rows[own + T, lane]:
        queue.discontinuity[lane] += 1
        reached = True
    rows[own + JUMP, lane] = runs.discontinuities[block, queue.discontinuity[lane], place]
    return reached


@inlined
def propose(lanes: Address, clock: Address, end: float, h: float, cuts: bool) -> None:
    """The next step of each lane: as long as the controller wants it, but to a discontinuity at most, and not leaving a
    tiny rest; h: of steps of one length, else 0; cuts: whether one that is tried again is to end where it is said."""
    t, wanted = load(lanes, T), load(lanes, H)
    until = splat(end)
    begin = load(lanes, GRID) * h
    if h > 0.0:
        until = (load(lanes, GRID) + 1.0) * h
    grid = until
    until = choose(load(lanes, JUMP) < until, load(lanes, JUMP), until)
    until = choose(load(lanes, CUT) < until, load(lanes, CUT), until)
    rest = until - t
    if h == 0.0:
        half = choose(2.0 * wanted > rest, t + 0.5 * rest, t + wanted)
        cut = choose(wanted < rest, t + wanted, until)
        until = choose(1.01 * wanted >= rest, until, half)
        if cuts:
            until = choose(load(lanes, BACK) != 0.0, cut, until)
    length = until - t
    if h > 0.0:
        length = choose((until == grid) & (t == begin), splat(h), length)
    store(lanes, UNTIL, until)
    store(clock, layout.TIME, t)
    store(clock, layout.LENGTH, length)
    store(clock, layout.MIDDLE, t + 0.5 * length)


@inlined
def reject(lanes: Address, control: Address, length: Lanes, lost: Mask, pace: np.ndarray) -> None:
    """In the lanes `lost` the step is tried again, shorter; where it would be too short, the run is over."""
    trial, t = load(lanes, TRIAL), load(lanes, T)
    shorter = length * choose(trial == 0.0, load(control, layout.FACTOR), 0.25)
    shortest = max(pace[SHORTEST], FIRST_ROUNDING * pace[END])
    least = choose(splat(shortest) > ROUNDING * t, splat(shortest), ROUNDING * t)
    over = lost & ((shorter < least) | (trial == codes.RESELECT))
    store(lanes, STATUS, choose(over, choose(trial == 0.0, splat(codes.TOO_SHORT), trial), load(lanes, STATUS)))
    store(lanes, H, choose(lost, shorter, load(lanes, H)))
    store(lanes, BACK, choose(lost, splat(1.0), load(lanes, BACK)))
    store(lanes, REJECTED, load(lanes, REJECTED) + choose(lost, 1.0, 0.0))


@inlined
def lose_patience(lanes: Address, busy: Mask, end: float) -> None:
    """A run is over that creeps: that has tried `PATIENCE` steps within a tiny part of its time."""
    t, tried = load(lanes, T), load(lanes, ACCEPTED) + load(lanes, REJECTED)
    moved = t - load(lanes, MARK) > CREEP * end
    store(lanes, MARK, choose(moved, t, load(lanes, MARK)))
    store(lanes, TRIED, choose(moved, tried, load(lanes, TRIED)))
    creeps = busy & (tried - load(lanes, TRIED) > PATIENCE) & (load(lanes, STATUS) == 0.0)
    store(lanes, STATUS, choose(creeps, splat(codes.TOO_SHORT), load(lanes, STATUS)))


@inlined
def accept(lanes: Address, control: Address, length: Lanes, good: Mask, longest: float) -> None:
    """In the lanes `good` the next step is as long as the controller says; one that was cut says nothing against a
    longer one."""
    grown = load(control, layout.FACTOR)
    grown = choose((load(lanes, BACK) != 0.0) & (grown > 1.0), 1.0, grown)
    wanted, following = load(lanes, H), length * grown
    following = choose((length < wanted) & (following < wanted), wanted, following)
    following = choose(following > longest, splat(longest), following)
    store(lanes, H, choose(good, following, wanted))
    store(lanes, BACK, choose(good, splat(0.0), load(lanes, BACK)))
