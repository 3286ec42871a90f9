"""What lanes with a time of their own store: states between the ends of a step, and afterwards their projection and
what is observed."""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.events.tolerances import SIMULTANEOUS_RTOL
from lienumba.integrators.drivers.lane_queue import ChunkRuns, Queue, keep
from lienumba.integrators.drivers.workspace import Context, Places, Rows
from lienumba.integrators.layout import DUE, ITERATIONS, JUMP, PICKED, STATUS, UNTIL, T, Workspace
from lienumba.numerics.operations import maximum


@apart
def between(kernels: np.ndarray, at: Workspace, fraction: Lanes) -> None:
    """The state at a fraction of the open step, to `now`."""
    store(at.clock, layout.FRACTION, fraction)
    call(kernels[layout.DENSE], at.state, at.parameters, at.clock, at.slopes, at.now, at.work)


@apart
def _keep(
    context: Context, runs: ChunkRuns, queue: Queue, outputs: np.ndarray, lanes: Mask, source: int, projected: bool
) -> None:
    """Store what is due in these lanes, from the rows that begin at `source`."""
    store(context.at.lanes, PICKED, choose(lanes, splat(1.0), splat(0.0)))
    for lane in range(W):
        if context.rows[context.first.lanes + PICKED, lane] != 0.0:
            keep(lane, context.rows, context.first, context.sizes, runs, queue, outputs, source, projected)


@inlined
def earliest_end(at: Workspace, length: Lanes) -> Lanes:
    """The time from which an output belongs to the end of the step. Where values jump there that is roundoff before it,
    so that the output is stored behind the jump."""
    end = load(at.lanes, UNTIL)
    return choose(end == load(at.lanes, JUMP), end - SIMULTANEOUS_RTOL * maximum(length, end), end)


@inlined
def pending(at: Workspace, good: Mask, length: Lanes, until: Lanes, latest: Lanes) -> Mask:
    """In which of the lanes `good` an output is due that the open step does not end with: it is left at `until`, and
    what is due up to `latest` is seen before that."""
    due, end = load(at.lanes, DUE), load(at.lanes, UNTIL)
    return good & (due <= latest) & ((due < earliest_end(at, length)) | (until < end) | (end < due))


@apart
def keep_between(
    context: Context, runs: ChunkRuns, queue: Queue, outputs: np.ndarray, good: Mask, until: Lanes, latest: Lanes
) -> None:
    """Store what is `pending` in the current step."""
    t, length = load(context.at.lanes, T), load(context.at.clock, layout.LENGTH)
    stages.extend(context)
    left = pending(context.at, good, length, until, latest)
    while any_lane(left):
        between(context.kernels, context.at, (load(context.at.lanes, DUE) - t) / length)
        _keep(context, runs, queue, outputs, left, context.first.now, False)
        left = pending(context.at, good, length, until, latest)


@apart
def keep_ends(context: Context, runs: ChunkRuns, queue: Queue, outputs: np.ndarray, lanes: Mask) -> None:
    """Store the states to which a step has led in these lanes."""
    _keep(context, runs, queue, outputs, lanes, context.first.state, True)


@apart
def _fall_back(block: int, rows: Rows, first: Workspace, runs: ChunkRuns, outputs: np.ndarray, state: int) -> None:
    """Runs of a block with a STATUS end where they were stored last."""
    for lane in range(W):
        code = rows[first.lanes + STATUS, lane]
        if code != 0.0:
            last = int(runs.stored[block, lane]) - 1
            runs.statuses[block, lane], runs.ends[block, lane] = code, outputs[last]
            runs.within[block, lane] = 0.0
            for row in range(state):
                runs.states[block, row, lane] = runs.records[block, last, row, lane]


@apart
def observe(context: Context, runs: ChunkRuns, outputs: np.ndarray) -> None:
    """Project what was stored between the ends of steps and where runs ended there, and observe what was stored, block
    by block."""
    state = layout.state_rows(context.sizes)
    x, lanes, places = context.at.new, context.at.lanes, Places(context.at.new, context.at.now, context.at.following)
    for block in range(runs.statuses.shape[0]):
        p = runs.parameters[block].ctypes.data
        for n in range(outputs.size):
            to = runs.records[block, n].ctypes.data
            for lane in range(W):
                context.rows[context.first.lanes + PICKED, lane] = 1.0 if n < runs.stored[block, lane] else 0.0
            picked = load(lanes, PICKED) != 0.0
            if not any_lane(picked):
                for row in range(layout.record_rows(context.sizes)):
                    store(to, row, splat(np.nan))
                continue
            stages.copy(x, to, state)
            store(context.at.clock, layout.TIME, splat(outputs[n]))
            store(context.at.clock, layout.LENGTH, splat(0.0))
            store(lanes, STATUS, splat(0.0))
            status, iterations = lanes + ROW * STATUS, lanes + ROW * ITERATIONS
            loose = picked & (load(to, state) == 0.0)
            if any_lane(loose):
                stages.project(context, p, places, False, status, loose, iterations)
            stages.copy(
                iterations, to + ROW * (state + context.sizes.observed), layout.PROJECTIONS
            )  # those of the steps
            picked = picked & (load(status, 0) == 0.0)
            if any_lane(load(status, 0) != 0.0):
                for lane in range(W):
                    if context.rows[context.first.lanes + STATUS, lane] != 0.0:
                        runs.stored[block, lane] = n
                _fall_back(block, context.rows, context.first, runs, outputs, state)
            stages.record(context, to, x, p, picked, iterations)
        within = load(runs.within[block].ctypes.data, 0) != 0.0
        if any_lane(within):
            stages.copy(x, runs.states[block].ctypes.data, state)
            store(context.at.clock, layout.TIME, load(runs.ends[block].ctypes.data, 0))
            store(lanes, STATUS, splat(0.0))
            status = lanes + ROW * STATUS
            iterations = lanes + ROW * ITERATIONS
            stages.project(context, p, places, False, status, within, iterations)
            stages.commit(within & (load(status, 0) == 0.0), runs.states[block].ctypes.data, x, state)
            _fall_back(block, context.rows, context.first, runs, outputs, state)
