"""Event location: the first time in the current step at which each guard function crosses zero upwards.

A crossing that the ends of the step bracket, and that is the only one by its rates, goes to the root finder at once.
All others are found by interval subdivision. The step is walked along in parts; in each of them all guard functions
are sampled at Lobatto's five nodes and halfway between these. A part is halved where the polynomial through the nodes
is wrong between them, of a guard function that may reach zero there. Else the samples bracket crossings, and so do the
extremes of the polynomial once they are confirmed on the guard function itself. The walk ends with the part in which
something happens that ends the step.
"""

from typing import Any, NamedTuple

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.events.guards import (
    end_value,
    evaluate,
    is_force,
    may_turn,
    start_value,
    threshold,
    time_row,
)
from lienumba.integrators.drivers.events.roots import Bracket, find_root, finest_fraction
from lienumba.integrators.drivers.events.tolerances import (
    CELLS,
    DOUBLING_RATIO,
    ERROR_SAFETY,
    GUARD_INTERPOLATION_RTOL,
    GUARD_VALUE_RTOL,
    KINK_RTOL,
    MAX_PARTS,
    MAX_TRIES,
    NEAR_CUT,
    PART_END,
    RANGE_SAFETY,
    SHORTEST_PART,
    WIDEST_PART,
)
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue, keep_state
from lienumba.integrators.drivers.lobatto import missed, point, rise, risen, through
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import (
    ABOVE_ZERO,
    ACTION,
    CUT,
    END_RATE,
    GUARD_NODES,
    LENGTH,
    LOW_PLACE,
    LOW_VALUE,
    NEAR_END,
    PICKED,
    POINTS,
    RATE,
    RECORDS,
    RESOLVED,
    UNTIL,
    T,
)
from lienumba.numerics.operations import HOLDS, absolute, maximum, minimum

CROSSES, POSSIBLE = -1.0, -2.0  # in the place of a time: crosses once, as its ends show; may cross, and is sampled


class Part(NamedTuple):
    """A part of the current step: fractions of the step."""

    begin: Any
    width: Any


@inlined
def _node(k: int) -> float:
    """A node of a part of length 1: Lobatto's, and halfway between these."""
    return point(k // 2) if k % 2 == 0 else 0.5 * (point(k // 2) + point(k // 2 + 1))


@inlined
def _at_node(context: Context, n: int, k: int) -> Any:
    """The nth guard function at a node; behind the nodes what is remembered of it from part to part."""
    return load(context.at.conditions, layout.node_row(context.sizes, k) + n)


@inlined
def _set_node(context: Context, n: int, k: int, value: Lanes, lanes: Mask) -> None:
    row = layout.node_row(context.sizes, k) + n
    store(context.at.conditions, row, choose(lanes, value, load(context.at.conditions, row)))


@inlined
def _rate_at_node(context: Context, n: int, k: int) -> Any:
    """The rate of the nth guard function at a node (1/s), NaN where it is not known."""
    if n >= context.sizes.events:
        return splat(np.nan)
    return load(context.at.conditions, layout.node_rate_row(context.sizes, k) + n)


@inlined
def _set_rates(context: Context, k: int, rates: Address, lanes: Mask) -> None:
    """Set the rates at a node to those that begin at an address."""
    row = layout.node_rate_row(context.sizes, k)
    stages.commit(lanes, context.at.conditions + ROW * row, rates, context.sizes.events)


@inlined
def ends_step(context: Context, n: int) -> bool:
    """Whether a crossing of the nth guard function ends the step: it stops the run, or changes the mechanism."""
    return n >= context.sizes.events or context.plan.stops[n] != 0 or context.plan.acts[n, ACTION] != RECORDS


@apart
def locate(context: Context, runs: ChunkRuns, queue: Queue, end: float, lanes: Mask) -> None:
    """Replace what CROSSES or is POSSIBLE among the times of guard functions by times, or by infinity where there is no
    crossing before what ends the step; end: of runs (s)."""
    until = load(context.at.lanes, UNTIL)
    sampled = splat(0.0)
    for n in range(layout.conditions(context.sizes)):
        sampled = choose(load(context.at.conditions, time_row(context, n)) == POSSIBLE, splat(1.0), sampled)
    begin = splat(0.0)
    cut = lanes & (until == load(context.at.lanes, CUT)) & (sampled == 0.0)
    if any_lane(cut) and context.kernels[layout.EXPAND] == 0:  # else the extension is a series, and exact everywhere
        begin = _begin_near_end(context, cut)
    store(context.at.lanes, NEAR_END, choose(begin > 0.0, splat(1.0), 0.0))
    if any_lane(lanes & (begin == 0.0)):
        stages.extend(context)
        stages.extend_at_end(context, begin > 0.0)
    for n in range(layout.conditions(context.sizes)):
        crosses = lanes & (load(context.at.conditions, time_row(context, n)) == CROSSES)
        if any_lane(crosses):
            before = choose(begin > 0.0, _at_node(context, n, 0), start_value(context, n))
            bracket = Bracket(begin, splat(1.0), before, end_value(context, n))
            _store_root(context, runs, queue, n, bracket, crosses)
    subdivided = lanes & (sampled > 0.0)
    if any_lane(subdivided):
        for n in range(layout.conditions(context.sizes)):
            _set_node(context, n, 0, start_value(context, n), subdivided)
        rates = layout.peak_row(context.sizes) + RATE * context.sizes.events
        _set_rates(context, 0, context.at.conditions + ROW * rates, subdivided)
        subdivide(context, runs, queue, splat(0.0), splat(1.0), end, subdivided)


@apart
def count_repeats(context: Context, runs: ChunkRuns, queue: Queue, end: float, lanes: Mask, until: Lanes) -> None:
    """Count further crossings of events that only record in the current step, up to a time, behind the first one."""
    t, length, known = load(context.at.lanes, T), load(context.at.clock, LENGTH), False
    for n in range(context.sizes.events):
        row = time_row(context, n)
        first = load(context.at.conditions, row)
        left = lanes & (first >= t) & (first < until) & (may_turn(context, n) > (1.0 if ends_step(context, n) else 0.0))
        while any_lane(left):
            if not known:
                stages.extend(context)
                known = True
            begin = choose(left, (load(context.at.conditions, row) - t) / length, 0.0)
            evaluate(context, begin)
            _set_node(context, n, 0, maximum(load(context.at.following, n), splat(HOLDS)), left)
            _set_rates(context, 0, context.at.following + ROW * layout.rate_row(context.sizes), left)
            store(context.at.conditions, row, choose(left, splat(POSSIBLE), load(context.at.conditions, row)))
            subdivide(context, runs, queue, begin, (until - t) / length, end, left)
            left = left & (load(context.at.conditions, row) < NEVER)
            store(context.at.lanes, PICKED, choose(left, splat(1.0), splat(0.0)))
            for lane in range(W):
                if context.rows[context.first.lanes + PICKED, lane] != 0.0:
                    runs.event_counts[queue.block[lane], n, queue.lane[lane]] += 1.0
        store(context.at.conditions, row, first)


@apart
def _begin_near_end(context: Context, cut: Mask) -> Lanes:
    """The fraction of the step, next to its end, at which the crossings for which it was cut are yet to come; 0 where
    they are not. What guard functions are there goes to node 0. The slope at the end is enough for this."""
    stages.end_slope(context)
    stages.extend_at_end(context, cut)
    begin = 1.0 - maximum(splat(NEAR_CUT), 8.0 * finest_fraction(context))
    begin = choose(cut & (begin > 0.5), begin, 0.0)
    evaluate(context, begin)
    for n in range(layout.conditions(context.sizes)):
        value = load(context.at.following, n)
        crosses = load(context.at.conditions, time_row(context, n)) == CROSSES
        begin = choose(crosses, choose(value <= 0.0, begin, 0.0), begin)
        _set_node(context, n, 0, value, cut)
    store(context.at.clock, layout.TIME, load(context.at.lanes, T))
    return begin


@apart
def subdivide(
    context: Context, runs: ChunkRuns, queue: Queue, begin: Lanes, end: Lanes, end_time: float, lanes: Mask
) -> None:
    """Locate the crossings that are POSSIBLE between two fractions of the step, by interval subdivision. What guard
    functions are at the first one is in node 0; end_time: of runs (s)."""
    length, left = load(context.at.clock, LENGTH), lanes & (begin < end)
    widest, first_end = choose(_watches_forces(context), WIDEST_PART * end_time / length, 1.0), _first_end(context)
    for n in range(layout.conditions(context.sizes)):
        start = _at_node(context, n, 0)
        _set_node(context, n, ABOVE_ZERO, choose(start > 0.0, splat(1.0), 0.0), lanes)
        _set_node(context, n, LOW_PLACE, begin, lanes)
        _set_node(context, n, LOW_VALUE, start, lanes)
    width = minimum(end - begin, widest)
    for _ in range(MAX_PARTS):
        if not any_lane(left):
            break
        _sample(context, begin, width, left)
        halve, easy = _resolve(context, width, left)
        done = left & ((halve == 0.0) | (width <= SHORTEST_PART))
        for n in range(layout.conditions(context.sizes)):
            asked = done & (load(context.at.conditions, time_row(context, n)) == POSSIBLE)
            if any_lane(asked):
                crossed = _cross_in_part(context, runs, queue, n, Part(begin, width), asked)
                ends = asked & (crossed > 0.0) & _are_ends(context, n)
                first_end = choose(ends, minimum(first_end, crossed), first_end)
            _set_node(context, n, 0, _at_node(context, n, GUARD_NODES - 1), done)
        last = layout.node_rate_row(context.sizes, GUARD_NODES - 1)
        _set_rates(context, 0, context.at.conditions + ROW * last, done)
        begin = choose(done, begin + width, begin)
        begin = choose(begin > end - PART_END, end, begin)
        width = choose(done, choose(easy > 0.0, 2.0 * width, width), 0.5 * width)
        width = minimum(minimum(width, widest), end - begin)
        left = left & (begin < end) & (first_end > begin - PART_END)  # what happens at one time may lie in two parts
    for n in range(layout.conditions(context.sizes)):
        row = time_row(context, n)
        time = load(context.at.conditions, row)
        store(context.at.conditions, row, choose(lanes & (time == POSSIBLE), splat(NEVER), time))
    store(context.at.clock, layout.TIME, load(context.at.lanes, T))


@inlined
def _watches_forces(context: Context) -> Mask:
    """Where contacts are closed, or joints stick: no error of the motion keeps steps short while these rest."""
    forces = splat(0.0)
    for n in range(layout.conditions(context.sizes)):
        forces = maximum(forces, is_force(context, n))
    return forces > 0.0


@inlined
def _first_end(context: Context) -> Lanes:
    """The fraction of the step at which the first crossing that is known already ends it, infinite without one."""
    first, t, length = splat(NEVER), load(context.at.lanes, T), load(context.at.clock, LENGTH)
    for n in range(layout.conditions(context.sizes)):
        time = load(context.at.conditions, time_row(context, n))
        known = _are_ends(context, n) & (time >= 0.0) & (time < NEVER)
        first = choose(known, minimum(first, (time - t) / length), first)
    return first


@inlined
def _resolve(context: Context, width: Lanes, lanes: Mask) -> tuple[Any, Any]:
    """1 where a part is to be halved, and 1 where the next one may be twice as wide; else 0. How long parts may be in
    which samples resolve all guard functions is kept for the next steps."""
    halve, wrong, easy = splat(0.0), splat(0.0), splat(1.0)
    for n in range(layout.conditions(context.sizes)):
        asked = lanes & (load(context.at.conditions, time_row(context, n)) == POSSIBLE)
        if any_lane(asked):
            wrong_here, matters, easy_here = _resolution(context, n)
            wrong = choose(asked, maximum(wrong, wrong_here), wrong)
            halve = choose(asked, maximum(halve, matters), halve)
            easy = choose(asked, minimum(easy, easy_here), easy)
    part, resolved = width * load(context.at.clock, LENGTH), load(context.at.lanes, RESOLVED)
    resolved = choose(lanes & (wrong == 0.0), maximum(resolved, part), resolved)
    resolved = choose(lanes & (halve > 0.0), minimum(resolved, 0.5 * part), resolved)
    store(context.at.lanes, RESOLVED, resolved)
    return halve, easy


@inlined
def _are_ends(context: Context, n: int) -> Mask:
    return splat(1.0 if ends_step(context, n) else 0.0) != 0.0


@apart
def _sample(context: Context, begin: Lanes, width: Lanes, lanes: Mask) -> None:
    """Evaluate all guard functions at the nodes of a part behind its begin. At the end of the step they are what they
    count as there."""
    last = GUARD_NODES - 1
    for k in range(1, GUARD_NODES):
        evaluate(context, begin + _node(k) * width)
        for n in range(layout.conditions(context.sizes)):
            value = load(context.at.following, n)
            if k == last:
                value = choose(begin + width >= 1.0, end_value(context, n), value)
            _set_node(context, n, k, value, lanes)
        _set_rates(context, k, context.at.following + ROW * layout.rate_row(context.sizes), lanes)
    end_rates = layout.peak_row(context.sizes) + END_RATE * context.sizes.events
    _set_rates(context, last, context.at.conditions + ROW * end_rates, lanes & (begin + width >= 1.0))


@apart
def _interpolation_error(context: Context, n: int) -> tuple[Any, Any, Any]:
    """By how much the polynomial through Lobatto's nodes is wrong halfway between them; the least and the largest
    sample."""
    a, b, d = _at_node(context, n, 0), _at_node(context, n, 2), _at_node(context, n, 4)
    e, f = _at_node(context, n, 6), _at_node(context, n, 8)
    error, least, most = splat(0.0), a, a
    for k in range(POINTS - 1):
        here, low, high = missed(_node(2 * k + 1), a, b, d, e, f, _at_node(context, n, 2 * k + 1))
        error, least, most = maximum(error, here), minimum(least, low), maximum(most, high)
    return error, least, most


@apart
def _resolution(context: Context, n: int) -> tuple[Lanes, Lanes, Lanes]:
    """Of the nth guard function in a part, 1 or 0: whether the polynomial is wrong between the nodes, whether that may
    hide a crossing, and whether it would be right in a part twice as long."""
    error, least, most = _interpolation_error(context, n)
    true = _at_node(context, n, ABOVE_ZERO) > 0.0
    nearest, beyond = choose(true, -least, most), threshold(context, n, true)
    hides = (nearest <= beyond) & (nearest + ERROR_SAFETY * error > beyond) & (error > KINK_RTOL * (most - least))
    wrong = (error > GUARD_INTERPOLATION_RTOL * (most - least)) & (error > GUARD_VALUE_RTOL * absolute(nearest))
    may = hides | (wrong & (nearest + RANGE_SAFETY * (most - least) > beyond))
    easy = error <= DOUBLING_RATIO * GUARD_INTERPOLATION_RTOL * (most - least)
    return choose(wrong, splat(1.0), 0.0), choose(may, splat(1.0), 0.0), choose(easy, splat(1.0), 0.0)


@apart
def _cross_in_part(context: Context, runs: ChunkRuns, queue: Queue, n: int, part: Part, lanes: Mask) -> Lanes:
    """Locate the first upward crossing of the nth guard function in a part that is resolved, also one that follows a
    fall below zero. Returns the fraction of the step at which it is, -1 where there is none."""
    true, low, f_low = (
        _at_node(context, n, ABOVE_ZERO),
        _at_node(context, n, LOW_PLACE),
        _at_node(context, n, LOW_VALUE),
    )
    high, f_high, left = splat(-1.0), splat(0.0), lanes
    rises, falls = threshold(context, n, splat(0.0) > 1.0), threshold(context, n, splat(0.0) < 1.0)
    middle, error = _at_node(context, n, 4), _interpolation_error(context, n)[0]
    o, p, q, r = through(
        _at_node(context, n, 0), _at_node(context, n, 2), middle, _at_node(context, n, 6), _at_node(context, n, 8)
    )
    for k in range(1, GUARD_NODES):
        side, beyond = choose(true > 0.0, splat(-1.0), splat(1.0)), choose(true > 0.0, falls, rises)
        f0, f1 = side * _at_node(context, n, k - 1), side * _at_node(context, n, k)
        x = _maximum_between(_node(k - 1), _node(k), side, o, p, q, r)
        top = side * (middle + risen(2.0 * x - 1.0, o, p, q, r)) + ERROR_SAFETY * error
        may = left & (x > 0.0) & (f0 <= beyond) & (f1 <= beyond) & (top > beyond)
        turns = left & (f0 <= beyond) & (f1 <= beyond) & (_rate_bound(context, n, k, side, part, f0, f1) > beyond)
        if any_lane(may | turns):
            bracket = Bracket(splat(_node(k - 1)), splat(_node(k)), f0, f1)
            place, top = _turn(context, n, k, side, part, turns)
            if any_lane(may):
                other, value = _maximise(context, n, side, beyond, part, bracket, x, may)
                place, top = choose(turns, place, other), choose(turns, top, value)
            may = may | turns
            up, down = may & (top > beyond) & (true == 0.0), may & (top > beyond) & (true > 0.0)
            high, f_high = choose(up, place, high), choose(up, top, f_high)
            low, f_low, true = choose(down, place, low), choose(down, -top, f_low), choose(down, splat(0.0), true)
            left = left & (high < 0.0)
        x1, value = part.begin + _node(k) * part.width, _at_node(context, n, k)
        ends = (x1 >= 1.0) & (splat(float(k)) == GUARD_NODES - 1)  # there roundoff has been set to 0
        up = left & (true == 0.0) & (value > choose(ends, splat(0.0), rises))
        high, f_high = choose(up, x1, high), choose(up, value, f_high)
        left = left & (high < 0.0)
        true = choose(left & (true > 0.0) & (value < -falls), splat(0.0), true)
        below = left & (true == 0.0) & (value <= 0.0)
        low, f_low = choose(below, x1, low), choose(below, value, f_low)
    _set_node(context, n, ABOVE_ZERO, true, lanes)
    _set_node(context, n, LOW_PLACE, low, lanes)
    _set_node(context, n, LOW_VALUE, f_low, lanes)
    found = lanes & (high > 0.0)
    if any_lane(found):
        _store_root(context, runs, queue, n, Bracket(low, high, f_low, f_high), found)
    return high


@inlined
def _maximum_between(begin: float, end: float, side: Lanes, o: Lanes, p: Lanes, q: Lanes, r: Lanes) -> Any:
    """Where a polynomial, times a sign, has its first maximum between two places of a part; -1 where it has none."""
    found = splat(-1.0)
    x0, slope0 = begin, side * rise(splat(2.0 * begin - 1.0), o, p, q, r)
    for n in range(1, CELLS + 1):
        x1 = begin + float(n) / CELLS * (end - begin)
        slope1 = side * rise(splat(2.0 * x1 - 1.0), o, p, q, r)
        top = (slope0 > 0.0) & (slope1 <= 0.0) & (found < 0.0)
        found = choose(top, x0 + slope0 / choose(top, slope0 - slope1, 1.0) * (x1 - x0), found)
        x0, slope0 = x1, slope1
    return found


@apart
def _maximise(
    context: Context, n: int, side: Lanes, beyond: Lanes, part: Part, bracket: Bracket, middle: Lanes, lanes: Mask
) -> tuple[Any, Any]:  # fmt: skip
    """Search a part for a maximum of the nth guard function, times a sign, that is above a threshold: by parabolas, and
    by halves, since there may be a kink, as long as the lines through three values lead there. Returns the fraction of
    the step at which it is, and the value there."""
    (x1, x3, f1, f3), x2 = bracket, middle
    evaluate(context, part.begin + x2 * part.width)
    f2 = side * load(context.at.following, n)
    left = lanes
    for k in range(MAX_TRIES):
        on, back = (f2 - f1) / (x2 - x1) * (x3 - x2), (f2 - f3) / (x3 - x2) * (x2 - x1)
        left = left & (f2 <= beyond) & (f2 + maximum(on, back) > beyond)
        if not any_lane(left):
            break
        curvature = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        vertex = x2 + shift / choose(curvature > 0.0, curvature, 1.0)
        halved = 0.5 * (x2 + choose(x3 - x2 > x2 - x1, x3, x1))
        inside = (curvature > 0.0) & (vertex > x1) & (vertex < x3) & (vertex != x2)
        x = choose(left, halved if k % 3 == 2 else choose(inside, vertex, halved), x2)
        evaluate(context, part.begin + x * part.width)
        f = choose(left, side * load(context.at.following, n), f2)
        higher, later = f > f2, x > x2
        x1, f1 = _replace(left & (higher & later), x2, f2, x1, f1)
        x3, f3 = _replace(left & higher & (x < x2), x2, f2, x3, f3)
        lower = left & (f <= f2)
        x1, f1 = _replace(lower & (x < x2), x, f, x1, f1)
        x3, f3 = _replace(lower & later, x, f, x3, f3)
        x2, f2 = _replace(left & higher, x, f, x2, f2)
    return part.begin + x2 * part.width, f2


@apart
def _turn(context: Context, n: int, k: int, side: Lanes, part: Part, lanes: Mask) -> tuple[Any, Any]:
    """Where between two nodes the rate of the nth guard function passes 0, in these lanes, as a fraction of the step,
    and the guard function there, times a sign."""
    low, high = part.begin + _node(k - 1) * part.width, part.begin + _node(k) * part.width
    bracket = Bracket(low, high, _rate_at_node(context, n, k - 1), _rate_at_node(context, n, k))
    place = high
    if any_lane(lanes):
        row = layout.rate_row(context.sizes) + n
        place = find_root(context, layout.EVENTS, row, bracket, splat(0.0) > 1.0, lanes)
        evaluate(context, place)
    return place, side * load(context.at.following, n)


@inlined
def _rate_bound(
    context: Context, n: int, k: int, side: Lanes, part: Part, f0: Lanes, f1: Lanes
) -> Any:  # fmt: skip
    """How large the nth guard function, times a sign, may be between two nodes, by its tangents there; -infinite where
    these do not say that it turns."""
    r0, r1 = side * _rate_at_node(context, n, k - 1), side * _rate_at_node(context, n, k)
    time = (_node(k) - _node(k - 1)) * part.width * load(context.at.clock, LENGTH)
    return choose((r0 > 0.0) & (r1 < 0.0), maximum(f0 + time * r0, f1 - time * r1), splat(-NEVER))


@inlined
def _replace(lanes: Mask, x: Lanes, f: Lanes, x_old: Lanes, f_old: Lanes) -> tuple[Lanes, Lanes]:
    return choose(lanes, x, x_old), choose(lanes, f, f_old)


@apart
def _store_root(context: Context, runs: ChunkRuns, queue: Queue, n: int, bracket: Bracket, lanes: Mask) -> None:
    """Find the crossing of the nth guard function in a bracket; store its time, and the state there if it is wanted."""
    cuts = (
        ends_step(context, n)
        and (n >= context.sizes.events or context.plan.stops[n] == 0)
        and context.kernels[layout.EXPAND] == 0
    )
    rough = lanes & (splat(1.0 if cuts else 0.0) != 0.0)
    # at 0 where something has just closed or opened
    f_begin = choose(bracket.f_begin < 0.0, bracket.f_begin, -bracket.f_end)
    bracket = Bracket(bracket.begin, bracket.end, f_begin, bracket.f_end)
    root = find_root(context, layout.EVENTS, n, bracket, rough, lanes)
    t, row = load(context.at.lanes, T), time_row(context, n)
    time = choose(root == 1.0, load(context.at.lanes, UNTIL), t + root * load(context.at.clock, LENGTH))
    store(context.at.conditions, row, choose(lanes, time, load(context.at.conditions, row)))
    if n < runs.event_states.shape[1]:
        between(context.kernels, context.at, root)
        stages.commit(root >= 1.0, context.at.now, context.at.new, layout.state_rows(context.sizes))
        store(context.at.lanes, PICKED, choose(lanes, splat(1.0), splat(0.0)))
        for lane in range(W):
            if context.rows[context.first.lanes + PICKED, lane] != 0.0:
                keep_state(context.rows, runs, queue, lane, n, context.first.now)
