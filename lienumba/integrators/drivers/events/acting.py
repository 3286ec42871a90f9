"""Which conditions of events count: what had been true has to be really false before it comes true again, and of what
happens at one time each event sees what those before it have done. What only lets go is done here, too."""

from lienumba.compiler.lanes import Address, Lanes, Mask, choose, load, splat, store
from lienumba.compiler.routines.marks import Integers2, apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.bounds import finite_size
from lienumba.integrators.codes import HUGE
from lienumba.integrators.drivers.events.tolerances import REVERSAL_RTOL, SIMULTANEOUS_RTOL
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.hysteresis import HYSTERESIS_RTOL, ROOT_RTOL
from lienumba.integrators.layout import (
    ACTION,
    ENGAGES,
    FRESH,
    LOCKS,
    NEEDS,
    OFF,
    ONCE,
    RECORDS,
    RELEASES,
    SETS,
    SWITCH_FIRST,
    SWITCH_ROWS,
    TARGET,
    TARGETS,
    UNTIL,
    WRITTEN,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import HOLDS, absolute, maximum

PAST = float("-inf")  # the time of what came true, and does nothing


@inlined
def _largest(sizes: Sizes, at: Workspace, n: int, now: Lanes) -> Lanes:
    """The largest size that a condition has been."""
    return maximum(load(at.conditions, layout.peak_row(sizes) + layout.EXTENT * sizes.events + n), finite_size(now))


@inlined
def _held(now: Lanes, was: Lanes, peak: Lanes, largest: Lanes, band: Lanes) -> Lanes:
    """What a condition is: true where it was, and has not fallen by more than this band of its largest size since;
    false where it was, and is above 0 by rounding alone."""
    stays = (was > 0.0) & (now <= 0.0) & (peak - now <= band * largest)
    faint = (was <= 0.0) & (now > HOLDS) & (now <= ROOT_RTOL * largest)
    return choose(stays, splat(HOLDS), choose(faint, splat(0.0), now))


@apart
def hold(sizes: Sizes, at: Workspace, values: Address) -> None:
    """Apply the hysteresis to the guard functions of events at the address `values`: one that was above 0 stays so
    until it has fallen by `HYSTERESIS_RTOL`. A motor that is switched off when it turns has; a joint that is locked on
    its limit has not, and on which side of that it lies is roundoff."""
    for n in range(sizes.events):
        now, was, peak = load(values, n), load(at.conditions, n), load(at.conditions, layout.peak_row(sizes) + n)
        store(values, n, _held(now, was, peak, _largest(sizes, at, n, now), splat(HYSTERESIS_RTOL)))


@apart
def hold_before(sizes: Sizes, at: Workspace, plan: Plan, values: Address, lanes: Mask) -> None:
    """Apply the hysteresis directly before a change in these lanes.

    The event that causes the change may be what makes others false: those that have fallen to 0 by then are false, and
    those that set numbers where they are below 0 by more than roundoff. Where an event comes true that was made false
    just before, changes reverse each other, and of these all that are 0 are false: of a relay (`s < 0`, `s > 0`) none
    would be located again else. A joint that is locked on its limit reverses nothing.
    """
    t, times, again = load(at.lanes, T), 2 * layout.conditions(sizes), splat(0.0)
    lapsed = layout.peak_row(sizes) + layout.LAPSED * sizes.events
    for n in range(sizes.events):
        back = (load(at.conditions, times + n) == t) & (t - load(at.conditions, lapsed + n) <= REVERSAL_RTOL * t)
        again = choose(back, splat(1.0), again)
    for n in range(sizes.events):
        now, was, peak = load(values, n), load(at.conditions, n), load(at.conditions, layout.peak_row(sizes) + n)
        largest = _largest(sizes, at, n, now)
        ends, band = was > HYSTERESIS_RTOL * largest, splat(HYSTERESIS_RTOL)
        if plan.acts[n, ACTION] == SETS:
            turned = again != 0.0
            ends, band = turned | (peak > HYSTERESIS_RTOL * largest), choose(turned, splat(0.0), splat(0.5 * ROOT_RTOL))
        falls = (was > 0.0) & (now > 0.0) & (now <= ROOT_RTOL * largest) & ends
        held = choose(falls, splat(0.0), _held(now, was, peak, largest, band))
        store(values, n, held)
        last = load(at.conditions, lapsed + n)
        store(at.conditions, lapsed + n, choose(lanes & (was > 0.0) & (held <= 0.0), t, last))


@apart
def follow(sizes: Sizes, at: Workspace, values: Address, rates: Address, lanes: Mask) -> None:
    """Take the guard functions of events at the address `values`, and their rates, as those of now in these lanes."""
    peaks = at.conditions + ROW * layout.peak_row(sizes)
    for n in range(sizes.events):
        now, was = load(values, n), load(at.conditions, n)
        peak, largest = load(peaks, n), load(peaks, layout.EXTENT * sizes.events + n)
        store(peaks, n, choose(lanes, choose(was > 0.0, maximum(peak, now), now), peak))
        store(peaks, layout.EXTENT * sizes.events + n, choose(lanes, maximum(largest, finite_size(now)), largest))
        store(at.conditions, n, choose(lanes, now, was))
        rate, row, most = load(rates, n), layout.RATE * sizes.events + n, layout.SWIFTEST * sizes.events + n
        store(peaks, row, choose(lanes, rate, load(peaks, row)))
        swiftest = load(peaks, most)
        store(peaks, most, choose(lanes & (absolute(rate) > swiftest), absolute(rate), swiftest))


@apart
def rescale(sizes: Sizes, at: Workspace, plan: Plan, values: Address, lanes: Mask) -> None:
    """Take the scale of conditions of the scenario from their new values, in these lanes, where the values have jumped
    by more than the hysteresis band; those that a jump makes false are. To be called when an event has set numbers,
    before anything else changes."""
    peaks = at.conditions + ROW * layout.peak_row(sizes)
    for n in range(sizes.events):
        now, was = load(values, n), load(at.conditions, n)
        extent = load(peaks, layout.EXTENT * sizes.events + n)
        written = splat(float(plan.acts[n, WRITTEN])) != 0.0
        jumps = lanes & written & (absolute(now - was) > HYSTERESIS_RTOL * extent)
        store(at.conditions, n, choose(jumps & (was > 0.0) & (now <= 0.0), now, was))
        store(peaks, n, choose(jumps, now, load(peaks, n)))
        store(peaks, layout.EXTENT * sizes.events + n, choose(jumps, finite_size(now), extent))


@inlined
def follow_one(sizes: Sizes, first: Workspace, rows: Rows, lane: int, event: int, now: float) -> None:
    """`follow` for one event of one lane, whose rate is in `following`."""
    peak = first.conditions + layout.peak_row(sizes) + event
    was = rows[first.conditions + event, lane]
    rows[peak, lane] = max(rows[peak, lane], now) if was > 0.0 else now
    extent = peak + layout.EXTENT * sizes.events
    rows[extent, lane] = max(rows[extent, lane], max(now, -now) if -HUGE < now < HUGE else 0.0)
    rows[first.conditions + event, lane] = now
    rows[peak + layout.RATE * sizes.events, lane] = rows[first.following + layout.rate_row(sizes) + event, lane]


@inlined
def fired(sizes: Sizes, first: Workspace, rows: Rows, lane: int, condition: int) -> bool:
    """Whether a condition has become true now."""
    return rows[first.conditions + 2 * layout.conditions(sizes) + condition, lane] == rows[first.lanes + T, lane]


@inlined
def used(sizes: Sizes, first: Workspace, rows: Rows, switches: Integers2, lane: int, switch: int) -> bool:
    """Whether the first row of a switch is in use: no others hold it."""
    return rows[first.state + layout.mask_row(sizes) + switches[switch, SWITCH_FIRST], lane] != 0.0


@inlined
def turns(plan: Plan, event: int, switch: int) -> float:
    """How an event leaves a switch: 1 on, 0 off, -1 as it is."""
    action, to = plan.acts[event, ACTION], -1.0
    if LOCKS <= action <= RELEASES:
        for n in range(plan.acts[event, TARGET], plan.acts[event, TARGET] + plan.acts[event, TARGETS]):
            if plan.targets[n] == switch:
                to = 0.0 if action == RELEASES else 1.0
    return to


@inlined
def _on(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, event: int, switch: int) -> float:
    """Whether a switch is on when an event acts, behind those before it in the file that act at the same time."""
    times = first.conditions + 2 * layout.conditions(sizes)
    on = 0.0 if rows[first.state + layout.on_row(sizes) + switch, lane] == OFF else 1.0
    for other in range(event):
        if rows[times + other, lane] == rows[times + event, lane]:
            to = turns(plan, other, switch)
            on = on if to < 0.0 else to
    return on


@apart
def _useful(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, lane: int, event: int
) -> bool:
    """Whether an event does something at its time: what is locked is not locked again, nor what is not there."""
    action, needs = plan.acts[event, ACTION], plan.acts[event, NEEDS]
    useful = not LOCKS <= action <= RELEASES
    for n in range(plan.acts[event, TARGET], plan.acts[event, TARGET] + plan.acts[event, TARGETS]):
        if LOCKS <= action <= RELEASES:
            on, switch = 0.0 if action == RELEASES else 1.0, plan.targets[n]
            useful = useful or _on(sizes, first, rows, plan, lane, event, switch) != on
    if needs >= 0:
        useful = useful and _on(sizes, first, rows, plan, lane, event, needs) != 0.0
    return useful and (plan.acts[event, ONCE] == 0 or not _acted(runs, queue, lane, event))


@inlined
def _acted(runs: ChunkRuns, queue: Queue, lane: int, event: int) -> bool:
    """Whether an event has happened in the run of a lane."""
    return runs.event_counts[queue.block[lane], event, queue.lane[lane]] != 0.0


@apart
def may_act(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, lane: int, event: int
) -> bool:
    """Whether an event that comes true in the open step may do something, though when it does is yet to be found: also
    by what others do that come true in it."""
    times, action = first.conditions + 2 * layout.conditions(sizes), plan.acts[event, ACTION]
    useful, needs = not LOCKS <= action <= RELEASES, plan.acts[event, NEEDS]
    if plan.acts[event, ONCE] != 0 and _acted(runs, queue, lane, event):
        return False
    for n in range(plan.acts[event, TARGET], plan.acts[event, TARGET] + plan.acts[event, TARGETS]):
        if not useful:
            holds = rows[first.state + layout.on_row(sizes) + plan.targets[n], lane] != OFF
            useful = holds if action == RELEASES else not holds
            for other in range(sizes.events):
                if other != event and rows[times + other, lane] < NEVER:
                    useful = useful or turns(plan, other, plan.targets[n]) >= 0.0
    if needs >= 0 and rows[first.state + layout.on_row(sizes) + needs, lane] == OFF:
        there = False
        for other in range(event):
            there = there or (rows[times + other, lane] < NEVER and turns(plan, other, needs) > 0.0)
        useful = useful and there
    return useful


@apart
def if_it_acts(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, event: int
) -> None:
    """An event comes true only in lanes in which it may act."""
    time = first.conditions + 2 * layout.conditions(sizes) + event
    for lane in range(W):
        if rows[time, lane] < NEVER and not may_act(sizes, first, rows, runs, queue, plan, lane, event):
            rows[time, lane] = NEVER


@apart
def sift(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, lane: int, length: float
) -> None:
    """Of the events that are to act, what happens first in a step of this length: at one time what comes within
    rounding of it; PAST is the time of what does nothing then, as all does where the run ends at that time."""
    times, acts, stop = first.conditions + 2 * layout.conditions(sizes), False, NEVER
    for event in range(sizes.events):
        if plan.stops[event] != 0:
            stop = min(stop, rows[times + event, lane])
    while not acts:
        earliest = NEVER
        for event in range(sizes.events):
            time = rows[times + event, lane]
            if plan.acts[event, ACTION] != RECORDS and time != PAST:
                earliest = min(earliest, time)
        if earliest == NEVER:
            return
        rounding = SIMULTANEOUS_RTOL * max(length, earliest)
        ends = max(stop - earliest, earliest - stop) <= rounding
        for event in range(sizes.events):
            time = rows[times + event, lane]
            at_once = time != PAST and time - earliest <= rounding
            if plan.acts[event, ACTION] != RECORDS and at_once:
                rows[times + event, lane] = earliest
                if not ends and _useful(sizes, first, rows, runs, queue, plan, lane, event):
                    acts = True
                else:
                    rows[times + event, lane] = PAST


@apart
def gather(sizes: Sizes, first: Workspace, rows: Rows, lane: int, leaves: float, length: float) -> None:
    """What comes later than a change, or the end of a run, in a step of this length, by rounding of times or of its
    condition, comes then: behind that it might never come."""
    count = layout.conditions(sizes)
    for event in range(sizes.events):
        time, end = rows[first.conditions + 2 * count + event, lane], rows[first.conditions + count + event, lane]
        if leaves < time < NEVER:
            largest = rows[first.conditions + layout.peak_row(sizes) + layout.EXTENT * sizes.events + event, lane]
            rest = ROOT_RTOL * largest * (rows[first.lanes + UNTIL, lane] - time)
            lacks = end > 0.0 and (time - leaves) * end <= rest  # else it has come and gone
            if lacks or time - leaves <= SIMULTANEOUS_RTOL * max(length, leaves):
                rows[first.conditions + 2 * count + event, lane] = leaves


@apart
def pass_over(sizes: Sizes, first: Workspace, rows: Rows, lane: int) -> None:
    """What is PAST has been true, and is no event."""
    times = first.conditions + 2 * layout.conditions(sizes)
    for event in range(sizes.events):
        if rows[times + event, lane] == PAST:
            rows[times + event, lane], rows[first.conditions + event, lane] = NEVER, HOLDS
            rows[first.conditions + layout.peak_row(sizes) + event, lane] = HOLDS


@apart
def engages(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, event: int) -> bool:
    """Whether an event engages a joint now, and none behind it in the file releases it at once."""
    times, now = first.conditions + 2 * layout.conditions(sizes), rows[first.lanes + T, lane]
    if plan.acts[event, ACTION] != ENGAGES or rows[times + event, lane] != now:
        return False
    stays, joint = True, plan.targets[plan.acts[event, TARGET]]
    for other in range(event + 1, sizes.events):
        if rows[times + other, lane] == now:
            stays = stays and turns(plan, other, joint) != 0.0
    return stays


@apart
def lets_go(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> bool:
    """Whether a lane of joints and locks alone only lets go of some, and all rows that hold are in use: no velocity
    jumps, and what still holds is independent. A run that begins has no rows in use yet."""
    only = rows[first.lanes + FRESH, lane] == 0.0
    for event in range(sizes.events):
        action = plan.acts[event, ACTION]
        if action != RECORDS and action != RELEASES:
            only = only and not fired(sizes, first, rows, lane, event)
    for s in range(sizes.switches):
        if rows[first.state + layout.on_row(sizes) + s, lane] != OFF:
            mask = first.state + layout.mask_row(sizes) + plan.switches[s, SWITCH_FIRST]
            for row in range(mask, mask + plan.switches[s, SWITCH_ROWS]):
                only = only and rows[row, lane] != 0.0
    return only


@apart
def let_go(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> None:
    """No row of what is off is in use."""
    for s in range(sizes.switches):
        if rows[first.state + layout.on_row(sizes) + s, lane] == OFF:
            mask = first.state + layout.mask_row(sizes) + plan.switches[s, SWITCH_FIRST]
            for row in range(mask, mask + plan.switches[s, SWITCH_ROWS]):
                rows[row, lane] = 0.0
