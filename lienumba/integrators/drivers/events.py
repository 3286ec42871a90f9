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

FINEST = 2.0**-52  # a fraction of a step is known to the last bit
LONGEST_SEARCH = 200  # of tries


@inlined
def _margin(kernels: np.ndarray, at: Workspace, event: int, t: Lanes, length: Lanes, fraction: Lanes) -> Lanes:
    """A condition at a fraction of the open step."""
    store(at.clock, layout.TIME, t)
    between(kernels, at, fraction)
    store(at.clock, layout.TIME, t + fraction * length)
    call(kernels[layout.EVENTS], at.now, at.parameters, at.clock, 0, at.following, at.work)
    return load(at.following, event)


@apart
def locate(
    kernels: np.ndarray, at: Workspace, event: int, t: Lanes, length: Lanes, before: Lanes, after: Lanes, lanes: Mask
) -> Lanes:
    """The fraction of the open step at which a condition is true, directly behind one at which it is not, in these
    lanes; before, after: what it is at the ends of the step. By Chandrupatla's method: inverse quadratic interpolation
    where three values allow it, else halves."""
    low, high, f_low, f_high = splat(0.0), splat(1.0), before, after
    third, f_third = splat(0.0), before  # the end that was replaced last
    newest_low, part = (
        splat(1.0),
        splat(0.5),
    )  # whether the last value is that of `low`; of the way from it to the other
    left = lanes
    for _ in range(LONGEST_SEARCH):
        if not any_lane(left):
            break
        lower = newest_low == 1.0
        a, b = choose(lower, low, high), choose(lower, high, low)
        x = a + part * (b - a)
        f = _margin(kernels, at, event, t, length, x)
        true = f > 0.0
        replaced, f_replaced = choose(true, high, low), choose(true, f_high, f_low)
        third, f_third = choose(left, replaced, third), choose(left, f_replaced, f_third)
        high, f_high = choose(left & true, x, high), choose(left & true, f, f_high)
        low, f_low = choose(true, low, choose(left, x, low)), choose(true, f_low, choose(left, f, f_low))
        newest_low = choose(left, choose(true, 0.0, 1.0), newest_low)
        left = left & (high - low > FINEST)
        part = choose(left, _part(low, f_low, high, f_high, third, f_third, newest_low == 1.0), part)
    store(at.clock, layout.TIME, t)
    return high


@inlined
def _part(low: Lanes, f_low: Lanes, high: Lanes, f_high: Lanes, third: Lanes, f_third: Lanes, lower: Mask) -> Lanes:
    """Where to look next, as a part of the way from the newest end of the bracket to the other."""
    a, f_a = choose(lower, low, high), choose(lower, f_low, f_high)
    b, f_b = choose(lower, high, low), choose(lower, f_high, f_low)
    across, place = (a - b) / (third - b), (f_a - f_b) / (f_third - f_b)
    smooth = (place * place < across) & ((1.0 - place) * (1.0 - place) < 1.0 - across)
    towards = f_a / (f_b - f_a) * (f_third / (f_b - f_third))
    towards = towards + (third - a) / (b - a) * (f_a / (f_third - f_a)) * (f_b / (f_third - f_b))
    part = choose(smooth, towards, 0.5)
    nearest = FINEST / (high - low)  # so that the other end comes near, too
    nearest = choose(nearest < 0.5, nearest, 0.5)
    part = choose(part > nearest, part, nearest)
    return choose(part < 1.0 - nearest, part, 1.0 - nearest)


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
def _keep_state(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, event: int, source: int, lane: int
) -> None:
    """Keep the state of a lane, from the rows that begin at `source`, for the first time that an event happens."""
    block, place = queue.block[lane], queue.lane[lane]
    if runs.event_counts[block, event, place] == 0.0:
        for row in range(layout.state_rows(sizes)):
            runs.event_states[block, event, row, place] = rows[source + row, lane]


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
                true = rows[first.conditions + event, lane] > 0.0
                rows[first.conditions + 2 * sizes.events + event, lane] = 0.0 if true else NEVER
                if true and runs.event_states.shape[1] > 0:
                    _keep_state(sizes, first, rows, runs, queue, event, first.state, lane)
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
        before, after = load(at.conditions, event), load(new, event)
        turned = good & (after > 0.0) & (choose(before > 0.0, 1.0, 0.0) == 0.0)
        store(times, event, splat(NEVER))
        if any_lane(turned):
            if not extended:
                stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
                extended = True
            fraction = locate(kernels, at, event, t, length, before, after, turned)
            time = choose(fraction == 1.0, load(at.lanes, UNTIL), t + fraction * length)
            store(times, event, choose(turned, time, splat(NEVER)))
            happened = choose(turned, splat(1.0), happened)
            if runs.event_states.shape[1] > 0:
                between(kernels, at, fraction)
                stages.commit(turned & (fraction == 1.0), at.now, at.new, layout.state_rows(sizes))
                store(at.lanes, PICKED, choose(turned, splat(1.0), splat(0.0)))
                for lane in range(W):
                    if rows[first.lanes + PICKED, lane] != 0.0:
                        _keep_state(sizes, first, rows, runs, queue, event, first.now, lane)
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
