"""Extremes of a signal in a subinterval: in its nodes, and between them where its interpolant has one.

The interpolant decides where to look; what is recorded are true samples, refined by parabolas through three of them.
"""

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, choose, load, splat
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.lobatto import rise, risen
from lienumba.integrators.drivers.measuring.points import (
    INTERPOLATION_RTOL,
    Record,
    Subinterval,
    fraction_of_node,
    interpolant,
    node,
    put,
    time_of,
    value_at,
    value_elsewhere,
    without,
)
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import KEPT_TIME, KEPT_UNDEFINED, KEPT_VALUE, NODES
from lienumba.numerics.operations import absolute, maximum, minimum

GRID = 16  # places in which the interpolant is evaluated
NEWTON = 4  # iterations from there to its extreme, which may be very near to an end
SLOPE_ERROR = 20.0 * INTERPOLATION_RTOL  # of the spread, by s from -1 to 1: of the slope of an interpolant at its ends
ROUNDOFF = 2.0**-53  # of the values: what an extreme need not be more exact than
SMALLEST_BRACKET = 2.0**-45  # of a subinterval
MAX_SAMPLES = 100  # of which every other one halves the bracket
MAX_END_SAMPLES = 16  # as long as an end is higher than what is found inside: down to 2^-20 of a subinterval from it
NEVER_LARGEST = -1e300


@inlined
def _highest_of_interpolant(
    context: Context, part: Subinterval, signal: int, sign: float
) -> tuple[Lanes, Lanes, Lanes]:
    """Where the interpolant is highest in a subinterval, between 0 and 1, how high the signal may be there, and the
    largest size of its values. It is not higher inside than at an end from which the interpolant surely falls."""
    c, o, p, q, r = interpolant(context, part, signal, sign)
    s, highest = splat(-1.0), sign * value_at(context, part, signal, 0)
    lowest = highest
    for n in range(1, GRID + 1):
        x = splat(2.0 * n / GRID - 1.0)
        y = c + risen(x, o, p, q, r)
        s, highest, lowest = choose(y > highest, x, s), maximum(y, highest), minimum(y, lowest)
    outwards = SLOPE_ERROR * (highest - lowest)
    outside = (s == -1.0) & (rise(s, o, p, q, r) <= -outwards)
    outside = outside | ((s == 1.0) & (rise(s, o, p, q, r) >= outwards))
    first, last = maximum(s - 2.0 / GRID, splat(-1.0)), minimum(s + 2.0 / GRID, splat(1.0))
    for _ in range(NEWTON):
        bend = 2.0 * p + s * (6.0 * q + s * 12.0 * r)
        s = s - choose(bend < 0.0, rise(s, o, p, q, r) / choose(bend < 0.0, bend, 1.0), 0.0)
        s = minimum(maximum(s, first), last)
    reach = highest + 10.0 * INTERPOLATION_RTOL * (highest - lowest)
    return 0.5 * (s + 1.0), choose(outside, splat(NEVER_LARGEST), reach), maximum(absolute(highest), absolute(lowest))


@inlined
def _highest_node(
    context: Context, part: Subinterval, signal: int, sign: float
) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes, Lanes]:
    """The places of the highest node and of both beside it (of itself at an end), and the values there."""
    x1, x2, x3 = splat(0.0), splat(0.0), splat(0.0)
    f2 = sign * value_at(context, part, signal, 0)
    f1, f3 = f2, f2
    for k in range(NODES):
        y = sign * value_at(context, part, signal, k)
        left, right, higher = k - 1 if k > 0 else 0, k + 1 if k < NODES - 1 else k, y >= f2
        x1, f1 = choose(higher, splat(node(left)), x1), choose(higher, sign * value_at(context, part, signal, left), f1)
        x3 = choose(higher, splat(node(right)), x3)
        f3 = choose(higher, sign * value_at(context, part, signal, right), f3)
        x2, f2 = choose(higher, splat(node(k)), x2), choose(higher, y, f2)
    return x1, x2, x3, f1, f2, f3


@apart
def interior_extreme(
    context: Context, part: Subinterval, signal: int, sign: float, known: Lanes, lanes: Mask
) -> tuple[Lanes, Lanes]:  # fmt: skip
    """Where sign times a signal is largest inside a subinterval, a fraction of the step, and its value there; the value
    NEVER_LARGEST where it may not be above what is known.

    By successive parabolic interpolation of a bracket around the highest node, first where the interpolant is highest.
    """
    u, reach, size = _highest_of_interpolant(context, part, signal, sign)
    left = lanes & (reach > known)
    if not any_lane(left):
        return part.low, splat(NEVER_LARGEST)
    x1, x2, x3, f1, f2, f3 = _highest_node(context, part, signal, sign)
    asked, width, place, undefined = left, x3 - x1, x2, splat(0.0)
    u = choose((u > x1) & (u < x3) & ((u < x2) | (u > x2)), u, 0.5 * (x1 + x3))
    for n in range(MAX_SAMPLES):
        u = choose(left, u, x2)
        f = choose(left, sign * value_elsewhere(context, part, signal, u), f2)
        undefined = undefined + f
        higher, lower, right = left & (f > f2), left & (f <= f2), u > x2
        x0, f0 = x2, f2
        x2, f2 = choose(higher, u, x2), choose(higher, f, f2)
        x1, f1 = choose(higher & right, x0, x1), choose(higher & right, f0, f1)
        x3, f3 = choose(higher & (u < x0), x0, x3), choose(higher & (u < x0), f0, f3)
        x1, f1 = choose(lower & (u < x0), u, x1), choose(lower & (u < x0), f, f1)
        x3, f3 = choose(lower & right, u, x3), choose(lower & right, f, f3)
        bend = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        u = x2 + choose(bend > 0.0, shift / choose(bend > 0.0, bend, 1.0), 0.0)
        inside = (bend > 0.0) & (u > x1) & (u < x3)
        gain = bend * (u - x2) * (u - x2)
        done = inside & (gain <= ROUNDOFF * size * (x2 - x1) * (x3 - x2) * (x3 - x1))
        place = choose(left, choose(done, u, x2), place)
        left = without(left, done) & (x3 - x1 > SMALLEST_BRACKET)
        if n >= MAX_END_SAMPLES:
            left = left & (x1 < x2) & (x2 < x3)
        if not any_lane(left):
            break
        if n % 2 == 1:
            inside = inside & (x3 - x1 < 0.5 * width)
            width = x3 - x1
        halved = choose(x3 - x2 > x2 - x1, 0.5 * (x2 + x3), 0.5 * (x1 + x2))
        u = choose(inside & ((u < x2) | (u > x2)), u, halved)
    value = choose(undefined == undefined, f2, undefined)
    return part.low + place * (part.high - part.low), choose(asked, value, splat(NEVER_LARGEST))


@inlined
def _compare(rows: Address, sign: float, lanes: Mask, value: Lanes, time: Lanes) -> None:
    """Record a value that is beyond the extreme so far, which is none where it is NaN; NaN makes it undefined."""
    better = lanes & (choose(value <= sign * load(rows, KEPT_VALUE), 1.0, 0.0) == 0.0)
    put(rows, KEPT_UNDEFINED, without(lanes, value <= value), splat(1.0))
    put(rows, KEPT_VALUE, better, sign * value)
    put(rows, KEPT_TIME, better, time)


@apart
def record_extreme(context: Context, record: Record, part: Subinterval, sign: float, lanes: Mask) -> None:
    """Record the largest value of a signal in a subinterval, or with the sign -1 the smallest one."""
    rows, signal = record.rows, record.signal
    for k in range(NODES):
        time = time_of(context.at, part, fraction_of_node(context, k, part))
        value = sign * value_at(context, part, signal, k)
        _compare(rows, sign, lanes, value, time)
    place, value = interior_extreme(context, part, signal, sign, sign * load(rows, KEPT_VALUE), lanes)
    _compare(rows, sign, lanes, value, time_of(context.at, part, place))
