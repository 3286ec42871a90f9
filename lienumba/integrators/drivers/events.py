"""Events: conditions that become true, located on the continuous extension of the open step.

Where the mechanism changes, what the step was computed with is as good as the method at its ends alone: a step that has
a change inside is tried again, to end on it. A series is as good everywhere.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Plan, Queue
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    ACTION,
    BUSY,
    CHANGED,
    CUT,
    FRESH,
    LOCKS,
    OFF,
    ONCE,
    OPENS,
    PICKED,
    RECORDS,
    RELEASES,
    SETS,
    SLIDE,
    SLIDES,
    STATUS,
    SWITCH_KIND,
    TARGET,
    TARGETS,
    UNILATERAL,
    UNTIL,
    Sizes,
    T,
    Workspace,
)  # fmt: skip
from lienumba.numerics.operations import absolute, maximum

FINEST = 2.0**-52  # a fraction of a step is known to the last bit
LONGEST_SEARCH = 200  # of tries
SLIGHT = 1e-12  # of the largest normal force: a force below that is 0
TOUCH = 1e-9  # of the length of a contact: where its gap is at most so wide it touches
EDGE = 1e-3  # of a step: nearer to its ends the extension is as good as the step
ROUGH = 2.0**-13  # of a step: how exactly it is known where a step is cut, on whose end all is located again
FLAT = 0.0625  # a secant that goes less far tells nothing


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
    kernels: np.ndarray, at: Workspace, event: int, t: Lanes, length: Lanes, end: Lanes, before: Lanes, after: Lanes,
    lanes: Mask, rough: bool,
) -> Lanes:  # fmt: skip
    """The fraction of the open step at which a condition is true, directly behind one at which it is not, in these
    lanes, as exactly as times are different numbers; before, after: what it is at the start and at the fraction `end`;
    rough: within `ROUGH` will do where it is not near an end of the step. By Chandrupatla's method, from a secant on:
    inverse quadratic interpolation where three values allow it, else halves. Where the root stays on one side, it is
    felt for in steps that double: near it a condition is rounding, of which no interpolation makes sense."""
    low, high, f_low, f_high = splat(0.0), end, before, after
    third, f_third = splat(0.0), before  # the end that was replaced last
    newest_low, part = splat(1.0), before / (before - after)  # whether the last value is that of `low`; of the way on
    part = choose(part > FLAT, part, 0.5)
    finest = FINEST * maximum(splat(1.0), (t + length) / length)
    least, reach, left = finest, finest, lanes
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
        newest = choose(true, splat(0.0), splat(1.0))
        if rough:
            least = choose((x > 2.0 * EDGE) & (x < 1.0 - 2.0 * EDGE), maximum(finest, splat(ROUGH)), finest)
        reach = choose(newest == newest_low, maximum(2.0 * reach, least), least)
        newest_low = choose(left, newest, newest_low)
        left = left & (high - low > least)
        part = choose(left, _part(low, f_low, high, f_high, third, f_third, newest_low == 1.0, reach), part)
    store(at.clock, layout.TIME, t)
    return high


@inlined
def _part(
    low: Lanes, f_low: Lanes, high: Lanes, f_high: Lanes, third: Lanes, f_third: Lanes, lower: Mask, reach: Lanes
) -> Lanes:  # fmt: skip
    """Where to look next, as a part of the way from the newest end of the bracket to the other; reach: how far away
    from both at least."""
    a, f_a = choose(lower, low, high), choose(lower, f_low, f_high)
    b, f_b = choose(lower, high, low), choose(lower, f_high, f_low)
    across, place = (a - b) / (third - b), (f_a - f_b) / (f_third - f_b)
    smooth = (place * place < across) & ((1.0 - place) * (1.0 - place) < 1.0 - across)
    towards = f_a / (f_b - f_a) * (f_third / (f_b - f_third))
    towards = towards + (third - a) / (b - a) * (f_a / (f_third - f_a)) * (f_b / (f_third - f_b))
    part = choose(smooth, towards, 0.5)
    nearest = reach / (high - low)  # so that the other end comes near, too
    nearest = choose(nearest < 0.5, nearest, 0.5)
    part = choose(part > nearest, part, nearest)
    return choose(part < 1.0 - nearest, part, 1.0 - nearest)


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


@apart
def keep_state(first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, lane: int, event: int, source: int) -> None:
    """Keep the state at an event that is the first of its kind, where they are wanted."""
    block, place = queue.block[lane], queue.lane[lane]
    if event < runs.event_states.shape[1] and runs.event_counts[block, event, place] == 0.0:
        for row in range(runs.event_states.shape[2]):
            runs.event_states[block, event, row, place] = rows[source + row, lane]


@inlined
def _leaves(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> tuple[float, float]:
    """When an event stops the run of a lane, and when the mechanism changes; infinite if never."""
    times, stop, change = first.conditions + 2 * layout.conditions(sizes), NEVER, NEVER
    for event in range(sizes.events):
        if plan.stops[event] != 0:
            stop = min(stop, rows[times + event, lane])
        elif plan.acts[event, ACTION] != RECORDS:
            change = min(change, rows[times + event, lane])
    for condition in range(sizes.events, layout.conditions(sizes)):
        change = min(change, rows[times + condition, lane])
    return stop, change


@apart
def start_events(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    plan: Plan,
) -> None:  # fmt: skip
    """The conditions of runs that begin; one that is true at once is an event at the start. With switches runs begin
    with a change: it says what touches."""
    count = layout.conditions(sizes)
    fresh = load(at.lanes, FRESH) != 0.0
    store(at.clock, layout.TIME, splat(0.0))
    call(kernels[layout.EVENTS], at.state, at.parameters, at.clock, 0, at.following, at.work)
    stages.commit(fresh, at.conditions, at.following, count)
    for lane in range(W):
        if rows[first.lanes + FRESH, lane] != 0.0:
            for condition in range(count):
                true = condition < sizes.events and rows[first.conditions + condition, lane] > 0.0
                rows[first.conditions + 2 * count + condition, lane] = 0.0 if true else NEVER
                if true:
                    keep_state(first, rows, runs, queue, lane, condition, first.state)
            stop, change = _leaves(sizes, first, rows, plan, lane)
            note(sizes, first, rows, runs, queue, lane, 0.0)
            rows[first.lanes + STATUS, lane] = codes.STOPPED if stop < NEVER else 0.0
            changes = stop == NEVER and (change < NEVER or sizes.switches > 0)
            rows[first.lanes + CHANGED, lane] = 1.0 if changes else 0.0


@apart
def _acts(sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, event: int) -> None:
    """PICKED where an event would do something: what is locked is not locked again."""
    action, on = plan.acts[event, ACTION], first.state + layout.on_row(sizes)
    for lane in range(W):
        turns, useful = LOCKS <= action <= RELEASES, action == SETS
        for n in range(plan.acts[event, TARGET], plan.acts[event, TARGET] + plan.acts[event, TARGETS]):
            if turns:
                holds = rows[on + plan.targets[n], lane] != OFF
                useful = useful or (holds if action == RELEASES else not holds)
        if plan.acts[event, ONCE] != 0 and rows[first.lanes + BUSY, lane] != 0.0:
            useful = useful and runs.event_counts[queue.block[lane], event, queue.lane[lane]] == 0.0
        rows[first.lanes + PICKED, lane] = 1.0 if useful else 0.0


@apart
def _find(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, plan: Plan, n: int, t: Lanes, length: Lanes, turned: Mask
) -> None:  # fmt: skip
    """When a condition becomes true in these lanes, to its time. Of an open gap that begins to grow it is looked for
    the time at which it closed before, if it did, by more than what touches."""
    count = layout.conditions(sizes)
    new, times = at.conditions + ROW * count, at.conditions + ROW * 2 * count
    before, after = load(at.conditions, n), load(new, n)
    before = choose(before < 0.0, before, -after)  # at 0, where something has just closed or opened
    switch = (n - sizes.events) // layout.CONDITIONS
    second = n >= sizes.events and (n - sizes.events) % layout.CONDITIONS == SLIDES
    dipping = second and plan.switches[switch, SWITCH_KIND] == UNILATERAL
    acts = n >= sizes.events or (plan.acts[n, ACTION] != RECORDS and plan.stops[n] == 0)
    rough = acts and not dipping and kernels[layout.EXPAND] == 0
    fraction = locate(kernels, at, n, t, length, splat(1.0), before, after, turned, rough)
    if dipping:
        gap, on = n - SLIDES + OPENS, load(at.state, layout.on_row(sizes) + switch)
        deep = _margin(kernels, at, gap, t, length, fraction)
        dips = turned & (on == float(OFF)) & (deep > TOUCH) & (load(times, gap) == NEVER)
        turned = turned & (on != float(OFF))
        if any_lane(dips):
            part = locate(kernels, at, gap, t, length, fraction, -deep, deep, dips, False)
            store(times, gap, choose(dips, t + part * length, load(times, gap)))
        store(at.clock, layout.TIME, t)
    time = choose(fraction == 1.0, load(at.lanes, UNTIL), t + fraction * length)
    store(times, n, choose(turned, time, load(times, n)))


@inlined
def _closed(sizes: Sizes, at: Workspace, plan: Plan, n: int) -> Mask:
    """Where a condition is about the forces of a contact that is closed, and sticks if it is about its friction."""
    switch = (n - sizes.events) // layout.CONDITIONS
    on, second = load(at.state, layout.on_row(sizes) + switch), (n - sizes.events) % layout.CONDITIONS == SLIDES
    contact = 1.0 if plan.switches[switch, SWITCH_KIND] == UNILATERAL else 0.0
    return (on > float(OFF)) & (on < (float(SLIDE) if second else 3.0)) & (splat(contact) > 0.0)


@apart
def find_events(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, good: Mask, t: Lanes, length: Lanes,
) -> Lanes:  # fmt: skip
    """What happens within the step in the lanes `good`; returns the time at which it is left, because an event stops
    the run or the mechanism changes (CHANGED), infinite where neither does, and the end of the step at least. Where a
    step is to be tried again, to end on a change, the time of that is its CUT, and -1 is returned."""
    count, extended, happened = layout.conditions(sizes), False, splat(0.0)
    new, times = at.conditions + ROW * count, at.conditions + ROW * 2 * count
    store(at.lanes, CHANGED, splat(0.0))
    store(at.clock, layout.TIME, load(at.lanes, UNTIL))
    call(kernels[layout.EVENTS], at.new, at.parameters, at.clock, 0, new, at.work)
    noise = splat(0.0)
    for s in range(sizes.switches):
        noise = maximum(noise, SLIGHT * absolute(load(new, sizes.events + layout.CONDITIONS * s + OPENS)))
    for n in range(count):
        least = choose(noise > 0.0, noise, 0.0) if n >= sizes.events else splat(0.0)
        turned = good & (load(new, n) > least) & (choose(load(at.conditions, n) > least, 1.0, 0.0) == 0.0)
        store(times, n, splat(NEVER))
        if n < sizes.events and plan.acts[n, ACTION] != RECORDS and any_lane(turned):
            _acts(sizes, first, rows, runs, queue, plan, n)
            turned = turned & (load(at.lanes, PICKED) != 0.0)
        if any_lane(turned):
            if not extended:
                stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
                extended = True
            _find(kernels, sizes, at, plan, n, t, length, turned)
            happened = choose(turned, splat(1.0), happened)
            if n < runs.event_states.shape[1]:
                between(kernels, at, (load(times, n) - t) / length)
                ends = turned & (load(times, n) == load(at.lanes, UNTIL))
                stages.commit(ends, at.now, at.new, layout.state_rows(sizes))
                store(at.lanes, PICKED, choose(turned, splat(1.0), splat(0.0)))
                for lane in range(W):
                    if rows[first.lanes + PICKED, lane] != 0.0:
                        keep_state(first, rows, runs, queue, lane, n, first.now)
        if n >= sizes.events:  # forces of redundant contacts do not tell: look again
            doubtful = good & _closed(sizes, at, plan, n) & (load(new, n) > least) & (load(times, n) == NEVER)
            store(times, n, choose(doubtful, load(at.lanes, UNTIL), load(times, n)))
            happened = choose(doubtful, splat(1.0), happened)
    store(at.lanes, PICKED, happened)
    exact = kernels[layout.EXPAND] != 0
    for lane in range(W):
        leaves = NEVER
        if rows[first.lanes + PICKED, lane] != 0.0:
            stop, change = _leaves(sizes, first, rows, plan, lane)
            step = rows[first.clock + layout.LENGTH, lane]
            part = (change - rows[first.clock + layout.TIME, lane]) / step
            inside = not exact and EDGE < part < 1.0 - EDGE
            if change - (ROUGH * step if inside else 0.0) >= stop:
                change, inside = NEVER, False
            leaves = min(stop, change)
            if inside:
                rows[first.lanes + CUT, lane], leaves = change, -1.0
            else:
                note(sizes, first, rows, runs, queue, lane, leaves)
                rows[first.lanes + CHANGED, lane] = 1.0 if change < NEVER else 0.0
        rows[first.lanes + PICKED, lane] = leaves
    left = load(at.lanes, PICKED)
    stages.commit(good & (left >= 0.0), at.conditions, new, count)
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
