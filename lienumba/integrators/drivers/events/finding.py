"""Events of the current step: which guard functions cross zero, when the step is left, and what that means for it."""

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import certificates, stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.events.acting import PAST, follow, gather, hold, if_it_acts, pass_over, sift
from lienumba.integrators.drivers.events.guards import (
    contact_of,
    drop_jumping_rates,
    end_value,
    evaluate,
    go_on,
    kind_of,
    may_cross,
    opens,
    rises_at_end,
    store_end_rates,
    time_row,
)
from lienumba.integrators.drivers.events.locate import CROSSES, POSSIBLE, count_repeats, ends_step, locate
from lienumba.integrators.drivers.events.tolerances import (
    CLOSED_GAP_RTOL,
    CONTACT_ROUNDOFF,
    CUT_BEHIND,
    EXACT_EDGE,
    NEXT_TIME,
    SEPARATING_GAP_RTOL,
    SHORTEST_CARRIED,
    SHORTEST_RETRIED,
)
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue, keep_state
from lienumba.integrators.drivers.switching.reactions import STILL
from lienumba.integrators.drivers.workspace import Context, Rows
from lienumba.integrators.layout import (
    ACTION,
    BEGINS,
    BILATERAL,
    CHANGED,
    CUT,
    FRESH,
    FRICTION,
    JUMP,
    LENGTH,
    NEAR_END,
    OFF,
    OPENS,
    PICKED,
    RECORDS,
    REJECTED,
    RESOLVED,
    SETS,
    SLIDES,
    STATUS,
    STICK,
    SWITCH_FIRST,
    UNTIL,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import HOLDS, absolute, maximum, minimum


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
def _leaves(context: Context, lane: int) -> tuple[float, float]:
    """When an event stops the run of a lane, and when the mechanism changes; infinite if never."""
    stop, change, plan = NEVER, NEVER, context.plan
    for n in range(layout.conditions(context.sizes)):
        time = context.rows[context.first.conditions + time_row(context, n), lane]
        if n >= context.sizes.events:
            change = min(change, time)
        elif plan.stops[n] != 0:
            stop = min(stop, time)
        elif plan.acts[n, ACTION] != RECORDS and time != PAST:
            change = min(change, time)
    return stop, change


@apart
def _evaluate_start(context: Context, fresh: Mask) -> None:
    """Evaluate guard functions where runs begin; none of them has crossed zero yet."""
    at, sizes, count = context.at, context.sizes, layout.conditions(context.sizes)
    store(at.lanes, RESOLVED, choose(fresh, 0.0, load(at.lanes, RESOLVED)))
    store(at.clock, layout.TIME, splat(0.0))
    call(context.kernels[layout.EVENTS], at.state, at.parameters, at.clock, 0, at.following, at.work)
    for row in range(layout.peak_row(sizes), layout.rise_row(sizes)):
        store(at.conditions, row, choose(fresh, 0.0, load(at.conditions, row)))
    lapsed = layout.peak_row(sizes) + layout.LAPSED * sizes.events
    for row in range(lapsed, lapsed + sizes.events):
        store(at.conditions, row, choose(fresh, splat(-NEVER), load(at.conditions, row)))
    for row in range(layout.rise_row(sizes), layout.rise_row(sizes) + count):
        store(at.conditions, row, choose(fresh, splat(NEVER), load(at.conditions, row)))
    follow(sizes, at, at.following, at.following + ROW * layout.rate_row(sizes), fresh)
    stages.commit(fresh, at.conditions, at.following, count)
    for n in range(count):
        row = time_row(context, n)
        store(at.conditions, row, choose(fresh, splat(NEVER), load(at.conditions, row)))


@apart
def start_switches(context: Context) -> None:
    """With contacts runs begin with a change: it says which are closed, before any event is looked at."""
    lanes = context.at.lanes
    fresh = load(lanes, FRESH) != 0.0
    _evaluate_start(context, fresh)
    store(lanes, STATUS, choose(fresh, 0.0, load(lanes, STATUS)))
    store(lanes, CHANGED, choose(fresh, splat(1.0), 0.0))
    store(lanes, FRESH, choose(fresh, splat(BEGINS), 0.0))


@apart
def start_events(context: Context, runs: ChunkRuns, queue: Queue) -> None:
    """The events of runs that begin: a condition that holds at once is an event at the start."""
    sizes, at, first, rows, plan = context.sizes, context.at, context.first, context.rows, context.plan
    _evaluate_start(context, load(at.lanes, FRESH) != 0.0)
    store(at.lanes, CHANGED, splat(0.0))
    for lane in range(W):
        failed = sizes.switches > 0 and rows[first.lanes + STATUS, lane] != 0.0
        if rows[first.lanes + FRESH, lane] != 0.0 and not failed:
            for event in range(sizes.events):
                if rows[first.conditions + event, lane] > 0.0:
                    rows[first.conditions + time_row(context, event), lane] = 0.0
                    keep_state(rows, runs, queue, lane, event, first.state)
            sift(sizes, first, rows, runs, queue, plan, lane, 0.0)
            pass_over(sizes, first, rows, lane)
            stop, change = _leaves(context, lane)
            note(sizes, first, rows, runs, queue, lane, 0.0)
            rows[first.lanes + STATUS, lane] = codes.STOPPED if stop < NEVER else 0.0
            rows[first.lanes + CHANGED, lane] = 1.0 if stop == NEVER and change < NEVER else 0.0
    store(at.lanes, FRESH, choose(load(at.lanes, FRESH) != 0.0, splat(1.0), 0.0))


@inlined
def _is_carried(context: Context, n: int) -> Mask:
    """In which lanes the nth guard function is how fast others move a joint that sticks, and that they hold: between
    the ends of a step it shows no more than the error of the continuous extension."""
    contact = contact_of(context, n)
    mode = load(context.at.new, layout.on_row(context.sizes) + contact)
    used = load(context.at.new, layout.mask_row(context.sizes) + context.plan.switches[contact, SWITCH_FIRST])
    dry = kind_of(context, n) == FRICTION and not opens(context, n)
    return (splat(1.0 if dry else 0.0) != 0.0) & (mode == STICK) & (used == 0.0)


@inlined
def _carries(context: Context, lane: int) -> bool:
    """Whether at the end of the step others move a joint that sticks, and that they hold."""
    sizes, first, some = context.sizes, context.first, False
    for n in range(sizes.events, layout.conditions(sizes)):
        if kind_of(context, n) == FRICTION and not opens(context, n):
            contact = contact_of(context, n)
            mask = first.new + layout.mask_row(sizes) + context.plan.switches[contact, SWITCH_FIRST]
            held = (
                context.rows[first.new + layout.on_row(sizes) + contact, lane] == STICK
                and context.rows[mask, lane] == 0.0
            )
            some = some or (held and context.rows[first.conditions + time_row(context, n), lane] < NEVER)
    return some


@inlined
def _roundoff(context: Context, n: int, force: Lanes) -> Lanes:
    """What the nth guard function, of a contact, may be by roundoff at the end of the step, in its own unit: a force, a
    rate, or a part of a length; force: that of the closed contacts (N). An open gap may be below 0 by more where the
    bodies separate, or rest: it has been hit already."""
    contact = contact_of(context, n)
    mode = load(context.at.new, layout.on_row(context.sizes) + contact)
    speed = load(context.at.change, layout.change_speeds(context.sizes) + contact)
    if not opens(context, n):
        return choose(
            (mode == STICK) & (choose(_is_carried(context, n), 1.0, 0.0) == 0.0), force, CONTACT_ROUNDOFF * speed
        )
    rate = end_value(context, n + SLIDES - OPENS)
    rests = choose(rate >= -STILL * speed, splat(CLOSED_GAP_RTOL), splat(CONTACT_ROUNDOFF))
    least = choose(rate > STILL * speed, splat(SEPARATING_GAP_RTOL), rests)
    return choose(mode != OFF, force, least)


@inlined
def _largest_force(context: Context) -> Lanes:
    """The largest force of closed contacts (N) at the end of the step."""
    largest = splat(0.0)
    for s in range(context.sizes.switches):
        force = absolute(end_value(context, context.sizes.events + layout.CONDITIONS * s + OPENS))
        closed = load(context.at.new, layout.on_row(context.sizes) + s) != OFF
        largest = choose(closed & (force > largest), force, largest)
    return largest


@apart
def _evaluate_end(context: Context, runs: ChunkRuns, queue: Queue, end: float, good: Mask) -> Lanes:
    """Evaluate guard functions at the end of the step, and mark in the lanes `good` which of them crosses zero, or may.

    Their times become CROSSES, POSSIBLE, the end of the step or infinity. What becomes true as the time passes the end
    of a step that ends on a discontinuity crosses at the end. Returns the status of lanes in which the contact laws are
    violated at the end, 0 elsewhere.
    """
    at, sizes, count = context.at, context.sizes, layout.conditions(context.sizes)
    new, until = at.conditions + ROW * count, load(at.lanes, UNTIL)
    store(at.clock, layout.TIME, until)
    call(context.kernels[layout.EVENTS], at.new, at.parameters, at.clock, 0, new, at.work)
    store_end_rates(context, new)
    fails = certificates.judge(sizes, at, context.plan)  # before times take the place of these rows
    hold(sizes, at, new)
    jumps = good & (until == load(at.lanes, JUMP)) & (until < end)
    if any_lane(jumps):
        store(at.clock, layout.TIME, until * NEXT_TIME)
        call(context.kernels[layout.EVENTS], at.new, at.parameters, at.clock, 0, at.following, at.work)
        drop_jumping_rates(context, new, jumps)
    store(at.clock, layout.TIME, load(at.lanes, T))
    roundoff = CONTACT_ROUNDOFF * _largest_force(context)
    for n in range(count):
        value, before = load(new, n), load(at.conditions, n)
        if n >= sizes.events:  # roundoff now is not a crossing, whatever is roundoff at the end of the next step
            value = choose(value > _roundoff(context, n, roundoff), value, minimum(value, splat(0.0)))
        crosses = good & (value > 0.0) & (choose(before > 0.0, 1.0, 0.0) == 0.0)
        time = choose(crosses, splat(CROSSES), splat(NEVER))
        if n >= sizes.events:
            mode = load(at.new, layout.on_row(sizes) + contact_of(context, n))
            bilateral = kind_of(context, n) == BILATERAL
            rate = splat(1.0 if bilateral or not (opens(context, n) or kind_of(context, n) == FRICTION) else 0.0) != 0.0
            time = choose(rate & ((mode == OFF) | (splat(1.0 if bilateral else 0.0) != 0.0)), splat(NEVER), time)
            time = choose(crosses & _is_carried(context, n), until, time)
        elif any_lane(jumps):
            behind = load(at.following, n)
            passed = jumps & (value <= 0.0) & (before <= 0.0) & ((behind > 0.0) | rises_at_end(context, n))
            time = choose(passed, until, time)
            value = choose(passed, choose(behind > 0.0, behind, splat(HOLDS)), value)
        store(new, n, value)
        store(at.conditions, time_row(context, n), time)
        if n < runs.event_states.shape[1] and any_lane(time == until):
            store(at.lanes, PICKED, choose(time == until, splat(1.0), splat(0.0)))
            for lane in range(W):
                if context.rows[context.first.lanes + PICKED, lane] != 0.0:
                    keep_state(context.rows, runs, queue, lane, n, context.first.new)
    for n in range(count):  # all end values are known now
        row = time_row(context, n)
        time = load(at.conditions, row)
        possible = good & ((time == NEVER) | (time == CROSSES)) & (may_cross(context, n) > 0.0)
        store(at.conditions, row, choose(possible, splat(POSSIBLE), time))
    for n in range(sizes.events):
        if context.plan.acts[n, ACTION] != RECORDS and any_lane(load(at.conditions, time_row(context, n)) < NEVER):
            if_it_acts(sizes, context.first, context.rows, runs, queue, context.plan, n)
    return fails


@apart
def find_events(context: Context, runs: ChunkRuns, queue: Queue, end: float, good: Mask) -> Lanes:
    """Find out what happens within the step in the lanes `good`.

    Returns the time (s) at which the step is left, because an event stops the run or the mechanism changes (CHANGED);
    infinity where neither does. A step is tried again, and -1 is returned, to end directly behind a change (there the
    result is as exact as the method, and inside it only as exact as the continuous extension), or halfway where
    friction gains energy at its end, or a joint that sticks has been moved by others: the time of that is its CUT.
    """
    at, first, rows, count = context.at, context.first, context.rows, layout.conditions(context.sizes)
    t, length, happens, leaves_step = load(at.lanes, T), load(at.clock, LENGTH), splat(0.0), splat(0.0)
    store(at.lanes, CHANGED, splat(0.0))
    store(at.lanes, NEAR_END, splat(0.0))
    fails, asked = _evaluate_end(context, runs, queue, end, good), splat(0.0)
    for n in range(count):
        asked = choose(load(at.conditions, time_row(context, n)) < 0.0, splat(1.0), asked)
    if any_lane(asked != 0.0):
        locate(context, runs, queue, end, asked != 0.0)
    for n in range(count):
        happens = choose(load(at.conditions, time_row(context, n)) < NEVER, splat(1.0), happens)
        if ends_step(context, n):
            leaves_step = choose(load(at.conditions, time_row(context, n)) < NEVER, splat(1.0), leaves_step)
    chosen = context.kernels[layout.CLOSE] != 0 or context.kernels[layout.EXPAND] != 0  # the length of the step
    halved = good & (leaves_step == 0.0) & (fails == splat(codes.PUSHED))
    halved = halved & (length > (SHORTEST_RETRIED * end if chosen else NEVER))
    store(at.lanes, CUT, choose(halved, t + 0.5 * length, load(at.lanes, CUT)))
    store(at.lanes, REJECTED, load(at.lanes, REJECTED) + choose(halved, splat(1.0), 0.0))
    store(at.lanes, PICKED, choose(halved, splat(0.0), happens))
    for lane in range(W):
        leaves = NEVER
        if rows[first.lanes + PICKED, lane] != 0.0:
            leaves = _leave_step(context, runs, queue, end, lane)
        rows[first.lanes + PICKED, lane] = leaves
    left = choose(halved, splat(-1.0), load(at.lanes, PICKED))
    going = good & (left >= 0.0)
    count_repeats(context, runs, queue, end, going, minimum(left, load(at.lanes, UNTIL)))
    _store_peaks(context, going & (load(at.lanes, CHANGED) != 0.0), left)
    going = going & (load(at.lanes, CHANGED) == 0.0)
    store(at.lanes, STATUS, choose(going & (fails != 0.0), fails, load(at.lanes, STATUS)))
    go_on(context, going)
    return left


@apart
def _leave_step(context: Context, runs: ChunkRuns, queue: Queue, end: float, lane: int) -> float:
    """The time at which a lane leaves the step in which something happens, see `find_events`; note its events, or set
    its CUT."""
    sizes, first, rows, leaves = context.sizes, context.first, context.rows, -1.0
    t, step = rows[first.lanes + T, lane], rows[first.clock + LENGTH, lane]
    for n in range(sizes.events, layout.conditions(sizes)):
        gather(sizes, first, rows, lane, rows[first.conditions + time_row(context, n), lane], step)
    sift(sizes, first, rows, runs, queue, context.plan, lane, step)
    stop, change = _leaves(context, lane)
    inside = context.kernels[layout.EXPAND] == 0 and EXACT_EDGE < (change - t) / step < 1.0 - EXACT_EDGE
    if change - (CUT_BEHIND * step if inside else 0.0) >= stop:
        change, inside = NEVER, False
    at_end = min(stop, change) == rows[first.lanes + UNTIL, lane]
    if inside:
        rows[first.lanes + CUT, lane] = change + CUT_BEHIND * step
    elif step > SHORTEST_CARRIED * end and at_end and _carries(context, lane):
        rows[first.lanes + CUT, lane] = min(stop, change) - 0.5 * step
    else:
        leaves = min(stop, change)
        pass_over(sizes, first, rows, lane)
        gather(sizes, first, rows, lane, leaves, step)
        note(sizes, first, rows, runs, queue, lane, leaves)
        rows[first.lanes + CHANGED, lane] = 1.0 if change < NEVER else 0.0
    return leaves


@apart
def _store_peaks(context: Context, lanes: Mask, left: Lanes) -> None:
    """The most that guard functions of events have been also halfway to where the step is left in these lanes, where
    events set numbers. Of what is locked they are 0 at the end of that."""
    sets = False
    for n in range(context.sizes.events):
        sets = sets or context.plan.acts[n, ACTION] == SETS
    if not (sets and any_lane(lanes)):
        return
    t, length = load(context.at.lanes, T), load(context.at.clock, LENGTH)
    stages.extend(context)
    evaluate(context, choose(lanes, 0.5 * (left - t) / length, 0.5))
    for n in range(context.sizes.events):
        row = layout.peak_row(context.sizes) + n
        most = load(context.at.conditions, row)
        store(context.at.conditions, row, choose(lanes, maximum(most, load(context.at.following, n)), most))
    store(context.at.clock, layout.TIME, t)


@inlined
def leave(context: Context, left: Lanes, good: Mask) -> None:
    """Runs that leave their step, in the state that is in `now` where that is within it; those that an event has
    stopped end there."""
    at = context.at
    leaves = good & (left < NEVER)
    stages.commit(leaves & (left < load(at.lanes, UNTIL)), at.state, at.now, layout.state_rows(context.sizes))
    stopped = leaves & (load(at.lanes, CHANGED) == 0.0)
    store(at.lanes, STATUS, choose(stopped, splat(codes.STOPPED), load(at.lanes, STATUS)))
    t = choose(leaves, left, load(at.lanes, T))
    store(at.lanes, T, t)
    passed = good & ((t >= load(at.lanes, CUT)) | (load(at.lanes, CHANGED) != 0.0))
    store(at.lanes, CUT, choose(passed, splat(NEVER), load(at.lanes, CUT)))


@inlined
def read_off(context: Context, left: Lanes) -> None:
    """The states at the times `left` of the current step, to `now`."""
    near = load(context.at.lanes, NEAR_END) != 0.0
    if any_lane(near):
        stages.extend_at_end(context, near)
    between(context.kernels, context.at, (left - load(context.at.lanes, T)) / load(context.at.clock, LENGTH))
