"""The driver of free lanes: each has its own time, chooses its steps, and takes the next run when one is over.

A step stays open until it is accepted: the state at its start is there, with the slopes of all stages, so that what
lies between its ends is read off the continuous extension, and no output ever moves a step. What is stored is projected
and observed afterwards, block by block. With steps of one length it is for events.
"""

from typing import Any

import numpy as np
from numba import njit
from numba.core import types

from lienumba.compiler import cache
from lienumba.compiler.lanes import any_lane, borrowed, call, choose, load, splat, store
from lienumba.compiler.rows import ROW, W
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between, keep_between, keep_ends, observe
from lienumba.integrators.drivers.events import find_events, start_events, stop_runs
from lienumba.integrators.drivers.lane_queue import (
    ACCEPTED,
    BUSY,
    COUNTS,
    DUE,
    END,
    FRESH,
    GRID,
    LANDING,
    LONGEST,
    NEVER,
    PICKED,
    STALE,
    STATUS,
    STEP,
    TOLERANCE,
    TRIAL,
    UNTIL,
    Queue,
    Runs,
    T,
    accept,
    fill,
    finish,
    keep,
    land,
    propose,
    reject,
)  # fmt: skip
from lienumba.integrators.drivers.stages import commit
from lienumba.integrators.drivers.workspace import OPTIONS, SIZES, addresses, layout, slope_row, table_rows
from lienumba.integrators.tracing.row_selection import WEAKENED

FIELDS = [types.float64[:, :, ::1]] * 3 + [types.float64[:, ::1], types.float64[:, :, :, ::1]]
RUNS: Any = types.NamedTuple(FIELDS + [types.float64[:, ::1]] * 6 + [types.float64[:, :, ::1]] * 2, Runs)  # type: ignore[attr-defined]


@njit(**OPTIONS)
def _next_runs(
    kernels: Any, sizes: Any, at: Any, first: Any, rows: Any, runs: Runs, queue: Queue, outputs: Any, stops: Any
) -> bool:
    """Give every lane without a run the next one, and store its start; whether any lane has a run."""
    fresh, busy = False, False
    for lane in range(W):
        if rows[first.lanes + BUSY, lane] == 0.0:
            fresh = fill(lane, rows, first, runs, queue) or fresh
        busy = busy or rows[first.lanes + BUSY, lane] != 0.0
    if not fresh:
        return busy
    if kernels[stages.SAMPLE] != 0:
        store(at.clock, codes.TIME, splat(0.0))
        call(kernels[stages.SAMPLE], at.state, at.parameters, at.clock, 0, at.new, at.work)
        commit(load(at.lanes, FRESH) != 0.0, at.state, at.new, ELEMENT * sizes.elements)
    if sizes.events > 0:
        start_events(kernels, sizes, at, first, rows, runs, queue, stops)
    for lane in range(W):
        if rows[first.lanes + FRESH, lane] != 0.0:
            keep(lane, rows, first, sizes, runs, queue, outputs, first.state, True)
            rows[first.lanes + FRESH, lane] = 0.0
    return busy


@njit(**OPTIONS)
def _take(mask: Any, sizes: Any, slopes: int) -> None:
    """F at the end of a step is the first slope of the next one."""
    for element in range(sizes.elements):
        source, target = slope_row(sizes, element, sizes.slots - 1), slope_row(sizes, element, 0)
        commit(mask, slopes + ROW * target, slopes + ROW * source, sizes.slope)
    source, target = slope_row(sizes, sizes.elements, sizes.slots - 1), slope_row(sizes, sizes.elements, 0)
    commit(mask, slopes + ROW * target, slopes + ROW * source, codes.REPORTS)


@njit(**OPTIONS)
def _try(kernels: Any, sizes: Any, nodes: Any, at: Any, table: Any, limit: int, tolerance: float) -> None:
    """One step of every lane with its projections, and where a tolerance chooses steps with F at its end and its error;
    codes go to TRIAL."""
    x, p, new, lanes = at.state, at.parameters, at.new, at.lanes
    last, paced = at.slopes + ROW * slope_row(sizes, 0, sizes.slots - 1), kernels[stages.CLOSE] != 0
    stale = load(lanes, STALE) != 0.0
    if paced and any_lane(stale):
        call(kernels[stages.FIRST], x, p, at.clock, 0, last, at.work)
        _take(stale, sizes, at.slopes)
        store(lanes, STALE, splat(0.0))
    if kernels[stages.STEP] != 0:
        call(kernels[stages.STEP], x, p, at.clock, at.slopes, new, at.work)
    else:
        stages.staged_step(kernels, sizes, nodes, 1 if paced else 0, x, p, at)
    trial = lanes + ROW * TRIAL
    store(trial, 0, load(new, ELEMENT * sizes.elements + sizes.held))
    store(at.clock, codes.TIME, load(lanes, UNTIL))
    busy = load(lanes, BUSY) != 0.0
    counts = lanes + ROW * COUNTS
    stages.project_both(kernels, sizes, p, new, at, trial, busy, counts, table, limit, tolerance)
    if not paced:
        return
    call(kernels[stages.FIRST], new, p, at.clock, 0, last, at.work)
    sound = load(at.slopes, slope_row(sizes, sizes.elements, sizes.slots - 1)) > 0.0
    store(trial, 0, choose(sound, load(trial, 0), choose(load(trial, 0) == 0.0, splat(codes.SINGULAR), load(trial, 0))))
    call(kernels[stages.CLOSE], x, p, at.clock, new, at.control, at.work)


@njit(**OPTIONS)
def _move(kernels: Any, sizes: Any, at: Any, good: Any, table: Any, pace: Any) -> None:
    """The step is done in the lanes `good`."""
    rows, held, lanes, x = ELEMENT * sizes.elements, sizes.held, at.lanes, at.state
    until, grid = load(lanes, UNTIL), load(lanes, GRID)
    store(at.clock, codes.TIME, until)
    commit(good, x, at.new, rows + held)
    store(lanes, T, choose(good, until, load(lanes, T)))
    counted = good
    if pace[STEP] > 0.0:
        counted = good & (until == (grid + 1.0) * pace[STEP])
    store(lanes, GRID, choose(counted, grid + 1.0, grid))
    store(lanes, ACCEPTED, choose(counted, load(lanes, ACCEPTED) + 1.0, load(lanes, ACCEPTED)))
    _take(good, sizes, at.slopes)
    if sizes.q > 0:
        masks = rows + sizes.first_mask
        weak = good & (load(at.new, rows + held + 1) < WEAKENED * load(x, masks + sizes.q))
        if any_lane(weak):
            others = stages.exchange(kernels, sizes, x, at.parameters, at, weak, table, x)
            store(lanes, STALE, choose(others, splat(1.0), load(lanes, STALE)))
            if sizes.fixed != 0:
                store(lanes, STATUS, choose(others, splat(codes.EXCHANGED), load(lanes, STATUS)))


@njit(**OPTIONS)
def _land(kernels: Any, sizes: Any, at: Any, first: Any, rows: Any, runs: Runs, queue: Queue, moved: Any) -> None:
    """What happens on landing: laws are sampled, and F may jump."""
    own = first.lanes
    store(at.lanes, PICKED, choose(moved, splat(1.0), splat(0.0)))
    for lane in range(W):
        landed = rows[own + PICKED, lane] != 0.0 and land(lane, rows, first, runs, queue)
        rows[own + PICKED, lane] = 1.0 if landed else 0.0
        if landed:
            rows[own + STALE, lane] = 1.0
            rows[first.clock + codes.MEMORY, lane] = 0.0
    picked = load(at.lanes, PICKED) != 0.0
    if kernels[stages.SAMPLE] != 0 and any_lane(picked):
        call(kernels[stages.SAMPLE], at.state, at.parameters, at.clock, 0, at.new, at.work)
        commit(picked, at.state, at.new, ELEMENT * sizes.elements)


@cache.numba_cached(
    types.void(
        types.int64[::1], types.float64[::1], SIZES, RUNS,
        types.float64[::1], types.float64[::1], types.int64[::1], types.int64, types.float64, types.float64[::1],
        types.int64[::1], types.int64[::1],
    ),
    **OPTIONS,
)  # fmt: skip
def drive(
    kernels: Any, nodes: Any, sizes: Any, runs: Runs, outputs: Any, pace: Any, stops: Any, limit: int,
    tolerance: float, buffer: Any, progress: Any, stop: Any,
) -> None:  # fmt: skip
    """Integrate all runs.

    outputs: the times to be stored, from 0 on; pace: the end of the runs, the step where steps are of one length (else
    0), the longest and the shortest step, and the numbers of a `control.Tolerance`; stops: of each event, whether it
    ends a run; limit and tolerance: of the projections; the rest as in `driver.drive`.
    """
    at, first = addresses(buffer, sizes), layout(sizes)
    kernels, nodes, pace = borrowed(kernels), borrowed(nodes), borrowed(pace)
    rows = borrowed(buffer[: W * first.work].reshape((first.work, W)))
    table = borrowed(rows[first.table : first.table + table_rows(sizes.q)])
    empty = np.zeros(W, np.int64)
    queue = Queue(empty, empty.copy(), empty.copy(), empty.copy(), np.zeros(1, np.int64))
    lanes, total, fresh, done = at.lanes, runs.statuses.shape[0] * W, True, 0
    for lane in range(W):
        rows[first.lanes + BUSY, lane] = 0.0
    while True:
        if stop[0] != 0:
            return
        if fresh:
            if not _next_runs(kernels, sizes, at, first, rows, runs, queue, outputs, stops):
                break
            for n in range(pace.size - TOLERANCE):
                store(at.clock, codes.TOLERANCE + n, splat(pace[TOLERANCE + n]))
            fresh = False
        propose(lanes, at.clock, pace[END], pace[STEP])
        t, length, until = load(lanes, T), load(at.clock, codes.LENGTH), load(lanes, UNTIL)
        _try(kernels, sizes, nodes, at, table, limit, tolerance)
        given, trial = load(lanes, BUSY) != 0.0, load(lanes, TRIAL)
        busy = given & (load(lanes, STATUS) == 0.0)
        good = busy & (trial == 0.0)
        if pace[STEP] > 0.0:
            store(lanes, STATUS, choose(busy, trial, load(lanes, STATUS)))
        else:
            good = good & (load(at.control, 0) <= 1.0)
            store(lanes, PICKED, choose(good, splat(0.0), splat(1.0)))
            reject(lanes, at.control, length, busy & (load(lanes, PICKED) != 0.0), pace)
            accept(lanes, at.control, length, good, pace[LONGEST])
            store(at.clock, codes.MEMORY, choose(good, load(at.control, 3), load(at.clock, codes.MEMORY)))
        stopped = splat(NEVER)
        if sizes.events > 0:
            stopped = find_events(kernels, sizes, nodes, at, first, rows, runs, queue, stops, good, t, length)
            until = choose(stopped < until, stopped, until)
        due, end = load(lanes, DUE), load(lanes, UNTIL)
        if any_lane(good & (due <= until) & (due < end)):
            keep_between(kernels, sizes, nodes, at, first, rows, runs, queue, outputs, good, t, length, until)
        if any_lane(good & (stopped < end)):
            between(kernels, at, (stopped - t) / length)
        _move(kernels, sizes, at, good, table, pace)
        stop_runs(sizes, at, stopped, good)
        landed = good & (load(lanes, T) == load(lanes, LANDING))
        if any_lane(landed):
            store(at.clock, codes.TIME, load(lanes, T))
            _land(kernels, sizes, at, first, rows, runs, queue, landed)
        due = load(lanes, DUE)
        ended = good & (due == load(lanes, T)) & (due == end)
        if any_lane(ended):
            keep_ends(at, first, sizes, rows, runs, queue, outputs, ended)
        over = given & ((load(lanes, STATUS) != 0.0) | (load(lanes, T) == pace[END]))
        if any_lane(over):
            store(lanes, PICKED, choose(over, splat(1.0), splat(0.0)))
            for lane in range(W):
                if rows[first.lanes + PICKED, lane] != 0.0:
                    finish(lane, rows, first, runs, queue)
                    rows[first.lanes + BUSY, lane] = 0.0
                    done += 1
            progress[0] = outputs.size * (done * runs.statuses.shape[0]) // total
            fresh = True
    observe(kernels, sizes, at, first, rows, runs, outputs, limit, tolerance, table)
    progress[0] = outputs.size * runs.statuses.shape[0]
