"""Events: conditions that become true, located on the continuous extension of the open step."""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import FRESH, PICKED, STATUS, UNTIL, Sizes, T, Workspace

HALVES = 52  # a fraction of a step is known to the last bit


@apart
def _locate(kernels: np.ndarray, at: Workspace, event: int, t: Lanes, length: Lanes) -> Lanes:
    """The fraction of the open step at which a condition is true, directly behind one at which it is not."""
    low, high = splat(0.0), splat(1.0)
    for _ in range(HALVES):
        middle = 0.5 * (low + high)
        store(at.clock, layout.TIME, t)
        between(kernels, at, middle)
        store(at.clock, layout.TIME, t + middle * length)
        call(kernels[layout.EVENTS], at.now, at.parameters, at.clock, 0, at.following, at.work)
        true = load(at.following, event) != 0.0
        low, high = choose(true, low, middle), choose(true, middle, high)
    store(at.clock, layout.TIME, t)
    return high


@apart
def _note(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, stops: np.ndarray, lane: int
) -> float:
    """Note the events of a lane, up to the one that stops it; returns its time, infinite if there is none."""
    block, place, times = queue.block[lane], queue.lane[lane], first.conditions + 2 * sizes.events
    stop = NEVER
    for event in range(sizes.events):
        if stops[event] != 0 and rows[times + event, lane] < stop:
            stop = rows[times + event, lane]
    for event in range(sizes.events):
        time = rows[times + event, lane]
        if time <= stop and time < NEVER:
            if runs.event_counts[block, event, place] == 0.0:
                runs.event_times[block, event, place] = time
            runs.event_counts[block, event, place] += 1.0
    return stop


@apart
def start_events(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    stops: np.ndarray,
) -> None:  # fmt: skip
    """The conditions of runs that begin; one that is true at once is an event at the start."""
    fresh = load(at.lanes, FRESH) != 0.0
    store(at.clock, layout.TIME, splat(0.0))
    call(kernels[layout.EVENTS], at.state, at.parameters, at.clock, 0, at.following, at.work)
    stages.commit(fresh, at.conditions, at.following, sizes.events)
    for lane in range(W):
        if rows[first.lanes + FRESH, lane] != 0.0:
            for event in range(sizes.events):
                true = rows[first.conditions + event, lane] != 0.0
                rows[first.conditions + 2 * sizes.events + event, lane] = 0.0 if true else NEVER
            if _note(sizes, first, rows, runs, queue, stops, lane) < NEVER:
                rows[first.lanes + STATUS, lane] = codes.STOPPED


@apart
def find_events(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, stops: np.ndarray, good: Mask, t: Lanes, length: Lanes,
) -> Lanes:  # fmt: skip
    """What happens within the step in the lanes `good`; returns the time at which an event stops a run, infinite where
    none does, and the end of the step at least."""
    count = sizes.events
    new, times = at.conditions + ROW * count, at.conditions + ROW * 2 * count
    store(at.clock, layout.TIME, load(at.lanes, UNTIL))
    call(kernels[layout.EVENTS], at.new, at.parameters, at.clock, 0, new, at.work)
    happened, extended = splat(0.0), False
    for event in range(count):
        turned = good & (load(new, event) != 0.0) & (load(at.conditions, event) == 0.0)
        store(times, event, splat(NEVER))
        if any_lane(turned):
            if not extended:
                stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
                extended = True
            fraction = _locate(kernels, at, event, t, length)
            time = choose(fraction == 1.0, load(at.lanes, UNTIL), t + fraction * length)
            store(times, event, choose(turned, time, splat(NEVER)))
            happened = choose(turned, splat(1.0), happened)
    stages.commit(good, at.conditions, new, count)
    store(at.lanes, PICKED, happened)
    for lane in range(W):
        stop = NEVER
        if rows[first.lanes + PICKED, lane] != 0.0:
            stop = _note(sizes, first, rows, runs, queue, stops, lane)
        rows[first.lanes + PICKED, lane] = stop
    return load(at.lanes, PICKED)


@inlined
def stop_runs(sizes: Sizes, at: Workspace, stop: Lanes, good: Mask) -> None:
    """Runs that an event has stopped end there; where that is within the step, in the state that is in `now`."""
    stopped = good & (stop < NEVER)
    stages.commit(stopped & (stop < load(at.lanes, UNTIL)), at.state, at.now, layout.state_rows(sizes))
    store(at.lanes, STATUS, choose(stopped, splat(codes.STOPPED), load(at.lanes, STATUS)))
    store(at.lanes, T, choose(stopped, stop, load(at.lanes, T)))
