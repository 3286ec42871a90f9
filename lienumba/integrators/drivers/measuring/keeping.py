"""What is kept of a step, or of the parts of it in which a condition holds.

Where a condition becomes true or false between two points, its place is found as those of events are, and what it holds
for is looked at by itself. Where it is undefined, so is what is kept, unless it is known without that.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.event_search import finest_part, locate
from lienumba.integrators.drivers.lane_queue import Plan
from lienumba.integrators.drivers.measuring.extremes import keep_extreme
from lienumba.integrators.drivers.measuring.integrals import gain, mean_over
from lienumba.integrators.drivers.measuring.points import (
    fraction_of,
    look,
    look_along,
    signals,
    time_of,
    turn,
    value_of,
)
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    COUNTS,
    ELSEWHERE,
    INTEGRATES,
    KEEPS_FIRST,
    KEEPS_LAST,
    KEPT_CONDITION,
    KEPT_KIND,
    KEPT_SIGNAL,
    KEPT_TIME,
    KEPT_UNDEFINED,
    KEPT_VALUE,
    POINTS,
    SEEKS,
    SMALLEST,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import absolute, maximum


@apart
def keep_over(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, plan: Plan, n: int, t: Lanes, length: Lanes, low: Lanes,
    high: Lanes, part: int, lanes: Mask,
) -> None:  # fmt: skip
    """Keep what has to be of a part of a step in which the condition holds."""
    kept, kind, value = at.measures + ROW * layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND], plan.kept[n, KEPT_SIGNAL]
    begin, end = time_of(at, t, length, low), time_of(at, t, length, high)
    if kind == INTEGRATES:
        if value >= 0:
            known, gained = load(kept, KEPT_VALUE), splat(np.nan)
            if part == 0:
                gained = choose(high == 1.0, gain(sizes, at, plan, n), np.nan)
            asked = lanes & (choose(gained == gained, 0.0, 1.0) == 1.0)
            if any_lane(asked):
                scale = absolute(known) / (end - begin)
                mean = mean_over(kernels, sizes, at, t, length, low, high, part, value, scale, asked)
                gained = choose(asked, mean * (end - begin), gained)
            store(kept, KEPT_VALUE, choose(lanes, known + gained, known))
        store(kept, KEPT_TIME, choose(lanes, load(kept, KEPT_TIME) + (end - begin), load(kept, KEPT_TIME)))
    elif KEEPS_FIRST <= kind <= KEEPS_LAST:
        k = 0 if kind == KEEPS_FIRST else POINTS - 1
        known = load(kept, KEPT_TIME)
        news = lanes if kind == KEEPS_LAST else lanes & (choose(known == known, 1.0, 0.0) == 0.0)
        store(kept, KEPT_TIME, choose(news, begin if kind == KEEPS_FIRST else end, known))
        if kind == KEEPS_LAST:
            store(kept, KEPT_UNDEFINED, choose(news, splat(0.0), load(kept, KEPT_UNDEFINED)))
        if value >= 0:
            store(kept, KEPT_VALUE, choose(news, load(signals(sizes, at, part, k), value), load(kept, KEPT_VALUE)))
    elif kind != COUNTS:
        sign = -1.0 if kind == SMALLEST else 1.0
        keep_extreme(kernels, sizes, at, t, length, low, high, part, value, sign, kept, lanes)


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
        sense = choose(before > 0.0, splat(-1.0), splat(1.0))
        store(at.lanes, SEEKS, splat(float(condition)))
        place = locate(
            kernels, layout.MEASURE, at, first, rows, t, length, low, high, sense * before, sense * after,
            begins | ends, splat(0.0) > 0.0, sense,
        )  # fmt: skip
        low, high = choose(begins, place, low), choose(ends, maximum(place - finest_part(t, length), low), high)
        if plan.kept[n, KEPT_KIND] == COUNTS:
            known = load(kept, KEPT_VALUE)
            store(kept, KEPT_VALUE, choose(begins, known + 1.0, known))
    holds = lanes & ((before > 0.0) | (after > 0.0))
    if plan.kept[n, KEPT_KIND] != COUNTS and any_lane(holds):
        look_along(kernels, sizes, at, t, length, low, high, 1)
        keep_over(kernels, sizes, at, plan, n, t, length, low, high, 1, holds)
    unknown = lanes & (choose(before == before, choose(after == after, splat(0.0), 1.0), 1.0) == 1.0)
    if any_lane(unknown):
        _lose(kept, plan.kept[n, KEPT_KIND], after, unknown)


@apart
def keep_parts(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, whole: Lanes, lanes: Mask,
) -> None:  # fmt: skip
    """The same in the lanes in which a condition begins or ends to hold within the step."""
    condition = plan.kept[n, KEPT_CONDITION]
    for k in range(POINTS - 1):
        before, after = value_of(sizes, at, condition, k), value_of(sizes, at, condition, k + 1)
        low, high = fraction_of(k, splat(0.0), whole), fraction_of(k + 1, splat(0.0), whole)
        place = turn(sizes, at, condition, k)
        turns = lanes & (place > 0.0)
        if any_lane(turns):
            middle, to = choose(turns, place * whole, high), signals(sizes, at, 0, ELSEWHERE)
            look(kernels, sizes, at, t, length, middle, to)
            there = choose(turns, load(to, condition), after)
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, low, middle, before, there, lanes)
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, middle, high, there, after, turns)
        else:
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, low, high, before, after, lanes)
