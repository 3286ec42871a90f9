"""What is kept of a run as a whole, step by step: extremes, integrals and instants on the continuous extension.

A step is looked at in Lobatto's five points, by which signals are integrated to order 8. Where a condition becomes true
or false between two of them, its place is found as those of events are, and what it holds for is looked at by itself.
An extreme is sought between the points wherever their interpolant may go beyond what is known.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, all_lanes, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.event_search import locate
from lienumba.integrators.drivers.lane_queue import Plan
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
    KEPT_VALUE,
    POINTS,
    SEEKS,
    SMALLEST,
    UNTIL,
    Sizes,
    Workspace,
)  # fmt: skip
from lienumba.numerics.operations import absolute, maximum, minimum

OUTER, INNER = 0.05, 49.0 / 180.0  # Lobatto's weights on a step of length 1, and in the middle:
CENTRE = 16.0 / 45.0
FIRST_POINT = 0.17267316464601142845  # (1 - sqrt(3/7))/2
BEYOND = 0.32  # of what five values differ by, their interpolant goes beyond the largest one at most
GAP = 8  # likewise between two points
SLOPE_B, SLOPE_C, SLOPE_D = 6.756502488724238, -8.0 / 3.0, 1.410164177942427
GRID = 32  # places in which an interpolant is looked at
UNSURE = 0.02  # of what they differ by, an interpolant may be wrong
FARTHEST = 4.0  # times what a signal changes by in two steps: inside of them it goes no farther
TRIES = 8  # at parabolas
FLAT = 1e-9  # of a step: a place of an extreme that is known so well has its value to the last bits


@inlined
def _point(k: int) -> float:
    """Lobatto's points on a step of length 1."""
    if k == 0:
        return 0.0
    if k == 1:
        return FIRST_POINT
    if k == 2:
        return 0.5
    return 1.0 - FIRST_POINT if k == 3 else 1.0


@inlined
def _fraction(k: int, low: Lanes, high: Lanes) -> Lanes:
    """The same between two fractions of the step, whose ends are these to the bit."""
    if k == 0:
        return low
    if k == 4:
        return high
    return low + _point(k) * (high - low)


@inlined
def _time(at: Workspace, t: Lanes, length: Lanes, fraction: Lanes) -> Lanes:
    return choose(fraction == 1.0, load(at.lanes, UNTIL), t + fraction * length)


@apart
def _look(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, fraction: Lanes, to: Address
) -> None:
    """All signals at a fraction of the open step."""
    rows, edge = layout.state_rows(sizes), choose(fraction == 0.0, -1.0, choose(fraction == 1.0, splat(1.0), 0.0))
    state = at.now
    if all_lanes(edge == -1.0):
        state = at.state
    elif all_lanes(edge == 1.0):
        state = at.new
    else:
        store(at.clock, layout.TIME, t)
        between(kernels, at, fraction)
        stages.commit(edge == -1.0, at.now, at.state, rows)
        stages.commit(edge == 1.0, at.now, at.new, rows)
    store(at.clock, layout.TIME, _time(at, t, length, fraction))
    call(kernels[layout.MEASURE], state, at.parameters, at.clock, 0, to, at.work)


@inlined
def _signals(sizes: Sizes, at: Workspace, part: int, k: int) -> Address:
    """Where all signals are in a point: of the step (part 0), or of a part of it (1)."""
    return at.measures + ROW * layout.signal_row(sizes, POINTS * part + k)


@apart
def _look_along(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, part: int
) -> None:
    for k in range(POINTS):
        _look(kernels, sizes, at, t, length, _fraction(k, low, high), _signals(sizes, at, part, k))


@inlined
def _interpolated(x: float, a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes) -> Lanes:
    """What the polynomial through five values is at x."""
    p, q, r, s, u = x, x - FIRST_POINT, x - 0.5, x - (1.0 - FIRST_POINT), x - 1.0
    m, n = FIRST_POINT, 1.0 - FIRST_POINT
    half = 0.5 - m
    ends = m * 0.5 * n
    inner = m * half * (n - m) * n
    centre = 0.5 * half * half * 0.5
    sum_ends = (q * r * s * u) / ends * a + (p * q * r * s) / ends * e
    return sum_ends - (p * r * s * u) / inner * b - (p * q * r * u) / inner * d + (p * q * s * u) / centre * c


@inlined
def _slope(a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes) -> Lanes:
    """Half of what the polynomial through five values rises by at the first one, into the step."""
    return -5.0 * a + SLOPE_B * b + SLOPE_C * c + SLOPE_D * d - 0.5 * e


@inlined
def _value(sizes: Sizes, at: Workspace, signal: int, k: int) -> Lanes:
    return load(_signals(sizes, at, 0, k), signal)


@inlined
def _may_turn(sizes: Sizes, at: Workspace, condition: int) -> Mask:
    """Where the interpolant of a condition may be on both sides of 0."""
    least, most = _value(sizes, at, condition, 0), _value(sizes, at, condition, 0)
    for k in range(1, POINTS):
        least, most = (
            minimum(least, _value(sizes, at, condition, k)),
            maximum(most, _value(sizes, at, condition, k)),
        )
    beyond = BEYOND * (most - least)
    return (least - beyond <= 0.0) & (most + beyond > 0.0)


@apart
def _turn(sizes: Sizes, at: Workspace, condition: int, k: int) -> Lanes:
    """Where, between two points of the step in which a condition is the same, its interpolant is the farthest on the
    other side: so much of the step, or -1 if it never is."""
    a, b, c = (
        _value(sizes, at, condition, 0),
        _value(sizes, at, condition, 1),
        _value(sizes, at, condition, 2),
    )
    d, e, begin = _value(sizes, at, condition, 3), _value(sizes, at, condition, 4), _value(sizes, at, condition, k)
    end = _value(sizes, at, condition, k + 1)
    side, far, place = choose(begin > 0.0, splat(1.0), splat(-1.0)), splat(0.0), splat(-1.0)
    for n in range(1, GAP):
        x = _point(k) + float(n) / GAP * (_point(k + 1) - _point(k))
        beyond = -side * _interpolated(x, a, b, c, d, e)
        farther = beyond > far
        far, place = choose(farther, beyond, far), choose(farther, splat(x), place)
    return choose((begin > 0.0) & (end > 0.0), place, choose((begin <= 0.0) & (end <= 0.0), place, -1.0))


@apart
def _peak(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, value: int,
    sign: float, kept: Address, lanes: Mask, a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes,
) -> None:  # fmt: skip
    """The extreme inside of a part of a step, from the values in its points on, where it goes beyond what is known."""
    most, place = a, splat(0.0)
    least = minimum(minimum(minimum(a, b), minimum(c, d)), e)
    for n in range(1, GRID + 1):
        x = float(n) / GRID
        y = _interpolated(x, a, b, c, d, e)
        more = y > most
        most, place = choose(more, y, most), choose(more, splat(x), place)
    known, rises, falls = sign * load(kept, KEPT_VALUE), _slope(a, b, c, d, e), _slope(e, d, c, b, a)
    inside = ((place > 0.0) & (place < 1.0)) | ((place == 0.0) & (rises > 0.0)) | ((place == 1.0) & (falls > 0.0))
    left = lanes & inside & (most + UNSURE * (most - least) > known)
    if not any_lane(left):
        return
    to, far = _signals(sizes, at, 2, 0), high - low
    near = 0.5 / GRID
    x2 = minimum(maximum(place, splat(near)), splat(1.0 - near))
    x1, x3 = x2 - near, x2 + near
    _look(kernels, sizes, at, t, length, low + x1 * far, to)
    f1 = sign * load(to, value)
    _look(kernels, sizes, at, t, length, low + x3 * far, to)
    f3 = sign * load(to, value)
    _look(kernels, sizes, at, t, length, low + x2 * far, to)
    f2 = sign * load(to, value)
    best, where_ = f2, x2
    for _ in range(TRIES):
        bend = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        u = x2 + choose(bend > 0.0, shift / choose(bend > 0.0, bend, 1.0), 0.0)
        left = left & (u > x1) & (u < x3) & (absolute(u - x2) > FLAT)
        if not any_lane(left):
            break
        u = choose(left, u, x2)
        _look(kernels, sizes, at, t, length, low + u * far, to)
        f = choose(left, sign * load(to, value), f2)
        higher, later = f > f2, u > x2
        x1, f1 = choose(left & higher & later, x2, x1), choose(left & higher & later, f2, f1)
        x3, f3 = (
            choose(left & higher & (u < x2), x2, x3),
            choose(left & higher & (u < x2), f2, f3),
        )
        lower = left & (f <= f2)
        x1, f1 = choose(lower & (u < x2), u, x1), choose(lower & (u < x2), f, f1)
        x3, f3 = choose(lower & later, u, x3), choose(lower & later, f, f3)
        x2, f2 = choose(left & higher, u, x2), choose(left & higher, f, f2)
        best, where_ = choose(f2 > best, f2, best), choose(f2 > best, x2, where_)
    better = lanes & inside & (best > known)
    store(kept, KEPT_VALUE, choose(better, sign * best, load(kept, KEPT_VALUE)))
    store(kept, KEPT_TIME, choose(better, _time(at, t, length, low + where_ * far), load(kept, KEPT_TIME)))


@apart
def _extreme(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, part: int,
    value: int, sign: float, kept: Address, lanes: Mask,
) -> None:  # fmt: skip
    """The largest value, or, with the sign -1, the smallest one, of a part of a step from `low` to `high`."""
    a, b = sign * load(_signals(sizes, at, part, 0), value), sign * load(_signals(sizes, at, part, 1), value)
    c, d = sign * load(_signals(sizes, at, part, 2), value), sign * load(_signals(sizes, at, part, 3), value)
    e = sign * load(_signals(sizes, at, part, 4), value)
    for k in range(POINTS):
        x, known = sign * load(_signals(sizes, at, part, k), value), sign * load(kept, KEPT_VALUE)
        better = lanes & (choose(x <= known, 1.0, 0.0) == 0.0)  # also where nothing is known yet
        store(kept, KEPT_VALUE, choose(better, sign * x, load(kept, KEPT_VALUE)))
        moment = _time(at, t, length, _fraction(k, low, high))
        store(kept, KEPT_TIME, choose(better, moment, load(kept, KEPT_TIME)))
    most, least = maximum(maximum(maximum(a, b), maximum(c, d)), e), minimum(minimum(minimum(a, b), minimum(c, d)), e)
    may = lanes & (most + BEYOND * (most - least) > sign * load(kept, KEPT_VALUE))
    falls, rises = splat(0.0), splat(0.0)  # where the ends are the extremes
    falls = choose((a >= b) & (b >= c) & (c >= d) & (d >= e) & (_slope(a, b, c, d, e) <= 0.0), 1.0, falls)
    rises = choose((a <= b) & (b <= c) & (c <= d) & (d <= e) & (_slope(e, d, c, b, a) <= 0.0), 1.0, rises)
    may = may & (falls + rises == 0.0)
    if any_lane(may):
        _peak(kernels, sizes, at, t, length, low, high, value, sign, kept, may, a, b, c, d, e)


@apart
def _over(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, plan: Plan, n: int, t: Lanes, length: Lanes, low: Lanes,
    high: Lanes, part: int, lanes: Mask,
) -> None:  # fmt: skip
    """Keep what has to be of a part of a step in which the condition holds."""
    kept, kind, value = at.measures + ROW * layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND], plan.kept[n, KEPT_SIGNAL]
    begin, end = _time(at, t, length, low), _time(at, t, length, high)
    if kind == INTEGRATES:
        if value >= 0:
            a, e = load(_signals(sizes, at, part, 0), value), load(_signals(sizes, at, part, 4), value)
            b, d = load(_signals(sizes, at, part, 1), value), load(_signals(sizes, at, part, 3), value)
            mean = OUTER * (a + e) + INNER * (b + d) + CENTRE * load(_signals(sizes, at, part, 2), value)
            known = load(kept, KEPT_VALUE)
            store(kept, KEPT_VALUE, choose(lanes, known + mean * (end - begin), known))
        store(kept, KEPT_TIME, choose(lanes, load(kept, KEPT_TIME) + (end - begin), load(kept, KEPT_TIME)))
    elif KEEPS_FIRST <= kind <= KEEPS_LAST:
        k = 0 if kind == KEEPS_FIRST else POINTS - 1
        known = load(kept, KEPT_TIME)
        news = lanes if kind == KEEPS_LAST else lanes & (choose(known == known, 1.0, 0.0) == 0.0)
        store(kept, KEPT_TIME, choose(news, begin if kind == KEEPS_FIRST else end, known))
        if value >= 0:
            store(kept, KEPT_VALUE, choose(news, load(_signals(sizes, at, part, k), value), load(kept, KEPT_VALUE)))
    elif kind != COUNTS:
        sign = -1.0 if kind == SMALLEST else 1.0
        _extreme(kernels, sizes, at, t, length, low, high, part, value, sign, kept, lanes)


@apart
def _true(sizes: Sizes, at: Workspace, condition: int, k: int) -> Lanes:
    """1 where a condition holds in a point of the step, else 0."""
    return choose(load(_signals(sizes, at, 0, k), condition) > 0.0, splat(1.0), splat(0.0))


@apart
def _keep_between(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, low: Lanes, high: Lanes, before: Lanes, after: Lanes, lanes: Mask,
) -> None:  # fmt: skip
    """The same between two fractions of the step, at which the condition is so much, and turns once at most."""
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
        low, high = choose(begins, place, low), choose(ends, place, high)
        if plan.kept[n, KEPT_KIND] == COUNTS:
            known = load(kept, KEPT_VALUE)
            store(kept, KEPT_VALUE, choose(begins, known + 1.0, known))
    holds = lanes & ((before > 0.0) | (after > 0.0))
    if plan.kept[n, KEPT_KIND] != COUNTS and any_lane(holds):
        _look_along(kernels, sizes, at, t, length, low, high, 1)
        _over(kernels, sizes, at, plan, n, t, length, low, high, 1, holds)


@apart
def _keep_parts(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, n: int, t: Lanes,
    length: Lanes, whole: Lanes, lanes: Mask,
) -> None:  # fmt: skip
    """The same in the lanes in which a condition begins or ends to hold within the step."""
    condition = plan.kept[n, KEPT_CONDITION]
    for k in range(POINTS - 1):
        before, after = _value(sizes, at, condition, k), _value(sizes, at, condition, k + 1)
        low, high = _fraction(k, splat(0.0), whole), _fraction(k + 1, splat(0.0), whole)
        turn = _turn(sizes, at, condition, k)
        turns = lanes & (turn > 0.0)
        if any_lane(turns):
            middle, to = choose(turns, turn * whole, high), _signals(sizes, at, 2, 0)
            _look(kernels, sizes, at, t, length, middle, to)
            there = choose(turns, load(to, condition), after)
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, low, middle, before, there, lanes)
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, middle, high, there, after, turns)
        else:
            _keep_between(kernels, sizes, at, first, rows, plan, n, t, length, low, high, before, after, lanes)


@inlined
def _reach(sizes: Sizes, at: Workspace, signal: int) -> Lanes:
    """By how much a signal may leave what it is at the ends of a step, judging by how it changes in it and did in the
    one before."""
    change = absolute(_value(sizes, at, signal, POINTS - 1) - _value(sizes, at, signal, 0))
    return FARTHEST * (change + load(_signals(sizes, at, 2, 1), signal))


@apart
def _matters(sizes: Sizes, at: Workspace, plan: Plan, n: int) -> Lanes:
    """1 where what is between the ends of the open step may change what is kept, else 0."""
    kept, kind, value = at.measures + ROW * layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND], plan.kept[n, KEPT_SIGNAL]
    condition, open_, never = plan.kept[n, KEPT_CONDITION], splat(0.0), splat(0.0)
    if condition >= 0:
        a, b = _value(sizes, at, condition, 0), _value(sizes, at, condition, POINTS - 1)
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
        a, b = sign * _value(sizes, at, value, 0), sign * _value(sizes, at, value, POINTS - 1)
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
        holds = _true(sizes, at, condition, POINTS - 1)
        store(kept, KEPT_TRUE, choose(good, holds, load(kept, KEPT_TRUE)))
    if plan.kept[n, KEPT_KIND] == KEEPS_LAST:
        _over(kernels, sizes, at, plan, n, t, length, splat(0.0), splat(1.0), 0, good & (holds == 1.0))


@inlined
def _note_changes(sizes: Sizes, at: Workspace, good: Mask) -> None:
    """How much signals change in this step, for the next one."""
    for signal in range(sizes.signals):
        change = absolute(_value(sizes, at, signal, POINTS - 1) - _value(sizes, at, signal, 0))
        store(_signals(sizes, at, 2, 1), signal, choose(good, change, load(_signals(sizes, at, 2, 1), signal)))


@apart
def measure(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    good: Mask, t: Lanes, length: Lanes, until: Lanes,
) -> None:  # fmt: skip
    """Keep what has to be of the open step in the lanes `good`, which are left at `until`. The clock stays as it is."""
    now = load(at.clock, layout.TIME)
    whole = choose(until < load(at.lanes, UNTIL), (until - t) / length, 1.0)
    matters = choose(whole < 1.0, splat(1.0), splat(0.0))
    _look(kernels, sizes, at, t, length, splat(0.0), _signals(sizes, at, 0, 0))
    _look(kernels, sizes, at, t, length, splat(1.0), _signals(sizes, at, 0, POINTS - 1))
    for n in range(sizes.kept):
        matters = maximum(matters, _matters(sizes, at, plan, n))
    if not any_lane(good & (matters == 1.0)):
        for n in range(sizes.kept):
            _keep_end(kernels, sizes, at, plan, n, t, length, good)
        _note_changes(sizes, at, good)
        store(at.clock, layout.TIME, now)
        return
    stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
    _look_along(kernels, sizes, at, t, length, splat(0.0), whole, 0)
    for n in range(sizes.kept):
        condition, kept = plan.kept[n, KEPT_CONDITION], at.measures + ROW * layout.KEPT_ROWS * n
        if condition < 0:
            _over(kernels, sizes, at, plan, n, t, length, splat(0.0), whole, 0, good)
            continue
        held, turns = splat(0.0), splat(-1.0)
        for k in range(POINTS):
            held = held + _true(sizes, at, condition, k)
        if any_lane(good & _may_turn(sizes, at, condition)):
            for k in range(POINTS - 1):
                turns = maximum(turns, _turn(sizes, at, condition, k))
        if plan.kept[n, KEPT_KIND] == COUNTS:
            news = good & (_true(sizes, at, condition, 0) > load(kept, KEPT_TRUE))
            store(kept, KEPT_VALUE, choose(news, load(kept, KEPT_VALUE) + 1.0, load(kept, KEPT_VALUE)))
        store(kept, KEPT_TRUE, choose(good, _true(sizes, at, condition, POINTS - 1), load(kept, KEPT_TRUE)))
        steady = turns <= 0.0
        always = good & steady & (held == float(POINTS))
        partly = good & ((turns > 0.0) | ((held > 0.0) & (held < float(POINTS))))
        if any_lane(always):
            _over(kernels, sizes, at, plan, n, t, length, splat(0.0), whole, 0, always)
        if any_lane(partly):
            _keep_parts(kernels, sizes, at, first, rows, plan, n, t, length, whole, partly)
    _note_changes(sizes, at, good)
    store(at.clock, layout.TIME, now)


@apart
def begin_measures(kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan) -> None:
    """What is kept of runs that begin: what holds at their start."""
    store(at.clock, layout.TIME, splat(0.0))
    call(kernels[layout.MEASURE], at.state, at.parameters, at.clock, 0, _signals(sizes, at, 0, 0), at.work)
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
            rows[kept + KEPT_VALUE, lane] = rows[kept + KEPT_TIME, lane] = np.nan if lasting else 0.0
            if true and kind == COUNTS:
                rows[kept + KEPT_VALUE, lane] = 1.0
            if true and lasting:
                rows[kept + KEPT_TIME, lane] = 0.0
                rows[kept + KEPT_VALUE, lane] = rows[seen + value, lane] if value >= 0 else 1.0
