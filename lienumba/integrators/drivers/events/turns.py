"""Conditions that come and go within the open step: true for a moment though false at both of its ends, or false for a
moment though true at both; of events, and of what is closed, sticks, or slides in a joint.

Where the ends say that a condition may pass 0 between them, it is looked at in Lobatto's points; and between these
where its rate passes 0, or, where no rate is known, about the largest value.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.certificates import BEYOND
from lienumba.integrators.drivers.events.acting import follow, if_it_acts
from lienumba.integrators.drivers.events.search import SOUGHT, TOUCH, locate, look_within, search_between
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue
from lienumba.integrators.drivers.lobatto import point
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    ACTION,
    CHANGED,
    CLEAR,
    CUT,
    END_RATE,
    EXTENT,
    FRICTION,
    OFF,
    OPENS,
    POINTS,
    RATE,
    RECORDS,
    SEEKS,
    SIZE,
    SLIDE,
    SLIDES,
    STICK,
    STRODE,
    SWIFTEST,
    SWITCH_FIRST,
    SWITCH_KIND,
    UNILATERAL,
    UNTIL,
    Workspace,
)  # fmt: skip
from lienumba.integrators.reach import EVEN, by_changes, by_rates
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.truth import AT_ROOT, BAND
from lienumba.numerics.operations import absolute, maximum, minimum

TRIES = 48  # at parabolas and halves
SLIGHT = 1e-12  # of the largest normal force, of the largest speed so far, of a length: what is less is 0
FAINT = 1e-14  # in the unit of a condition: of what is locked at 0 all is rounding


@inlined
def _place(k: int, last: int) -> float:
    """A point of the open step, whose end is the `last` one: Lobatto's of each panel."""
    points = POINTS - 1
    return (float(k // points) + point(k % points)) * float(points) / float(last)


@inlined
def _value(sizes: Sizes, at: Workspace, n: int, k: int, last: int) -> Lanes:
    """The nth condition there."""
    if k == 0:
        return load(at.conditions, n)
    if k == last:
        return load(at.conditions, layout.conditions(sizes) + n)
    return load(at.conditions, layout.inside_row(sizes, k) + n)


@inlined
def rate_of(sizes: Sizes, at: Workspace, n: int, k: int, last: int) -> Lanes:
    """Its rate there (1/s), NaN where it is not known: of switches it is that of open gaps."""
    if n >= sizes.events:
        if (n - sizes.events) % layout.CONDITIONS != OPENS:
            return splat(np.nan)
        switch = (n - sizes.events) // layout.CONDITIONS
        rate = -_value(sizes, at, n + SLIDES - OPENS, k, last) / length_of(sizes, at, n)
        return choose(load(at.state, layout.on_row(sizes) + switch) == OFF, rate, splat(np.nan))
    if k == 0 or k == last:
        which = RATE if k == 0 else END_RATE
        return load(at.conditions, layout.peak_row(sizes) + which * sizes.events + n)
    return load(at.conditions, layout.inside_row(sizes, k) + layout.conditions(sizes) + n)


@inlined
def length_of(sizes: Sizes, at: Workspace, n: int) -> Lanes:
    """With which the gaps of a switch are compared (m or rad)."""
    switch = (n - sizes.events) // layout.CONDITIONS
    row = layout.border_numbers(sizes) + layout.CONTACT_NUMBERS * switch + SIZE
    return load(at.change, row)


@inlined
def least_of(sizes: Sizes, at: Workspace, n: int, before: Lanes) -> Lanes:
    """By how much a condition has to be on the other side of 0: see `truth`, and `certificates`."""
    if n >= sizes.events:
        switch = (n - sizes.events) // layout.CONDITIONS
        on = load(at.state, layout.on_row(sizes) + switch)
        least = BEYOND * load(at.change, layout.change_forces(sizes) + switch)
        if (n - sizes.events) % layout.CONDITIONS == SLIDES:
            least = choose(on == SLIDE, SLIGHT * load(at.change, layout.change_speeds(sizes) + switch), least)
        return choose(on == OFF, splat(TOUCH), least)
    extent = load(at.conditions, layout.peak_row(sizes) + EXTENT * sizes.events + n)
    return maximum(extent * choose(before > 0.0, splat(BAND), splat(AT_ROOT)), splat(FAINT))


@apart
def keep_rates(sizes: Sizes, at: Workspace, new: int) -> None:
    """The rates at the end of the step, which the kernel `events` has written behind the address `new`."""
    for n in range(sizes.events):
        row = layout.peak_row(sizes) + END_RATE * sizes.events + n
        store(at.conditions, row, load(new, layout.rate_row(sizes) + n))


@apart
def doubt_rates(sizes: Sizes, at: Workspace, new: int, jumps: Mask) -> None:
    """Where the step ends on a discontinuity at which a rate jumps, it is not known: not on which side of it."""
    for n in range(sizes.events):
        peaks, rate = at.conditions + ROW * (layout.peak_row(sizes) + n), layout.rate_row(sizes) + n
        leap = absolute(load(at.following, rate) - load(new, rate)) > BEYOND * load(peaks, SWIFTEST * sizes.events)
        end = load(peaks, END_RATE * sizes.events)
        store(peaks, END_RATE * sizes.events, choose(jumps & leap, splat(np.nan), end))


@inlined
def rises_here(sizes: Sizes, at: Workspace, n: int) -> Mask:
    """Whether a condition passes 0 at the end of the step, but for rounding."""
    peaks = at.conditions + ROW * (layout.peak_row(sizes) + n)
    band = AT_ROOT * load(peaks, EXTENT * sizes.events)
    before, after = load(at.conditions, n), load(at.conditions, layout.conditions(sizes) + n)
    return (before < -band) & (after > -band) & (load(peaks, END_RATE * sizes.events) > 0.0)


@apart
def go_on(sizes: Sizes, at: Workspace, new: int, going: Mask) -> None:
    """The conditions at the end of the step are those at the start of the next one in the lanes `going`."""
    for n in range(layout.conditions(sizes)):
        row, rise = layout.rise_row(sizes) + n, load(new, n) - load(at.conditions, n)
        store(at.conditions, row, choose(going, rise, load(at.conditions, row)))
    store(at.lanes, CLEAR, choose(load(at.lanes, CHANGED) != 0.0, 0.0, load(at.lanes, CLEAR)))
    store(at.lanes, STRODE, choose(going, load(at.clock, layout.LENGTH), load(at.lanes, STRODE)))
    rates = layout.peak_row(sizes) + END_RATE * sizes.events
    follow(sizes, at, new, at.conditions + ROW * rates, going)
    stages.commit(going, at.conditions, new, layout.conditions(sizes))


@apart
def may_turn(sizes: Sizes, at: Workspace, n: int, length: Lanes, cut: Mask) -> Lanes:
    """1 where a condition that is on the same side of 0 at both ends may be on the other between them, or is
    `cut`, else 0. It turns nowhere where its rates at both are about the mean one (see `step_ends.Ends`)."""
    before, after = _value(sizes, at, n, 0, 1), _value(sizes, at, n, 1, 1)
    side = choose(before > 0.0, splat(-1.0), splat(1.0))
    begin, end = side * before, side * after
    p, q = side * length * rate_of(sizes, at, n, 0, 1), side * length * rate_of(sizes, at, n, 1, 1)
    known = (p == p) & (q == q)
    p, q, mean = choose(known, p, 0.0), choose(known, q, 0.0), end - begin
    low, high = minimum(p, q), maximum(p, q)
    few, many = minimum(mean / EVEN, mean * EVEN), maximum(mean / EVEN, mean * EVEN)
    last = load(at.conditions, layout.rise_row(sizes) + n) * maximum(length / load(at.lanes, STRODE), splat(1.0))
    reach = choose(known, by_rates(low, high, mean), by_changes(mean, last))
    reach = choose(known & (low >= few) & (high <= many), splat(0.0), reach)
    stays = choose(before > 0.0, choose(after > 0.0, 1.0, splat(0.0)), choose(after <= 0.0, 1.0, splat(0.0)))
    return choose(cut | (maximum(begin, end) + reach > least_of(sizes, at, n, before)), stays, 0.0)


@apart
def holds(sizes: Sizes, at: Workspace, plan: Plan, n: int) -> Lanes:
    """1 where a condition of a switch says that what is closed, or sticks, can do so, or that what slides in a joint
    goes on as it does, else 0."""
    switch, which = (n - sizes.events) // layout.CONDITIONS, (n - sizes.events) % layout.CONDITIONS
    kind, on = plan.switches[switch, SWITCH_KIND], load(at.new, layout.on_row(sizes) + switch)
    used = load(at.new, layout.mask_row(sizes) + plan.switches[switch, SWITCH_FIRST])
    asked = splat(0.0)
    if kind == UNILATERAL:
        asked = choose(on == STICK, 1.0, choose(on == SLIDE, 1.0 if which == OPENS else 0.0, splat(0.0)))
    if kind == FRICTION and which == SLIDES:
        asked = choose((on == SLIDE) | ((on == STICK) & (used != 0.0)), splat(1.0), 0.0)
    return choose(load(at.conditions, n) <= 0.0, asked, 0.0)


@apart
def climb(
    kernels: np.ndarray, at: Workspace, t: Lanes, length: Lanes, n: int, side: Lanes, least: Lanes, lanes: Mask,
    begin: Lanes, whole: Lanes, x1: Lanes, x2: Lanes, x3: Lanes, f1: Lanes, f2: Lanes, f3: Lanes,
) -> Lanes:  # fmt: skip
    """The fraction of the step at which a condition is on the other side of 0, about the largest of its values, on this
    side, in three places of a panel, of which the middle one is yet to be looked at where its value is -NEVER; -1 where
    it is not found there. By parabolas, and by halves, since there may be a kink, as long as the lines through three
    values lead there. begin, whole: of the step, where the panel begins, and how long it is."""
    found, left = splat(-1.0), lanes
    for k in range(TRIES):
        new = f2 == -NEVER
        on, back = (f2 - f1) / (x2 - x1) * (x3 - x2), (f2 - f3) / (x3 - x2) * (x2 - x1)
        left = left & (new | (f2 + maximum(on, back) > least))
        if not any_lane(left):
            break
        bend = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        vertex, halved = x2 + shift / choose(bend > 0.0, bend, 1.0), 0.5 * (x2 + choose(x3 - x2 > x2 - x1, x3, x1))
        x = choose((bend > 0.0) & (vertex > x1) & (vertex < x3) & (vertex != x2), vertex, halved)
        if k % 3 == 2:
            x = halved
        x = choose(left & (choose(new, 1.0, 0.0) == 0.0), x, x2)
        look_within(kernels, layout.EVENTS, at, t, length, begin + x * whole)
        f = side * load(at.following, n)
        there = left & (f > least)
        found, left = choose(there, begin + x * whole, found), left & (choose(there, 1.0, 0.0) == 0.0)
        at_start, at_end = new & (f < f1) & (f1 >= f3), new & (f < f3) & (f3 > f1)  # nearer to an end, if anywhere
        beyond = f + choose(at_start, (f - f3) / (x3 - x) * (x - x1), (f - f1) / (x - x1) * (x3 - x))
        left = left & (choose(at_start | at_end, choose(beyond > least, 0.0, splat(1.0)), 0.0) == 0.0)
        new = new & (choose(at_start | at_end, 1.0, 0.0) == 0.0)
        x3, f3, x1, f1 = choose(at_start, x, x3), choose(at_start, f, f3), choose(at_end, x, x1), choose(at_end, f, f1)
        x2 = choose(at_start | at_end, 0.5 * (x1 + x3), x2)
        known = choose(new | at_start | at_end, 1.0, 0.0) == 0.0
        less, more = known & (f <= f2), known & (f > f2)
        first, last = less & (x < x2), less & (x > x2)  # of what is about the largest value x is an end now, or x2
        former, latter = more & (x > x2), more & (x < x2)
        x1, f1 = choose(first, x, choose(former, x2, x1)), choose(first, f, choose(former, f2, f1))
        x3, f3 = choose(last, x, choose(latter, x2, x3)), choose(last, f, choose(latter, f2, f3))
        x2, f2 = choose(new | more, x, x2), choose(new | more, f, f2)
    return found


@inlined
def _largest(a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes, Lanes]:
    """Three of Lobatto's points about the largest of the values there, and these; beside an end the one in the middle
    is yet to be looked at."""
    ends = choose(e > a, splat(1.0), 0.0) != 0.0
    x1, x3 = choose(ends, point(3), splat(0.0)), choose(ends, splat(1.0), point(1))
    f1, f3, f2 = choose(ends, d, a), choose(ends, e, b), splat(-NEVER)
    x2, most = 0.5 * (x1 + x3), maximum(a, e)
    for k in range(1, POINTS - 1):
        here, before, behind = b, a, c
        if k == 2:
            here, before, behind = c, b, d
        elif k == 3:
            here, before, behind = d, c, e
        top = here > most
        x1, f1, x2 = choose(top, point(k - 1), x1), choose(top, before, f1), choose(top, point(k), x2)
        f2, x3, f3 = choose(top, here, f2), choose(top, point(k + 1), x3), choose(top, behind, f3)
        most = maximum(most, here)
    return x1, x2, x3, f1, f2, f3


@apart
def _look_inside(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, whole: Lanes, last: int
) -> None:
    """All conditions in the points of the step, or of the part `whole` of it, and at the end of that."""
    count = layout.conditions(sizes)
    for k in range(1, last + 1 if any_lane(whole < 1.0) else last):
        look_within(kernels, layout.EVENTS, at, t, length, _place(k, last) * whole)
        row = layout.inside_row(sizes, k)
        for n in range(count):
            store(at.conditions, row + n, load(at.following, n))
        for n in range(sizes.events):
            store(at.conditions, row + count + n, load(at.following, layout.rate_row(sizes) + n))


@apart
def _seek_turn(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    plan: Plan, n: int, t: Lanes, length: Lanes, whole: Lanes, last: int, may: Mask,
) -> None:  # fmt: skip
    """When the nth condition comes true in the open step though it is on the same side of 0 at both ends, in the lanes
    in which it may; whole: of the step, behind which something is hit; last: of the points in which it is known."""
    times, before, after = at.conditions + ROW * 2 * layout.conditions(sizes), load(at.conditions, n), splat(0.0)
    inside, hits = layout.inside_row(sizes, last) + n, whole < 1.0
    side = choose(before > 0.0, splat(-1.0), splat(1.0))
    least, rate, nowhere = least_of(sizes, at, n, before), layout.rate_row(sizes) + n, splat(0.0) > 1.0
    low, high, f_low, f_high, left = splat(0.0), splat(-1.0), side * before, side * before, may
    begin, f, r = splat(0.0), side * before, side * rate_of(sizes, at, n, 0, last)
    panel = float(POINTS - 1) / float(last)
    for k in range(1, last + 1):
        x, after, s = _place(k, last) * whole, _value(sizes, at, n, k, last), rate_of(sizes, at, n, k, last)
        g, s = side * after, side * s
        if k == last:
            g = choose(hits, side * load(at.conditions, inside), g)
            if n < sizes.events:
                s = choose(hits, side * load(at.conditions, inside + layout.conditions(sizes)), s)
        place, top = x, g
        turns = left & (r > 0.0) & (s < 0.0) & (f <= least) & (g <= least)
        if any_lane(turns):
            store(at.lanes, SEEKS, splat(float(rate)))
            place = locate(kernels, layout.EVENTS, at, first, rows, t, length, begin, x, -r, -s, turns, nowhere, -side)
            look_within(kernels, layout.EVENTS, at, t, length, place)
            place, top = choose(turns, place, x), choose(turns, side * load(at.following, n), g)
        there = left & (top > least)
        low, f_low = choose(there, begin, low), choose(there, f, f_low)
        high, f_high = choose(there, place, high), choose(there, top, f_high)
        left = left & (choose(there, 1.0, 0.0) == 0.0)
        begin, f, r = x, g, s
        blind, m = left & (choose(r == r, 1.0, 0.0) == 0.0) & (whole == 1.0), k - POINTS + 1
        if k % (POINTS - 1) == 0 and any_lane(blind):
            a, b = side * _value(sizes, at, n, m, last), side * _value(sizes, at, n, m + 1, last)
            c, d = side * _value(sizes, at, n, m + 2, last), side * _value(sizes, at, n, m + 3, last)
            start = splat(_place(m, last))
            x1, x2, x3, f1, f2, f3 = _largest(a, b, c, d, g)
            place = climb(kernels, at, t, length, n, side, least, blind, start, splat(panel), x1, x2, x3, f1, f2, f3)
            there = blind & (place > 0.0)
            low, f_low = choose(there, start, low), choose(there, a, f_low)
            high, f_high = choose(there, place, high), choose(there, maximum(f_high, least), f_high)
            left = left & (choose(there, 1.0, 0.0) == 0.0)
    found = may & (high > 0.0)
    if not any_lane(found):
        return
    store(times, n, choose(found, splat(SOUGHT), load(times, n)))
    if n < sizes.events and plan.acts[n, ACTION] != RECORDS:
        if_it_acts(sizes, first, rows, runs, queue, plan, n)
    begin, x = choose(side > 0.0, low, high), choose(side > 0.0, high, 1.0)
    begins, ends = choose(side > 0.0, f_low, -f_high), choose(side > 0.0, f_high, after)
    begins = choose(begins < 0.0, begins, -ends)
    found = found & (load(times, n) == SOUGHT)
    search_between(kernels, sizes, at, first, rows, runs, queue, n, t, length, begin, x, begins, ends, found)


@apart
def before_hits(sizes: Sizes, at: Workspace, plan: Plan, t: Lanes, length: Lanes) -> Lanes:
    """The fraction of the open step at which something hits a stop or a contact, or leaves it, else 1."""
    times, hit = at.conditions + ROW * 2 * layout.conditions(sizes), splat(NEVER)
    for n in range(sizes.events, layout.conditions(sizes)):
        switch = (n - sizes.events) // layout.CONDITIONS
        if plan.switches[switch, SWITCH_KIND] == UNILATERAL:
            hit = minimum(hit, choose(load(times, n) < load(at.lanes, UNTIL), load(times, n), NEVER))
    return choose(hit < NEVER, (hit - t) / length, 1.0)


@apart
def seek_turns(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, good: Mask, walked: Lanes, t: Lanes, length: Lanes,
) -> None:  # fmt: skip
    """Where conditions come true within the open step, though they are on the same side of 0 at both ends. Where
    something hits a stop or a contact, what is behind that is no motion: points are taken before it. walked: 1 where
    those of switches are known."""
    count, until, seen, never = layout.conditions(sizes), load(at.lanes, UNTIL), False, splat(0.0) > 1.0
    times, whole = at.conditions + ROW * 2 * count, before_hits(sizes, at, plan, t, length)
    cut = good & ((whole < 1.0) | (until == load(at.lanes, CUT)))
    last = layout.INTERVALS if kernels[layout.EXPAND] != 0 else POINTS - 1
    for n in range(count):
        may = may_turn(sizes, at, n, length, cut if n < sizes.events else never) > 0.0
        may = may & good & (load(times, n) == NEVER)
        if n >= sizes.events and any_lane(may):
            may = may & (walked == 0.0) & (holds(sizes, at, plan, n) > 0.0)
        if any_lane(may):
            if not seen:
                stages.extend(kernels, sizes, nodes, at, t, length, until)
                _look_inside(kernels, sizes, at, t, length, whole, last)
                seen = True
            _seek_turn(kernels, sizes, at, first, rows, runs, queue, plan, n, t, length, whole, last, may)
