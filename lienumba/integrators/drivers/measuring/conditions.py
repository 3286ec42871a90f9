"""What is kept of the parts of a piece of a panel in which a condition holds.

Where a condition becomes true or false between two points, its place is found as those of events are, and what it holds
for is looked at by itself. Where it is undefined, so is what is kept, unless it is known without that.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.search import finest_part
from lienumba.integrators.drivers.lobatto import fraction_of
from lienumba.integrators.drivers.measuring.keeping import keep_over
from lienumba.integrators.drivers.measuring.points import (
    look,
    look_along,
    may_turn,
    passing,
    signals,
    truth,
    turn,
    value_of,
)
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    COUNTS,
    ELSEWHERE,
    KEEPS_FIRST,
    KEEPS_LAST,
    KEPT_CONDITION,
    KEPT_KIND,
    KEPT_SIZE,
    KEPT_TIME,
    KEPT_TRUE,
    KEPT_UNDEFINED,
    KEPT_VALUE,
    POINTS,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.truth import settled
from lienumba.numerics.operations import HOLDS, maximum

PART = 2  # behind the panel and its piece


@inlined
def _lose(kept: Address, kind: int, after: Lanes, unknown: Mask) -> None:
    """Where a condition is undefined, so is what is kept, unless the first time has been, or the last one is yet to
    come."""
    time = load(kept, KEPT_TIME)
    lost = unknown
    if kind == KEEPS_FIRST:
        lost = unknown & (time != time)
    elif kind == KEEPS_LAST:
        lost = unknown & (choose(after > 0.0, 1.0, 0.0) == 0.0)
    store(kept, KEPT_UNDEFINED, choose(lost, splat(1.0), load(kept, KEPT_UNDEFINED)))


@apart
def _settle(sizes: Sizes, at: Workspace, condition: int, kept: Address, piece: int, lanes: Mask, comes: Lanes) -> None:
    """What a condition is in the points of a piece becomes what it counts as there."""
    true, size = load(kept, KEPT_TRUE), load(kept, KEPT_SIZE)
    for k in range(POINTS):
        there, now = signals(sizes, at, piece, k), value_of(sizes, at, piece, condition, k)
        counts = settled(now, true, size)
        if k == POINTS - 1:
            counts = choose((comes != 0.0) & (counts <= 0.0), splat(HOLDS), counts)
        store(there, condition, choose(lanes, counts, now))
        true = choose(counts > 0.0, splat(1.0), 0.0)


@apart
def _keep_between(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, before: Lanes, after: Lanes, lanes: Mask,
) -> None:  # fmt: skip
    """The same between two fractions of the step, at which the condition is so much, and turns once at most. Where it
    is held from, and where it is held to, it holds."""
    condition, kept = plan.kept[n, KEPT_CONDITION], at.measures + ROW * layout.KEPT_ROWS * n
    begins = lanes & (before <= 0.0) & (after > 0.0)
    ends = lanes & (before > 0.0) & (after <= 0.0)
    if any_lane(begins | ends):
        turns = begins | ends
        place = passing(kernels, at, first, rows, t, length, low, high, condition, before, after, turns)
        low, high = choose(begins, place, low), choose(ends, maximum(place - finest_part(t, length), low), high)
        if plan.kept[n, KEPT_KIND] == COUNTS:
            known = load(kept, KEPT_VALUE)
            store(kept, KEPT_VALUE, choose(begins, known + 1.0, known))
    holds = lanes & ((before > 0.0) | (after > 0.0))
    if plan.kept[n, KEPT_KIND] != COUNTS and any_lane(holds):
        look_along(kernels, sizes, at, t, length, low, high, PART)
        keep_over(kernels, sizes, at, plan, n, t, length, low, high, PART, holds)
    unknown = lanes & (choose(before == before, choose(after == after, splat(0.0), 1.0), 1.0) == 1.0)
    if any_lane(unknown):
        _lose(kept, plan.kept[n, KEPT_KIND], after, unknown)


@apart
def _keep_parts(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, piece: int, lanes: Mask,
) -> None:  # fmt: skip
    """The same in the lanes in which a condition begins or ends to hold within the piece."""
    condition, size = plan.kept[n, KEPT_CONDITION], load(at.measures + ROW * layout.KEPT_ROWS * n, KEPT_SIZE)
    for k in range(POINTS - 1):
        before, after = value_of(sizes, at, piece, condition, k), value_of(sizes, at, piece, condition, k + 1)
        begin, end = fraction_of(k, low, high), fraction_of(k + 1, low, high)
        place = turn(sizes, at, piece, condition, k)
        turns = lanes & (place > 0.0)
        if any_lane(turns):
            middle, to = choose(turns, low + place * (high - low), end), signals(sizes, at, 0, ELSEWHERE)
            look(kernels, sizes, at, t, length, middle, to)
            there = choose(turns, settled(load(to, condition), before, size), after)
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, begin, middle, before, there, lanes)
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, middle, end, there, after, turns)
        else:
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, begin, end, before, after, lanes)


@apart
def keep_within(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, piece: int, lanes: Mask, comes: Lanes,
) -> None:  # fmt: skip
    """What a piece of a panel (or, as the piece 0, all of it) changes in these lanes that was looked at in all of its
    points; comes: where the condition is true at its end, whatever it seems."""
    condition, kept = plan.kept[n, KEPT_CONDITION], at.measures + ROW * layout.KEPT_ROWS * n
    if condition < 0:
        keep_over(kernels, sizes, at, plan, n, t, length, low, high, piece, lanes)
        return
    _settle(sizes, at, condition, kept, piece, lanes, comes)
    held, turns, sum_ = splat(0.0), splat(-1.0), splat(0.0)
    for k in range(POINTS):
        held = held + truth(sizes, at, piece, condition, k)
        sum_ = sum_ + value_of(sizes, at, piece, condition, k)
    if any_lane(lanes & may_turn(sizes, at, piece, condition)):
        for k in range(POINTS - 1):
            turns = maximum(turns, turn(sizes, at, piece, condition, k))
    if plan.kept[n, KEPT_KIND] == COUNTS:
        news = lanes & (truth(sizes, at, piece, condition, 0) > load(kept, KEPT_TRUE))
        store(kept, KEPT_VALUE, choose(news, load(kept, KEPT_VALUE) + 1.0, load(kept, KEPT_VALUE)))
    store(kept, KEPT_TRUE, choose(lanes, truth(sizes, at, piece, condition, POINTS - 1), load(kept, KEPT_TRUE)))
    always = lanes & (turns <= 0.0) & (held == float(POINTS))
    partly = lanes & ((turns > 0.0) | ((held > 0.0) & (held < float(POINTS))) | (sum_ != sum_))
    if any_lane(always):
        keep_over(kernels, sizes, at, plan, n, t, length, low, high, piece, always)
    if any_lane(partly):
        _keep_parts(kernels, sizes, at, first, rows, plan, n, t, length, low, high, piece, partly)
