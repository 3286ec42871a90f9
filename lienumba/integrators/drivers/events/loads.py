"""Loads on what is closed, or sticks: when one first passes what holds it, in a step in which nothing may move.

Where all rests no error of the motion keeps steps short, and a load may swing many times in one. The step is walked
along in parts, halved until in each the polynomial through five points says what a load is in four others; it passes 0
in one of these points, or about the top of a parabola through three of them.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.events.search import look_within, search_between
from lienumba.integrators.drivers.events.turns import climb, holds, least_of, may_turn
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue
from lienumba.integrators.drivers.lobatto import missed, point
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import CLEAR, OPENS, POINTS, STICK, UNTIL, Workspace
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import absolute, maximum, minimum

PLACES = 2 * (POINTS - 1)  # of a part, behind its begin: Lobatto's points, and those halfway between them
BEHIND = PLACES + 2  # the point in whose rows the last place but one of the part before is
FINEST = 2.0**-14  # of a step: what is not halved any more
WIDEST = 2.0**-6  # of a run: what is shorter may be hidden in a part that is as wide
LAST = 2.0**-30  # so near to the end a part goes on to it
LONGER = 1.2  # times the longest part in which loads were known, they may be unlike that
UNLIKE = 0.005  # of what a load differs by in a part, the polynomial through its points is wrong at most
TWICE = 2.0**-5  # of what it may be wrong by, in a part half as long
SLIGHTLY = 1e-3  # of how far a load is from what holds: what is less is no matter
MANY = 20.0  # times what a load is seen to differ by: what is not known yet differs by less
FARTHER = 5.0  # times what it is wrong by, a load may be larger than where it was looked at


@inlined
def _place(k: int) -> float:
    """A place of a part of length 1."""
    return point(k // 2) if k % 2 == 0 else 0.5 * (point(k // 2) + point(k // 2 + 1))


@inlined
def _value(sizes: Sizes, at: Workspace, n: int, k: int) -> Lanes:
    """The nth condition in a place of the part."""
    return load(at.conditions, layout.inside_row(sizes, k + 1) + n)


@apart
def _loaded(sizes: Sizes, at: Workspace, plan: Plan, n: int, length: Lanes) -> Lanes:
    """1 where a condition of a switch is a load on what is closed, or sticks, that may pass what that holds, or is not
    known in so long a step, else 0."""
    on, never = load(at.new, layout.on_row(sizes) + (n - sizes.events) // layout.CONDITIONS), splat(0.0) > 1.0
    loads = splat(1.0) if (n - sizes.events) % layout.CONDITIONS == OPENS else choose(on == STICK, splat(1.0), 0.0)
    after, longer = load(at.conditions, layout.conditions(sizes) + n), length > LONGER * load(at.lanes, CLEAR)
    may = choose((after > 0.0) | longer, splat(1.0), may_turn(sizes, at, n, length, never))
    return loads * may * holds(sizes, at, plan, n)


@apart
def loaded(sizes: Sizes, at: Workspace, plan: Plan, good: Mask, length: Lanes) -> Lanes:
    """1 where the open step has to be walked along."""
    count, some = layout.conditions(sizes), splat(0.0)
    asked = choose(length > LONGER * load(at.lanes, CLEAR), splat(1.0), 0.0)
    for n in range(sizes.events, count):
        asked = choose(load(at.conditions, 2 * count + n) < NEVER, splat(1.0), asked)
    for n in range(sizes.events, count if any_lane(good & (asked > 0.0)) else 0):
        some = maximum(some, choose(good & (asked > 0.0), _loaded(sizes, at, plan, n, length), 0.0))
    return some


@apart
def _sample(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, begin: Lanes, whole: Lanes, goes_on: Mask
) -> None:  # fmt: skip
    """All conditions in the places of the part; the lanes that go on begin where the one before has ended."""
    for n in range(sizes.events, layout.conditions(sizes)):
        row = layout.inside_row(sizes, 1) + n
        store(at.conditions, row, choose(goes_on, _value(sizes, at, n, PLACES), load(at.conditions, row)))
    for k in range(1, PLACES + 1):
        look_within(kernels, layout.EVENTS, at, t, length, begin + _place(k) * whole)
        for n in range(sizes.events, layout.conditions(sizes)):
            store(at.conditions, layout.inside_row(sizes, k + 1) + n, load(at.following, n))


@inlined
def _wrong(sizes: Sizes, at: Workspace, n: int) -> tuple[Lanes, Lanes, Lanes]:
    """By how much the polynomial through the nth condition in Lobatto's points is wrong between them; the least and the
    largest of all."""
    a, b, c = _value(sizes, at, n, 0), _value(sizes, at, n, 2), _value(sizes, at, n, 4)
    d, e = _value(sizes, at, n, 6), _value(sizes, at, n, 8)
    wrong, least, most = splat(0.0), a, a
    for k in range(POINTS - 1):
        miss, low, high = missed(_place(2 * k + 1), a, b, c, d, e, _value(sizes, at, n, 2 * k + 1))
        wrong, least, most = maximum(wrong, miss), minimum(least, low), maximum(most, high)
    return wrong, least, most


@inlined
def _bounds(
    x1: Lanes, x2: Lanes, x3: Lanes, f1: Lanes, f2: Lanes, f3: Lanes, wrong: Lanes
) -> tuple[Lanes, Lanes]:  # fmt: skip
    """How large what has these values may become between them: by the top of their parabola, -NEVER where it is
    elsewhere, and by the lines through two of them."""
    on, back = (f3 - f2) / (x3 - x2), (f2 - f1) / (x2 - x1)
    bend, slope = (on - back) / (x3 - x1), (back * (x3 - x2) + on * (x2 - x1)) / (x3 - x1)
    shift = -0.5 * slope / choose(bend < 0.0, bend, splat(-1.0))
    within = (bend < 0.0) & (shift > x1 - x2) & (shift < x3 - x2)
    lines = f2 + maximum(back * (x3 - x2), on * (x1 - x2))
    return choose(within, f2 + 0.5 * slope * shift + FARTHER * wrong, splat(-NEVER)), lines


@apart
def _seek(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    n: int, t: Lanes, length: Lanes, begin: Lanes, whole: Lanes, behind: Lanes, lanes: Mask,
) -> Lanes:  # fmt: skip
    """1 where the nth condition comes true in the part, and its time is known then; else 0. behind: how far from its
    begin the last place but one of the part before is, 0 without one: there may be a kink between."""
    least, wrong = least_of(sizes, at, n, splat(-1.0)), _wrong(sizes, at, n)[0]
    low, high, f_low, f_high, left = splat(0.0), splat(-1.0), splat(0.0), splat(0.0), lanes
    f1, f2 = load(at.conditions, layout.inside_row(sizes, BEHIND) + n), _value(sizes, at, n, 0)
    x1, x2 = -behind / whole, splat(0.0)
    for k in range(1, PLACES + 1):
        x3, f3 = splat(_place(k)), _value(sizes, at, n, k)
        top, lines = _bounds(x1, x2, x3, f1, f2, f3, wrong)
        may = left & (f2 <= least) & (f3 <= least) & (top > least)
        if k == 1:
            may = left & (f3 <= least) & (lines > least) & (behind > 0.0)
        if any_lane(may):
            place = climb(kernels, at, t, length, n, splat(1.0), least, may, begin, whole, x1, x2, x3, f1, f2, f3)
            there = may & (place > 0.0)
            low, f_low = choose(there, begin + x1 * whole, low), choose(there, f1, f_low)
            high, f_high = choose(there, place, high), choose(there, splat(1.0), f_high)
            left = left & (choose(there, 1.0, 0.0) == 0.0)
        there = left & (f3 > least)
        low, f_low = choose(there, begin + x2 * whole, low), choose(there, f2, f_low)
        high, f_high = choose(there, begin + x3 * whole, high), choose(there, f3, f_high)
        left = left & (choose(there, 1.0, 0.0) == 0.0)
        x1, x2, f1, f2 = x2, x3, f2, f3
    found = lanes & (high > 0.0)
    if any_lane(found):
        f_low = choose(f_low < 0.0, f_low, -f_high)
        search_between(kernels, sizes, at, first, rows, runs, queue, n, t, length, low, high, f_low, f_high, found)
    return choose(found, splat(1.0), 0.0)


@apart
def seek_loads(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, until: float, lanes: Mask, t: Lanes, length: Lanes,
) -> None:  # fmt: skip
    """The time at which something first lets go, slips or turns, in these lanes: before the one that was found at the
    end of the step, or where none was; until: when runs end (s)."""
    count, end = layout.conditions(sizes), splat(1.0)
    stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
    for n in range(sizes.events, count):
        store(at.conditions, layout.inside_row(sizes, PLACES + 1) + n, load(at.conditions, n))
        end = minimum(end, (load(at.conditions, 2 * count + n) - t) / length)
    begin, behind, goes_on, left = splat(0.0), splat(0.0), lanes, lanes & (end > 0.0)
    widest = WIDEST * until / length
    whole = minimum(end, widest)
    for _ in range(int(4.0 / FINEST)):
        if not any_lane(left):
            break
        _sample(kernels, sizes, at, t, length, begin, whole, goes_on)
        halves, odd, grows = splat(0.0), splat(0.0), splat(1.0)
        length_here, known = whole * length, load(at.lanes, CLEAR)
        for n in range(sizes.events, count):
            asked = left & (holds(sizes, at, plan, n) > 0.0)
            if any_lane(asked):
                wrong, least, most = _wrong(sizes, at, n)
                unlike = asked & (wrong > UNLIKE * (most - least)) & (wrong > SLIGHTLY * absolute(most))
                may_pass = most + maximum(FARTHER * wrong, most - least) > 0.0
                odd = choose(unlike, splat(1.0), odd)
                new = (length_here > known) & (most + MANY * (most - least) > 0.0)
                halves = choose(unlike & (may_pass | new), splat(1.0), halves)
                grows = choose(asked & (wrong > UNLIKE * TWICE * (most - least)), 0.0, grows)
        done = left & ((halves == 0.0) | (whole <= FINEST))
        known = choose(done & (odd == 0.0), maximum(known, length_here), known)
        store(at.lanes, CLEAR, choose(left & (halves > 0.0), minimum(known, 0.5 * length_here), known))
        found = splat(0.0)
        for n in range(sizes.events, count):
            asked = done & (holds(sizes, at, plan, n) > 0.0)
            if any_lane(asked):
                some = _seek(kernels, sizes, at, first, rows, runs, queue, n, t, length, begin, whole, behind, asked)
                found = maximum(found, some)
            row = layout.inside_row(sizes, BEHIND) + n
            store(at.conditions, row, choose(done, _value(sizes, at, n, PLACES - 1), load(at.conditions, row)))
        behind = choose(done, (1.0 - _place(PLACES - 1)) * whole, behind)
        begin = choose(done, choose(begin + whole > end - LAST, end, begin + whole), begin)
        wider = minimum(choose(grows > 0.0, 2.0 * whole, whole), widest)
        whole = choose(done, minimum(wider, end - begin), 0.5 * whole)
        left, goes_on = left & (found == 0.0) & (begin < end), done
    store(at.clock, layout.TIME, t)
