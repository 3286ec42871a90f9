"""Lobatto's five points of a step, and the polynomial through what is there."""

from lienumba.compiler.lanes import Lanes, splat
from lienumba.compiler.routines.marks import inlined
from lienumba.numerics.operations import absolute, maximum, minimum

FIRST_POINT = 0.17267316464601142845  # (1 - sqrt(3/7))/2
SQUARE = 3.0 / 7.0  # of where the inner points are, between -1 and 1


@inlined
def point(k: int) -> float:
    """Lobatto's points on a step of length 1."""
    if k == 0:
        return 0.0
    if k == 1:
        return FIRST_POINT
    if k == 2:
        return 0.5
    return 1.0 - FIRST_POINT if k == 3 else 1.0


@inlined
def through(a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes) -> tuple[Lanes, Lanes, Lanes, Lanes]:
    """The polynomial through five values: the coefficients of s, s^2, s^3, s^4 beside c, for s from -1 to 1."""
    sums, inner_sums = 0.5 * (e + a) - c, (0.5 * (d + b) - c) / SQUARE
    leaps, inner_leaps = 0.5 * (e - a), 0.5 * (d - b) / (1.0 - 2.0 * FIRST_POINT)
    cubic, quartic = (leaps - inner_leaps) / (1.0 - SQUARE), (sums - inner_sums) / (1.0 - SQUARE)
    return leaps - cubic, sums - quartic, cubic, quartic


@inlined
def risen(s: Lanes, o: Lanes, p: Lanes, q: Lanes, r: Lanes) -> Lanes:
    """What it has risen by from the middle on."""
    return s * (o + s * (p + s * (q + s * r)))


@inlined
def rise(s: Lanes, o: Lanes, p: Lanes, q: Lanes, r: Lanes) -> Lanes:
    """Its derivative by s."""
    return o + s * (2.0 * p + s * (3.0 * q + s * 4.0 * r))


@inlined
def missed(x: float, a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes, found: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """By how much the polynomial through five values misses what was found at a fraction; the least and the largest of
    all six."""
    o, p, q, r = through(a, b, c, d, e)
    most = maximum(maximum(maximum(a, b), maximum(c, d)), maximum(e, found))
    least = minimum(minimum(minimum(a, b), minimum(c, d)), minimum(e, found))
    return absolute(found - c - risen(splat(2.0 * x - 1.0), o, p, q, r)), least, most
