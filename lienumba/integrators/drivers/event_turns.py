"""Conditions of events that come and go within the open step: true for a moment though false at both of its ends, or
false for a moment though true at both.

Where the ends say that a condition may pass 0 between them, it is looked at in Lobatto's points; and between these
where its rate passes 0, or, where no rate is known, where the polynomial through the points has its extreme.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.acting import follow, if_it_acts
from lienumba.integrators.drivers.event_search import SOUGHT, locate, look_within, search_between
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Plan, Queue
from lienumba.integrators.drivers.lobatto import point, risen, through
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    ACTION,
    CUT,
    END_RATE,
    EXTENT,
    POINTS,
    RATE,
    RECORDS,
    RISE,
    SEEKS,
    SWITCH_KIND,
    UNILATERAL,
    UNTIL,
    Workspace,
)  # fmt: skip
from lienumba.integrators.reach import EVEN, by_changes, by_rates
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.truth import AT_ROOT, BAND
from lienumba.numerics.operations import maximum, minimum

GRID = 32  # places in which a polynomial is looked at
UNSURE = 0.1  # of what its values differ by, a polynomial may be wrong
AROUND = 0.0625  # of the step: so far from there two more values are taken
TRIES = 8  # at parabolas


@inlined
def _known(sizes: Sizes, at: Workspace, what: int, n: int) -> Lanes:
    """Of the condition of the nth event; see `layout.peak_row`."""
    return load(at.conditions, layout.peak_row(sizes) + what * sizes.events + n)


@inlined
def _least(sizes: Sizes, at: Workspace, n: int, before: Lanes) -> Lanes:
    """By how much a condition has to be on the other side of 0: see `truth`."""
    return _known(sizes, at, EXTENT, n) * choose(before > 0.0, splat(BAND), splat(AT_ROOT))


@apart
def keep_rates(sizes: Sizes, at: Workspace, new: int) -> None:
    """The rates at the end of the step, which the kernel `events` has written behind the address `new`."""
    for n in range(sizes.events):
        row = layout.peak_row(sizes) + END_RATE * sizes.events + n
        store(at.conditions, row, load(new, layout.rate_row(sizes) + n))


@apart
def go_on(sizes: Sizes, at: Workspace, new: int, going: Mask) -> None:
    """The conditions of events at the end of the step are those at the start of the next one in the lanes `going`."""
    peaks = layout.peak_row(sizes)
    for n in range(sizes.events):
        row, rise = peaks + RISE * sizes.events + n, load(new, n) - load(at.conditions, n)
        store(at.conditions, row, choose(going, rise, load(at.conditions, row)))
    follow(sizes, at, new, at.conditions + ROW * (peaks + END_RATE * sizes.events), going)


@apart
def _may(sizes: Sizes, at: Workspace, n: int, length: Lanes, before: Lanes, after: Lanes, cut: Mask) -> Lanes:
    """1 where a condition that is on the same side of 0 at both ends may be on the other between them, or is
    `cut`, else 0. It turns nowhere where its rates at both are about the mean one (see `step_ends.Ends`)."""
    side = choose(before > 0.0, splat(-1.0), splat(1.0))
    begin, end = side * before, side * after
    p, q = side * length * _known(sizes, at, RATE, n), side * length * _known(sizes, at, END_RATE, n)
    known = (p == p) & (q == q)
    p, q, mean = choose(known, p, 0.0), choose(known, q, 0.0), end - begin
    low, high = minimum(p, q), maximum(p, q)
    few, many = minimum(mean / EVEN, mean * EVEN), maximum(mean / EVEN, mean * EVEN)
    reach = choose(known, by_rates(low, high, mean), by_changes(mean, _known(sizes, at, RISE, n)))
    reach = choose(known & (low >= few) & (high <= many), splat(0.0), reach)
    stays = choose(before > 0.0, choose(after > 0.0, 1.0, splat(0.0)), choose(after <= 0.0, 1.0, splat(0.0)))
    return choose(cut | (maximum(begin, end) + reach > _least(sizes, at, n, before)), stays, 0.0)


@apart
def _peak(
    kernels: np.ndarray, at: Workspace, t: Lanes, length: Lanes, n: int, side: Lanes, least: Lanes, lanes: Mask,
    a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes,
) -> Lanes:  # fmt: skip
    """The fraction of the step at which a condition is on the other side of 0, near where the polynomial through its
    values in all points, on this side, comes nearest to it; -1 where it is not found there."""
    o, p, q, r = through(a, b, c, d, e)
    most, s = splat(-NEVER), splat(0.0)
    for k in range(1, GRID):
        x = splat(2.0 * k / GRID - 1.0)
        y = c + risen(x, o, p, q, r)
        s, most = choose(y > most, x, s), choose(y > most, y, most)
    spread = maximum(maximum(maximum(a, b), maximum(c, d)), e) - minimum(minimum(minimum(a, b), minimum(c, d)), e)
    left, found = lanes & (most + UNSURE * spread > least), splat(-1.0)
    x2 = 0.5 * (s + 1.0)
    x1, x3 = maximum(x2 - AROUND, splat(0.0)), minimum(x2 + AROUND, splat(1.0))
    f1, f2, f3 = splat(0.0), splat(0.0), splat(0.0)
    for k in range(3 + TRIES):
        if not any_lane(left):
            break
        bend = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        top = x2 + shift / choose(bend > 0.0, bend, 1.0)
        x = x1 if k == 0 else x2 if k == 1 else x3 if k == 2 else top
        if k > 2:
            left = left & (bend > 0.0) & (x > x1) & (x < x3) & (x != x2)
            x = choose(left, x, x2)
        look_within(kernels, layout.EVENTS, at, t, length, x)
        f = side * load(at.following, n)
        there = left & (f > least)
        found, left = choose(there, x, found), left & (choose(there, 1.0, 0.0) == 0.0)
        if k == 0:
            f1 = f
        elif k == 1:
            f2 = f
        elif k == 2:
            f3 = f
        else:  # the three about the largest one
            later, more = x > x2, f > f2
            x1 = choose(more & later, x2, choose(more | later, x1, x))
            f1 = choose(more & later, f2, choose(more | later, f1, f))
            x3 = choose(more & (x < x2), x2, choose(more | (x < x2), x3, x))
            f3 = choose(more & (x < x2), f2, choose(more | (x < x2), f3, f))
            x2, f2 = choose(more, x, x2), choose(more, f, f2)
    return found


@apart
def _seek_turn(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    plan: Plan, n: int, t: Lanes, length: Lanes, whole: Lanes, may: Mask,
) -> None:  # fmt: skip
    """When the condition of the nth event comes true in the open step though it is on the same side of 0 at both ends,
    in the lanes in which it may; whole: of the step, behind which something is hit."""
    count, rate, nowhere = layout.conditions(sizes), layout.rate_row(sizes) + n, splat(0.0) > 1.0
    times, before, after = at.conditions + ROW * 2 * count, load(at.conditions, n), load(at.conditions, count + n)
    side = choose(before > 0.0, splat(-1.0), splat(1.0))
    least = _least(sizes, at, n, before)
    a, r, low, high = side * before, side * _known(sizes, at, RATE, n), splat(0.0), splat(-1.0)
    b, c, d, e, f_low, f_high, last, f, left = a, a, a, a, a, a, splat(0.0), a, may
    for k in range(1, POINTS):
        x, g, s = splat(1.0), side * after, side * _known(sizes, at, END_RATE, n)
        if k < POINTS - 1:
            x = point(k) * whole
            look_within(kernels, layout.EVENTS, at, t, length, x)
            g, s = side * load(at.following, n), side * load(at.following, rate)
        place, top = x, g
        turns = left & (r > 0.0) & (s < 0.0) & (f <= least) & (g <= least)
        if any_lane(turns):
            store(at.lanes, SEEKS, splat(float(rate)))
            place = locate(kernels, layout.EVENTS, at, first, rows, t, length, last, x, -r, -s, turns, nowhere, -side)
            look_within(kernels, layout.EVENTS, at, t, length, place)
            place, top = choose(turns, place, x), choose(turns, side * load(at.following, n), g)
        there = left & (top > least)
        low, f_low = choose(there, last, low), choose(there, f, f_low)
        high, f_high = choose(there, place, high), choose(there, top, f_high)
        left = left & (choose(there, 1.0, 0.0) == 0.0)
        if k == 1:
            b = g
        elif k == 2:
            c = g
        elif k == 3:
            d = g
        last, f, r, e = x, g, s, g
    blind = left & (choose(r == r, 1.0, 0.0) == 0.0) & (whole == 1.0)
    if any_lane(blind):
        place = _peak(kernels, at, t, length, n, side, least, blind, a, b, c, d, e)
        there = blind & (place > 0.0)
        high, f_high = choose(there, place, high), choose(there, maximum(f_high, least), f_high)
    found = may & (high > 0.0)
    if not any_lane(found):
        return
    store(times, n, choose(found, splat(SOUGHT), load(times, n)))
    if plan.acts[n, ACTION] != RECORDS:
        if_it_acts(sizes, first, rows, runs, queue, plan, n)
    begin, end = choose(side > 0.0, low, high), choose(side > 0.0, high, 1.0)
    begins, ends = choose(side > 0.0, f_low, -f_high), choose(side > 0.0, f_high, after)
    begins = choose(begins < 0.0, begins, -ends)
    found = found & (load(times, n) == SOUGHT)
    search_between(kernels, sizes, at, first, rows, runs, queue, n, t, length, begin, end, begins, ends, found)


@apart
def seek_turns(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, good: Mask, t: Lanes, length: Lanes,
) -> None:  # fmt: skip
    """Where conditions of events come true within the open step, though they are on the same side of 0 at both ends.
    Where something hits a stop or a contact, what is behind that is no motion: points are taken before it."""
    count, until, extended = layout.conditions(sizes), load(at.lanes, UNTIL), False
    times, hit = at.conditions + ROW * 2 * count, splat(NEVER)
    for n in range(sizes.events, count):
        if plan.switches[(n - sizes.events) // layout.CONDITIONS, SWITCH_KIND] == UNILATERAL:
            hit = minimum(hit, choose(load(times, n) < until, load(times, n), NEVER))
    cut = good & (hit < NEVER)
    whole = choose(cut, (hit - t) / length, 1.0)
    cut = cut | (good & (until == load(at.lanes, CUT)))
    for n in range(sizes.events):
        before, after = load(at.conditions, n), load(at.conditions, count + n)
        may = good & (load(times, n) == NEVER) & (_may(sizes, at, n, length, before, after, cut) > 0.0)
        if any_lane(may):
            if not extended:
                stages.extend(kernels, sizes, nodes, at, t, length, until)
                extended = True
            _seek_turn(kernels, sizes, at, first, rows, runs, queue, plan, n, t, length, whole, may)
