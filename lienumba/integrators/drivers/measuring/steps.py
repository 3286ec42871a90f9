"""What is kept of runs as a whole: what each step adds to it.

Signals are looked at in both ends of a step, and between them only where that may change what is kept.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.lane_queue import Plan
from lienumba.integrators.drivers.measuring.keeping import keep_over, keep_parts
from lienumba.integrators.drivers.measuring.points import look, look_along, may_turn, signals, truth, turn, value_of
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    COUNTS,
    FRESH,
    INTEGRATES,
    KEEPS_FIRST,
    KEEPS_LAST,
    KEPT_CONDITION,
    KEPT_KIND,
    KEPT_SIGNAL,
    KEPT_TIME,
    KEPT_TRUE,
    KEPT_UNDEFINED,
    KEPT_VALUE,
    POINTS,
    SMALLEST,
    UNTIL,
    Sizes,
    Workspace,
)  # fmt: skip
from lienumba.numerics.operations import absolute, maximum

FARTHEST = 4.0  # times what a signal changes by in two steps: inside of them it goes no farther


@inlined
def _reach(sizes: Sizes, at: Workspace, signal: int) -> Lanes:
    """By how much a signal may leave what it is at the ends of a step, judging by how it changes in it and did in the
    one before."""
    change = absolute(value_of(sizes, at, signal, POINTS - 1) - value_of(sizes, at, signal, 0))
    return FARTHEST * (change + load(signals(sizes, at, 2, 1), signal))


@apart
def _matters(sizes: Sizes, at: Workspace, plan: Plan, n: int) -> Lanes:
    """1 where what is between the ends of the open step may change what is kept, else 0."""
    kept, kind, value = at.measures + ROW * layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND], plan.kept[n, KEPT_SIGNAL]
    condition, open_, never = plan.kept[n, KEPT_CONDITION], splat(0.0), splat(0.0)
    if condition >= 0:
        a, b = value_of(sizes, at, condition, 0), value_of(sizes, at, condition, POINTS - 1)
        reach = _reach(sizes, at, condition)
        never = choose((a <= -reach) & (b <= -reach) & (a < 0.0), splat(1.0), splat(0.0))
        open_ = choose(((a > reach) & (b > reach)) | (never == 1.0), splat(0.0), splat(1.0))
    if kind == INTEGRATES:
        open_ = splat(1.0)
    elif kind == KEEPS_FIRST:
        known = load(kept, KEPT_TIME)
        open_ = choose(known == known, splat(0.0), splat(1.0))
    elif kind == COUNTS:
        open_ = maximum(open_, 1.0 - load(kept, KEPT_TRUE))
    elif kind != KEEPS_LAST:
        sign = -1.0 if kind == SMALLEST else 1.0
        far = sign * load(kept, KEPT_VALUE) - _reach(sizes, at, value)
        a, b = sign * value_of(sizes, at, value, 0), sign * value_of(sizes, at, value, POINTS - 1)
        open_ = choose((a <= far) & (b <= far), open_, 1.0)
    return choose(never == 1.0, splat(0.0), open_)


@apart
def _keep_end(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, plan: Plan, n: int, t: Lanes, length: Lanes, good: Mask
) -> None:
    """What the end of a step alone changes."""
    condition, kept = plan.kept[n, KEPT_CONDITION], at.measures + ROW * layout.KEPT_ROWS * n
    holds = splat(1.0)
    if condition >= 0:
        holds = truth(sizes, at, condition, POINTS - 1)
        store(kept, KEPT_TRUE, choose(good, holds, load(kept, KEPT_TRUE)))
    if plan.kept[n, KEPT_KIND] == KEEPS_LAST:
        keep_over(kernels, sizes, at, plan, n, t, length, splat(0.0), splat(1.0), 0, good & (holds == 1.0))


@inlined
def _note_changes(sizes: Sizes, at: Workspace, good: Mask) -> None:
    """How much signals change in this step, for the next one."""
    for signal in range(sizes.signals):
        change = absolute(value_of(sizes, at, signal, POINTS - 1) - value_of(sizes, at, signal, 0))
        store(signals(sizes, at, 2, 1), signal, choose(good, change, load(signals(sizes, at, 2, 1), signal)))


@apart
def measure(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    good: Mask, t: Lanes, length: Lanes, until: Lanes,
) -> None:  # fmt: skip
    """Keep what has to be of the open step in the lanes `good`, which are left at `until`. The clock stays as it is."""
    now = load(at.clock, layout.TIME)
    whole = choose(until < load(at.lanes, UNTIL), (until - t) / length, 1.0)
    matters = choose(whole < 1.0, splat(1.0), splat(0.0))
    look(kernels, sizes, at, t, length, splat(0.0), signals(sizes, at, 0, 0))
    look(kernels, sizes, at, t, length, splat(1.0), signals(sizes, at, 0, POINTS - 1))
    for n in range(sizes.kept):
        matters = maximum(matters, _matters(sizes, at, plan, n))
    if not any_lane(good & (matters == 1.0)):
        for n in range(sizes.kept):
            _keep_end(kernels, sizes, at, plan, n, t, length, good)
        _note_changes(sizes, at, good)
        store(at.clock, layout.TIME, now)
        return
    stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
    look_along(kernels, sizes, at, t, length, splat(0.0), whole, 0)
    for n in range(sizes.kept):
        condition, kept = plan.kept[n, KEPT_CONDITION], at.measures + ROW * layout.KEPT_ROWS * n
        if condition < 0:
            keep_over(kernels, sizes, at, plan, n, t, length, splat(0.0), whole, 0, good)
            continue
        held, turns, sum_ = splat(0.0), splat(-1.0), splat(0.0)
        for k in range(POINTS):
            held, sum_ = held + truth(sizes, at, condition, k), sum_ + value_of(sizes, at, condition, k)
        if any_lane(good & may_turn(sizes, at, condition)):
            for k in range(POINTS - 1):
                turns = maximum(turns, turn(sizes, at, condition, k))
        if plan.kept[n, KEPT_KIND] == COUNTS:
            news = good & (truth(sizes, at, condition, 0) > load(kept, KEPT_TRUE))
            store(kept, KEPT_VALUE, choose(news, load(kept, KEPT_VALUE) + 1.0, load(kept, KEPT_VALUE)))
        store(kept, KEPT_TRUE, choose(good, truth(sizes, at, condition, POINTS - 1), load(kept, KEPT_TRUE)))
        steady = turns <= 0.0
        always = good & steady & (held == float(POINTS))
        partly = good & ((turns > 0.0) | ((held > 0.0) & (held < float(POINTS))) | (sum_ != sum_))
        if any_lane(always):
            keep_over(kernels, sizes, at, plan, n, t, length, splat(0.0), whole, 0, always)
        if any_lane(partly):
            keep_parts(kernels, sizes, at, first, rows, plan, n, t, length, whole, partly)
    _note_changes(sizes, at, good)
    store(at.clock, layout.TIME, now)


@apart
def begin_measures(kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan) -> None:
    """What is kept of runs that begin: what holds at their start."""
    store(at.clock, layout.TIME, splat(0.0))
    call(kernels[layout.MEASURE], at.state, at.parameters, at.clock, 0, signals(sizes, at, 0, 0), at.work)
    seen = first.measures + layout.signal_row(sizes, 0)
    changes = first.measures + layout.signal_row(sizes, 2 * POINTS + 1)
    for lane in range(W):
        for signal in range(sizes.signals):
            if rows[first.lanes + FRESH, lane] != 0.0:
                rows[changes + signal, lane] = np.inf
    for n in range(sizes.kept):
        kept, kind = first.measures + layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND]
        value, condition = plan.kept[n, KEPT_SIGNAL], plan.kept[n, KEPT_CONDITION]
        lasting = kind < INTEGRATES or KEEPS_FIRST <= kind <= KEEPS_LAST
        for lane in range(W):
            if rows[first.lanes + FRESH, lane] == 0.0:
                continue
            true = condition < 0 or rows[seen + condition, lane] > 0.0
            rows[kept + KEPT_TRUE, lane] = 1.0 if true else 0.0
            unknown = condition >= 0 and rows[seen + condition, lane] != rows[seen + condition, lane]
            rows[kept + KEPT_UNDEFINED, lane] = 1.0 if unknown else 0.0
            rows[kept + KEPT_VALUE, lane] = rows[kept + KEPT_TIME, lane] = np.nan if lasting else 0.0
            if true and kind == COUNTS:
                rows[kept + KEPT_VALUE, lane] = 1.0
            if true and lasting:
                rows[kept + KEPT_TIME, lane] = 0.0
                rows[kept + KEPT_VALUE, lane] = rows[seen + value, lane] if value >= 0 else 1.0
