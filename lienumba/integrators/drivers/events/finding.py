"""Events: which conditions have become true in the open step, and what that means for it."""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import certificates, stages
from lienumba.integrators.drivers.events.acting import PAST, follow, gather, hold, if_it_acts, pass_over, sift
from lienumba.integrators.drivers.events.loads import loaded, seek_loads
from lienumba.integrators.drivers.events.search import EDGE, LATER, LEAVES, SOUGHT, TOUCH, search
from lienumba.integrators.drivers.events.turns import SLIGHT, doubt_rates, go_on, keep_rates, rises_here, seek_turns
from lienumba.integrators.drivers.events.waves import count_more, see_peaks, seek_first
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue, keep_state
from lienumba.integrators.drivers.switching.reactions import STILL
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    ACTION,
    BEGINS,
    BILATERAL,
    CHANGED,
    CLEAR,
    CUT,
    FRESH,
    FRICTION,
    JUMP,
    NEAR,
    OFF,
    OPENS,
    PICKED,
    RECORDS,
    REJECTED,
    SETS,
    SLIDES,
    STATUS,
    STICK,
    SWITCH_FIRST,
    SWITCH_KIND,
    UNTIL,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import HOLDS, absolute, minimum

SOON = 2.0**-14  # of a run: in a step that is longer nothing is carried along unnoticed
FINEST = 2.0**-30  # of a run: a shorter step in which friction pushes is not tried again
BEHIND = 1.0 + 2.0**-49  # of a time: later by rounding


@apart
def note(sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, lane: int, until: float) -> None:
    """Note the events of a lane up to a time."""
    block, place, times = queue.block[lane], queue.lane[lane], first.conditions + 2 * layout.conditions(sizes)
    for event in range(sizes.events):
        time = rows[times + event, lane]
        if time <= until and time < NEVER:
            if runs.event_counts[block, event, place] == 0.0:
                runs.event_times[block, event, place] = time
            runs.event_counts[block, event, place] += 1.0


@inlined
def _leaves(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> tuple[float, float]:
    """When an event stops the run of a lane, and when the mechanism changes; infinite if never."""
    times, stop, change = first.conditions + 2 * layout.conditions(sizes), NEVER, NEVER
    for event in range(sizes.events):
        if plan.stops[event] != 0:
            stop = min(stop, rows[times + event, lane])
        elif plan.acts[event, ACTION] != RECORDS and rows[times + event, lane] != PAST:
            change = min(change, rows[times + event, lane])
    for condition in range(sizes.events, layout.conditions(sizes)):
        change = min(change, rows[times + condition, lane])
    return stop, change


@apart
def _look_at_start(kernels: np.ndarray, sizes: Sizes, at: Workspace, fresh: Mask) -> None:
    """The conditions of runs that begin, none of which has come true yet."""
    count = layout.conditions(sizes)
    store(at.lanes, CLEAR, choose(fresh, 0.0, load(at.lanes, CLEAR)))
    store(at.clock, layout.TIME, splat(0.0))
    call(kernels[layout.EVENTS], at.state, at.parameters, at.clock, 0, at.following, at.work)
    for row in range(layout.peak_row(sizes), layout.rise_row(sizes)):
        store(at.conditions, row, choose(fresh, 0.0, load(at.conditions, row)))
    lapsed = layout.peak_row(sizes) + layout.LAPSED * sizes.events
    for row in range(lapsed, lapsed + sizes.events):
        store(at.conditions, row, choose(fresh, splat(-NEVER), load(at.conditions, row)))
    for row in range(layout.rise_row(sizes), layout.rise_row(sizes) + count):
        store(at.conditions, row, choose(fresh, splat(NEVER), load(at.conditions, row)))
    follow(sizes, at, at.following, at.following + ROW * layout.rate_row(sizes), fresh)
    stages.commit(fresh, at.conditions, at.following, count)
    for n in range(2 * count, 3 * count):
        store(at.conditions, n, choose(fresh, splat(NEVER), load(at.conditions, n)))


@apart
def start_switches(kernels: np.ndarray, sizes: Sizes, at: Workspace) -> None:
    """With switches runs begin with a change: it says what touches, before any event is looked at."""
    fresh = load(at.lanes, FRESH) != 0.0
    _look_at_start(kernels, sizes, at, fresh)
    store(at.lanes, STATUS, choose(fresh, 0.0, load(at.lanes, STATUS)))
    store(at.lanes, CHANGED, choose(fresh, splat(1.0), 0.0))
    store(at.lanes, FRESH, choose(fresh, splat(BEGINS), 0.0))


@apart
def start_events(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    plan: Plan,
) -> None:  # fmt: skip
    """The events of runs that begin: a condition that is true at once is one at the start."""
    count = layout.conditions(sizes)
    _look_at_start(kernels, sizes, at, load(at.lanes, FRESH) != 0.0)
    store(at.lanes, CHANGED, splat(0.0))
    for lane in range(W):
        failed = sizes.switches > 0 and rows[first.lanes + STATUS, lane] != 0.0
        if rows[first.lanes + FRESH, lane] != 0.0 and not failed:
            for condition in range(sizes.events):
                if rows[first.conditions + condition, lane] > 0.0:
                    rows[first.conditions + 2 * count + condition, lane] = 0.0
                    keep_state(first, rows, runs, queue, lane, condition, first.state)
            sift(sizes, first, rows, runs, queue, plan, lane, 0.0)
            pass_over(sizes, first, rows, lane)
            stop, change = _leaves(sizes, first, rows, plan, lane)
            note(sizes, first, rows, runs, queue, lane, 0.0)
            rows[first.lanes + STATUS, lane] = codes.STOPPED if stop < NEVER else 0.0
            rows[first.lanes + CHANGED, lane] = 1.0 if stop == NEVER and change < NEVER else 0.0
    store(at.lanes, FRESH, choose(load(at.lanes, FRESH) != 0.0, splat(1.0), 0.0))


@inlined
def _carried(sizes: Sizes, at: Workspace, plan: Plan, condition: int) -> Mask:
    """In which lanes a condition of a switch is how fast others move what sticks in a joint that they hold: the motion
    goes on as it is, and between the ends of a step there is no more than the error of its extension to be seen."""
    switch = condition // layout.CONDITIONS
    on, mask = layout.on_row(sizes) + switch, layout.mask_row(sizes) + plan.switches[switch, SWITCH_FIRST]
    dry = plan.switches[switch, SWITCH_KIND] == FRICTION and condition % layout.CONDITIONS == SLIDES
    return (splat(1.0 if dry else 0.0) != 0.0) & (load(at.new, on) == STICK) & (load(at.new, mask) == 0.0)


@inlined
def _carries(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> bool:
    """Whether at the end of the open step others move what sticks in a joint that they hold."""
    times, some = first.conditions + 2 * layout.conditions(sizes) + sizes.events + SLIDES, False
    for s in range(sizes.switches):
        mask = first.new + layout.mask_row(sizes) + plan.switches[s, SWITCH_FIRST]
        held = rows[first.new + layout.on_row(sizes) + s, lane] == STICK and rows[mask, lane] == 0.0
        found = rows[times + layout.CONDITIONS * s, lane] < NEVER
        some = some or (found and held and plan.switches[s, SWITCH_KIND] == FRICTION)
    return some


@inlined
def _noise(sizes: Sizes, at: Workspace, plan: Plan, force: Lanes, condition: int) -> Lanes:
    """What a condition of a switch may be by rounding at the end of the open step, in its own unit: a force, a rate, or
    a part of a length; force: that of what is closed (N). An open gap may be further below 0 where what it lies between
    comes apart, or rests: it has been hit already."""
    switch, rates = condition // layout.CONDITIONS, layout.conditions(sizes) + sizes.events + SLIDES - OPENS
    mode, speed = load(at.new, layout.on_row(sizes) + switch), load(at.change, layout.change_speeds(sizes) + switch)
    if condition % layout.CONDITIONS == SLIDES:
        slow = choose(mode == STICK, force, SLIGHT * speed)
        return choose(_carried(sizes, at, plan, condition), SLIGHT * speed, slow)
    rate = load(at.conditions, rates + condition)
    least = choose(rate > STILL * speed, splat(LEAVES), choose(rate >= -STILL * speed, splat(TOUCH), splat(SLIGHT)))
    return choose(mode != OFF, force, least)


@apart
def _see(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    plan: Plan, end: float, good: Mask,
) -> Lanes:  # fmt: skip
    """The conditions at the end of the open step, and of each whether its time is SOUGHT, is that of the end or is
    NEVER, in the lanes `good`. What becomes true as the time passes the end of a step that ends on a discontinuity is
    true at the end. Returns the status of lanes in which there something does what it cannot; 0 elsewhere."""
    count = layout.conditions(sizes)
    new, times = at.conditions + ROW * count, at.conditions + ROW * 2 * count
    until, noise = load(at.lanes, UNTIL), splat(0.0)
    store(at.clock, layout.TIME, until)
    call(kernels[layout.EVENTS], at.new, at.parameters, at.clock, 0, new, at.work)
    keep_rates(sizes, at, new)
    fails = certificates.judge(sizes, at, plan)  # before times of conditions take the place of these rows
    hold(sizes, at, new)
    jumps = good & (until == load(at.lanes, JUMP)) & (until < end)
    if any_lane(jumps):
        store(at.clock, layout.TIME, until * BEHIND)
        call(kernels[layout.EVENTS], at.new, at.parameters, at.clock, 0, at.following, at.work)
        doubt_rates(sizes, at, new, jumps)
    for s in range(sizes.switches):
        force = SLIGHT * absolute(load(new, sizes.events + layout.CONDITIONS * s + OPENS))
        closed = load(at.new, layout.on_row(sizes) + s) != OFF
        noise = choose(closed & (force > noise), force, noise)
    for n in range(count):
        if n >= sizes.events and plan.switches[(n - sizes.events) // layout.CONDITIONS, SWITCH_KIND] == BILATERAL:
            store(times, n, splat(NEVER))
            continue
        if n >= sizes.events:  # what is noise now is not true, whatever is noise at the end of the next step
            least = _noise(sizes, at, plan, noise, n - sizes.events)
            store(new, n, choose(load(new, n) > least, load(new, n), minimum(load(new, n), splat(0.0))))
        turned = good & (load(new, n) > 0.0) & (choose(load(at.conditions, n) > 0.0, 1.0, 0.0) == 0.0)
        time = choose(turned, splat(SOUGHT), splat(NEVER))
        if n >= sizes.events:
            time = choose(turned & _carried(sizes, at, plan, n - sizes.events), until, time)
        if n < sizes.events and any_lane(jumps):
            behind = load(at.following, n)
            passed = jumps & (load(new, n) <= 0.0) & (load(at.conditions, n) <= 0.0)
            passed = passed & ((behind > 0.0) | rises_here(sizes, at, n))
            time = choose(passed, until, time)
            store(new, n, choose(passed, choose(behind > 0.0, behind, splat(HOLDS)), load(new, n)))
        store(times, n, time)
        if n < runs.event_states.shape[1] and any_lane(time == until):
            store(at.lanes, PICKED, choose(time == until, splat(1.0), splat(0.0)))
            for lane in range(W):
                if rows[first.lanes + PICKED, lane] != 0.0:
                    keep_state(first, rows, runs, queue, lane, n, first.new)
    for n in range(sizes.events):
        if plan.acts[n, ACTION] != RECORDS and any_lane(load(times, n) < NEVER):
            if_it_acts(sizes, first, rows, runs, queue, plan, n)
    return fails


@apart
def find_events(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, end: float, good: Mask, t: Lanes, length: Lanes,
) -> Lanes:  # fmt: skip
    """What happens within the step in the lanes `good`; returns the time at which it is left, because an event stops
    the run or the mechanism changes (CHANGED), infinite where neither does, and the end of the step at least. Where a
    step is to be tried again, to end directly behind a change, or halfway where friction pushes at its end, the time of
    that is its CUT, and -1 is returned."""
    count, happened, sought, leaving = layout.conditions(sizes), splat(0.0), splat(0.0), splat(0.0)
    times = at.conditions + ROW * 2 * count
    store(at.lanes, CHANGED, splat(0.0))
    store(at.lanes, NEAR, splat(0.0))
    fails = _see(kernels, sizes, at, first, rows, runs, queue, plan, end, good)
    for n in range(count):
        sought = choose(load(times, n) == SOUGHT, splat(1.0), sought)
    store(at.clock, layout.TIME, t)
    if any_lane(sought != 0.0):
        search(kernels, sizes, nodes, at, first, rows, runs, queue, plan, sought != 0.0, t, length)
    walked = loaded(sizes, at, plan, good, length)
    if any_lane(walked > 0.0):
        seek_loads(kernels, sizes, nodes, at, first, rows, runs, queue, plan, end, walked > 0.0, t, length)
    seek_turns(kernels, sizes, nodes, at, first, rows, runs, queue, plan, good, walked, t, length)
    seek_first(kernels, sizes, nodes, at, first, rows, runs, queue, plan, good, t, length)
    for n in range(count):
        happened = choose(load(times, n) < NEVER, splat(1.0), happened)
        if n >= sizes.events or plan.stops[n] != 0 or plan.acts[n, ACTION] != RECORDS:
            leaving = choose(load(times, n) < NEVER, splat(1.0), leaving)
    chosen = kernels[layout.CLOSE] != 0 or kernels[layout.EXPAND] != 0  # the length of the step
    again = good & (leaving == 0.0) & (fails == splat(codes.PUSHED)) & (length > (FINEST * end if chosen else NEVER))
    happened = choose(again, splat(0.0), happened)
    store(at.lanes, CUT, choose(again, t + 0.5 * length, load(at.lanes, CUT)))
    store(at.lanes, REJECTED, load(at.lanes, REJECTED) + choose(again, splat(1.0), 0.0))
    store(at.clock, layout.TIME, t)
    store(at.lanes, PICKED, happened)
    exact = kernels[layout.EXPAND] != 0
    for lane in range(W):
        leaves = NEVER
        if rows[first.lanes + PICKED, lane] != 0.0:
            step = rows[first.clock + layout.LENGTH, lane]
            for condition in range(sizes.events, count):
                gather(sizes, first, rows, lane, rows[first.conditions + 2 * count + condition, lane], step)
            sift(sizes, first, rows, runs, queue, plan, lane, step)
            stop, change = _leaves(sizes, first, rows, plan, lane)
            part = (change - rows[first.clock + layout.TIME, lane]) / step
            inside = not exact and EDGE < part < 1.0 - EDGE
            if change - (LATER * step if inside else 0.0) >= stop:
                change, inside = NEVER, False
            leaves = min(stop, change)
            if inside:
                rows[first.lanes + CUT, lane], leaves = change + LATER * step, -1.0
            elif (
                step > SOON * end
                and leaves == rows[first.lanes + UNTIL, lane]
                and _carries(sizes, first, rows, plan, lane)
            ):
                rows[first.lanes + CUT, lane], leaves = leaves - 0.5 * step, -1.0
            else:
                pass_over(sizes, first, rows, lane)
                gather(sizes, first, rows, lane, leaves, step)
                note(sizes, first, rows, runs, queue, lane, leaves)
                rows[first.lanes + CHANGED, lane] = 1.0 if change < NEVER else 0.0
        rows[first.lanes + PICKED, lane] = leaves
    left = choose(again, splat(-1.0), load(at.lanes, PICKED))
    count_more(kernels, sizes, nodes, at, first, rows, runs, queue, plan, good & (left >= 0.0), t, length, left)
    changes, sets = good & (left >= 0.0) & (load(at.lanes, CHANGED) != 0.0), False
    for n in range(sizes.events):
        sets = sets or plan.acts[n, ACTION] == SETS
    if sets and any_lane(changes):  # of what is locked conditions are 0 by that
        see_peaks(kernels, sizes, nodes, at, changes, t, length, left)
    going, new = good & (left >= 0.0), at.conditions + ROW * count
    going = going & (load(at.lanes, CHANGED) == 0.0)
    store(at.lanes, STATUS, choose(going & (fails != 0.0), fails, load(at.lanes, STATUS)))
    go_on(sizes, at, new, going)
    return left


@inlined
def leave(sizes: Sizes, at: Workspace, left: Lanes, good: Mask) -> None:
    """Runs that leave their step, in the state that is in `now` where that is within it; those that an event has
    stopped end there."""
    leaves = good & (left < NEVER)
    stages.commit(leaves & (left < load(at.lanes, UNTIL)), at.state, at.now, layout.state_rows(sizes))
    stopped = leaves & (load(at.lanes, CHANGED) == 0.0)
    store(at.lanes, STATUS, choose(stopped, splat(codes.STOPPED), load(at.lanes, STATUS)))
    t = choose(leaves, left, load(at.lanes, T))
    store(at.lanes, T, t)
    passed = good & ((t >= load(at.lanes, CUT)) | (load(at.lanes, CHANGED) != 0.0))
    store(at.lanes, CUT, choose(passed, splat(NEVER), load(at.lanes, CUT)))
