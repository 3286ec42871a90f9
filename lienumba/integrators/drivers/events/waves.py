"""Conditions that pass 0 several times within the open step: which time is the first, of events and of gaps that close,
and how often events come true.

Where its rates at the ends of the step do not say that a condition passes 0 once, the step is walked along in parts
that are halved until theirs do.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.events.acting import if_it_acts
from lienumba.integrators.drivers.events.search import SOUGHT, look_within, search_between
from lienumba.integrators.drivers.events.turns import before_hits, least_of, length_of, rate_of
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (  # fmt: skip
    ACTION,
    EXTENT,
    OPENS,
    PICKED,
    RECORDS,
    SLIDES,
    SWIFTEST,
    SWITCH_KIND,
    UNILATERAL,
    UNTIL,
    Workspace,
)
from lienumba.integrators.reach import EVEN, by_rates
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import HOLDS, maximum, minimum

FINEST = 2.0**-12  # of a step: what is not halved any more
WAVES = 2.5  # times its largest size, what its largest rate so far would make of a condition: it may be a wave
STEADY = 1.25  # as `EVEN`, of whole steps: of waves both ends may be alike by chance
SHORT = 0.118  # of the way, the first part: no fraction of it, since values one period apart are alike
LAST = 2.0**-30  # so near to the end a part goes on to it


@inlined
def _evenly(p: Lanes, q: Lanes, mean: Lanes, even: float) -> Mask:
    """Whether what changes by this goes one way only, by what its rates at both ends would have it change by: even
    times as much, or less."""
    few, many = minimum(mean / even, mean * even), maximum(mean / even, mean * even)
    return (minimum(p, q) >= few) & (maximum(p, q) <= many)


@apart
def _wavers(sizes: Sizes, at: Workspace, n: int, length: Lanes) -> Lanes:
    """1 where a condition, whose rates are known, may turn in the open step and pass 0, else 0."""
    before, after = load(at.conditions, n), load(at.conditions, layout.conditions(sizes) + n)
    side, p, q = choose(before > 0.0, splat(-1.0), splat(1.0)), rate_of(sizes, at, n, 0, 1), rate_of(sizes, at, n, 1, 1)
    p, q, mean = side * length * p, side * length * q, side * (after - before)
    most = maximum(side * before, side * after) + by_rates(minimum(p, q), maximum(p, q), mean)
    turns = choose(_evenly(p, q, mean, STEADY), 1.0, 0.0) == 0.0
    may = most > least_of(sizes, at, n, before)
    if n < sizes.events:
        peaks = at.conditions + ROW * layout.peak_row(sizes)
        extent, swiftest = load(peaks, EXTENT * sizes.events + n), load(peaks, SWIFTEST * sizes.events + n)
        may = may | (length * swiftest > WAVES * extent)
    else:  # what opens, then closes, has no gap that is smallest between
        may = may & ((p > 0.0) | (q < 0.0)) & (before <= 0.0)
    return choose((p == p) & (q == q) & turns & may, splat(1.0), 0.0)


@inlined
def _rate_here(sizes: Sizes, at: Workspace, n: int) -> Lanes:
    """The rate of a condition where all were looked at last."""
    if n >= sizes.events:
        return -load(at.following, n + SLIDES - OPENS) / length_of(sizes, at, n)
    return load(at.following, layout.rate_row(sizes) + n)


@apart
def _walk(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, n: int, begin: Lanes, end: Lanes,
    value: Lanes, rate: Lanes, once: bool, lanes: Mask,
) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:  # fmt: skip
    """How often the nth condition comes true between two fractions of the open step, of which the first has this value
    and rate; once: at most. Between which fractions it first does, and what it is there."""
    x, w, f, r, left = begin, SHORT * (end - begin), value, rate, lanes & (end > begin)
    true, count = choose(value > 0.0, splat(1.0), 0.0), splat(0.0)
    low, high, f_low, f_high = begin, end, value, value
    on, off = least_of(sizes, at, n, splat(-1.0)), least_of(sizes, at, n, splat(1.0))
    for _ in range(int(4.0 / FINEST)):
        if not any_lane(left):
            break
        b = choose(x + w > end - LAST, end, x + w)
        look_within(kernels, layout.EVENTS, at, t, length, b)
        g, s = load(at.following, n), _rate_here(sizes, at, n)
        side = choose(f > 0.0, splat(-1.0), splat(1.0))
        p, q, mean = side * w * length * r, side * w * length * s, side * (g - f)
        most = maximum(side * f, side * g) + by_rates(minimum(p, q), maximum(p, q), mean)
        done = left & (_evenly(p, q, mean, EVEN) | (most <= off) | (w <= FINEST))
        becomes, falls = done & (true == 0.0) & (g > on), done & (true == 1.0) & (g < -off)
        first = becomes & (count == 0.0)
        low, high = choose(first, x, low), choose(first, b, high)
        f_low, f_high = choose(first, f, f_low), choose(first, g, f_high)
        count, true = choose(becomes, count + 1.0, count), choose(becomes, 1.0, choose(falls, 0.0, true))
        x, f, r = choose(done, b, x), choose(done, g, f), choose(done, s, r)
        w = choose(done, minimum(2.0 * w, end - x), choose(left, 0.5 * w, w))
        left = left & (x < end)
        if once:
            left = left & (count == 0.0)
    store(at.clock, layout.TIME, t)
    return count, low, high, f_low, f_high


@apart
def seek_first(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, good: Mask, t: Lanes, length: Lanes,
) -> None:  # fmt: skip
    """The time at which events first come true in the step, and gaps close: before the one that was found, or where
    none was, though they may have turned."""
    times, until, seen = at.conditions + ROW * 2 * layout.conditions(sizes), load(at.lanes, UNTIL), False
    whole = before_hits(sizes, at, plan, t, length)
    for n in range(layout.conditions(sizes)):
        if n >= sizes.events:
            gap = plan.switches[(n - sizes.events) // layout.CONDITIONS, SWITCH_KIND] == UNILATERAL
            if not gap or (n - sizes.events) % layout.CONDITIONS != OPENS:
                continue
        found, before = load(times, n), load(at.conditions, n)
        lanes = good & (found > t) & (_wavers(sizes, at, n, length) > 0.0)
        if any_lane(lanes):
            if not seen:
                stages.extend(kernels, sizes, nodes, at, t, length, until)
                seen = True
            end, rate = choose(lanes, minimum((found - t) / length, whole), 0.0), rate_of(sizes, at, n, 0, 1)
            count, low, high, f_low, f_high = _walk(
                kernels, sizes, at, t, length, n, splat(0.0), end, before, rate, True, lanes
            )
            earlier = lanes & (count > 0.0) & ((high < end) | (found == NEVER))
            if any_lane(earlier):
                store(times, n, choose(earlier, splat(SOUGHT), found))
                if n < sizes.events and plan.acts[n, ACTION] != RECORDS:
                    if_it_acts(sizes, first, rows, runs, queue, plan, n)
                earlier = earlier & (load(times, n) == SOUGHT)
                f_low = choose(f_low < 0.0, f_low, -f_high)
                search_between(
                    kernels, sizes, at, first, rows, runs, queue, n, t, length, low, high, f_low, f_high, earlier
                )


@apart
def see_peaks(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, lanes: Mask, t: Lanes, length: Lanes,
    left: Lanes,
) -> None:  # fmt: skip
    """The most that conditions of events have been, also halfway to where the open step is left in these lanes."""
    stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
    look_within(kernels, layout.EVENTS, at, t, length, choose(lanes, 0.5 * (left - t) / length, 0.5))
    for n in range(sizes.events):
        row = layout.peak_row(sizes) + n
        most = load(at.conditions, row)
        store(at.conditions, row, choose(lanes, maximum(most, load(at.following, n)), most))
    store(at.clock, layout.TIME, t)


@apart
def count_more(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, good: Mask, t: Lanes, length: Lanes, left: Lanes,
) -> None:  # fmt: skip
    """Events that only record, and happen in the open step before it is left, may happen again in it."""
    times, until, seen = at.conditions + ROW * 2 * layout.conditions(sizes), load(at.lanes, UNTIL), False
    ends = minimum(left, until)
    for n in range(sizes.events):
        if plan.acts[n, ACTION] != RECORDS or plan.stops[n] != 0:
            continue
        found = load(times, n)
        lanes = good & (found >= t) & (found < ends)
        if any_lane(lanes):
            lanes = lanes & (_wavers(sizes, at, n, length) > 0.0)
        if any_lane(lanes):
            if not seen:
                stages.extend(kernels, sizes, nodes, at, t, length, until)
                seen = True
            begin, end = choose(lanes, (found - t) / length, 0.0), choose(lanes, (ends - t) / length, 0.0)
            look_within(kernels, layout.EVENTS, at, t, length, begin)
            value = maximum(load(at.following, n), splat(HOLDS))
            rate = _rate_here(sizes, at, n)
            more, _low, _high, _before, _after = _walk(
                kernels, sizes, at, t, length, n, begin, end, value, rate, False, lanes
            )
            store(at.lanes, PICKED, choose(lanes, more, 0.0))
            for lane in range(W):
                if rows[first.lanes + PICKED, lane] != 0.0:
                    runs.event_counts[queue.block[lane], n, queue.lane[lane]] += rows[first.lanes + PICKED, lane]
