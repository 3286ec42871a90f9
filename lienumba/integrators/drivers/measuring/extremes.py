"""Extremes in a step: in its points, and between them wherever their interpolant may go beyond what is known."""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.lobatto import SQUARE, fraction_of, rise, risen, through
from lienumba.integrators.drivers.measuring.points import BEYOND, look, signals, time_of
from lienumba.integrators.layout import ELSEWHERE, KEPT_TIME, KEPT_UNDEFINED, KEPT_VALUE, POINTS, Workspace
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import maximum, minimum

GRID = 32  # places in which an interpolant is looked at
UNLIKE = 0.002  # of what its values differ by, an interpolant is wrong in a panel at most (`panels`)
UNSURE = 10.0 * UNLIKE  # in all of it
DOUBT = 20.0 * UNLIKE  # its slope at its ends
NEWTON = 4  # iterations to an extreme of the interpolant
STEPS = 3  # from there, by what is found
WIDER = 6  # steps uphill, each three times as long as the one before
EDGE = 2.0**-10  # of a stride uphill that ends at an end: where it is seen whether the extreme is before it
TRIES = 120  # at parabolas and halves
PATIENCE, NOISE = 16, 2.0**13  # tries, behind which what differs by so many times the rounding is noise
FINEST = 2.0**-50  # of a part of a step: what is not divided any more
ROUNDING = 2.0**-53  # of values: what an extreme is not sought for any more


@inlined
def _found(
    at: Workspace, t: Lanes, length: Lanes, fraction: Lanes, sign: float, kept: Address, lanes: Mask, value: Lanes
) -> None:
    """So much is there; what is undefined there is undefined as a whole."""
    undefined = load(kept, KEPT_UNDEFINED)
    store(kept, KEPT_UNDEFINED, choose(value <= value, undefined, choose(lanes, splat(1.0), undefined)))
    better = lanes & (value > sign * load(kept, KEPT_VALUE))
    store(kept, KEPT_VALUE, choose(better, sign * value, load(kept, KEPT_VALUE)))
    store(kept, KEPT_TIME, choose(better, time_of(at, t, length, fraction), load(kept, KEPT_TIME)))


@apart
def _enclose(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, value: int,
    sign: float, kept: Address, lanes: Mask, x2: Lanes, little: Lanes,
) -> None:  # fmt: skip
    """The extreme next to a place of a part of a step: uphill, by longer and longer steps, until it lies between two
    places, then by parabolas through these, and by halves where they do not lead on; little: what is no gain any more.
    """
    to, far, near = signals(sizes, at, 0, ELSEWHERE), high - low, 0.5 / GRID
    x2 = minimum(maximum(x2, splat(near)), splat(1.0 - near))
    x1, x3 = x2 - near, x2 + near
    look(kernels, sizes, at, t, length, low + x1 * far, to)
    f1 = sign * load(to, value)
    look(kernels, sizes, at, t, length, low + x3 * far, to)
    f3 = sign * load(to, value)
    look(kernels, sizes, at, t, length, low + x2 * far, to)
    f2 = sign * load(to, value)
    gap = f1 + f2 + f3
    for _ in range(WIDER):
        later = lanes & (f3 > f2) & (f3 >= f1) & (x3 < 1.0)
        earlier = lanes & (f1 > f2) & (f1 > f3) & (x1 > 0.0)
        if not any_lane(later | earlier):
            break
        stride = 2.0 * (x3 - x1)
        u = choose(later, minimum(x3 + stride, splat(1.0)), choose(earlier, maximum(x1 - stride, splat(0.0)), x2))
        look(kernels, sizes, at, t, length, low + u * far, to)
        f = sign * load(to, value)
        gap = choose(later | earlier, gap + f, gap)
        x0, f0 = x2, f2
        x2, f2 = choose(later, x3, choose(earlier, x1, x2)), choose(later, f3, choose(earlier, f1, f2))
        x1, f1 = choose(later, x0, choose(earlier, u, x1)), choose(later, f0, choose(earlier, f, f1))
        x3, f3 = choose(later, u, choose(earlier, x0, x3)), choose(later, f, choose(earlier, f0, f3))
    later, earlier = lanes & (f3 > f2) & (x3 >= 1.0), lanes & (f1 > f2) & (x1 <= 0.0)
    if any_lane(later | earlier):  # an end may be next to the extreme
        u = choose(later, x3 - EDGE * (x3 - x2), choose(earlier, x1 + EDGE * (x2 - x1), x2))
        look(kernels, sizes, at, t, length, low + u * far, to)
        f = sign * load(to, value)
        later, earlier = later & (f > f3), earlier & (f > f1)
        x1, f1 = choose(later, x2, x1), choose(later, f2, f1)
        x3, f3 = choose(earlier, x2, x3), choose(earlier, f2, f3)
        x2, f2 = choose(later | earlier, u, x2), choose(later | earlier, f, f2)
    left, best, where_ = lanes & (f2 >= f1) & (f2 >= f3), maximum(maximum(f1, f2), f3), x2
    where_ = choose(f1 == best, x1, choose(f3 == best, x3, x2))
    wide = x3 - x1
    for n in range(TRIES):
        bend = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        u = x2 + choose(bend > 0.0, shift / choose(bend > 0.0, bend, 1.0), 0.0)
        gained = bend * (u - x2) * (u - x2)
        inside = (bend > 0.0) & (u > x1) & (u < x3)
        done = inside & (choose(gained > little * (x2 - x1) * (x3 - x2) * (x3 - x1), 1.0, 0.0) == 0.0)
        left = left & (choose(done, 1.0, 0.0) == 0.0) & (x3 - x1 > FINEST)
        if n >= PATIENCE:
            left = left & (maximum(f2 - f1, f2 - f3) > NOISE * little)
        if not any_lane(left):
            break
        if n % 2 == 1:
            inside = inside & (x3 - x1 < 0.5 * wide)
            wide = x3 - x1
        halved = choose(x3 - x2 > x2 - x1, 0.5 * (x2 + x3), 0.5 * (x1 + x2))
        u = choose(left, choose(inside & (u != x2), u, halved), x2)
        look(kernels, sizes, at, t, length, low + u * far, to)
        f = choose(left, sign * load(to, value), f2)
        higher, later = f > f2, u > x2
        x1, f1 = choose(left & higher & later, x2, x1), choose(left & higher & later, f2, f1)
        x3, f3 = choose(left & higher & (u < x2), x2, x3), choose(left & higher & (u < x2), f2, f3)
        lower = left & (f <= f2)
        x1, f1 = choose(lower & (u < x2), u, x1), choose(lower & (u < x2), f, f1)
        x3, f3 = choose(lower & later, u, x3), choose(lower & later, f, f3)
        x2, f2 = choose(left & higher, u, x2), choose(left & higher, f, f2)
        best, where_, gap = choose(f2 > best, f2, best), choose(f2 > best, x2, where_), gap + f
    _found(at, t, length, low + where_ * far, sign, kept, lanes, choose(gap == gap, best, gap))


@apart
def _peak(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, value: int,
    sign: float, kept: Address, lanes: Mask, a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes,
) -> None:  # fmt: skip
    """The extreme inside of a part of a step, from the values in its points on, where it goes beyond what is known;
    undefined where it is that in a place that is looked at.

    First where the interpolant has it. What is missed there says how wrong the slope is, as the product of the
    distances from all points is what is missed (w e, whose slope is w' e); by it and by the bend of the interpolant the
    search goes on. Where that does not lead to an end, parabolas do.
    """
    o, p, q, r = through(a, b, c, d, e)
    most, s = a, splat(-1.0)
    least = minimum(minimum(minimum(a, b), minimum(c, d)), e)
    for n in range(1, GRID + 1):
        x = splat(2.0 * n / GRID - 1.0)
        y = c + risen(x, o, p, q, r)
        more = y > most
        most, s = choose(more, y, most), choose(more, x, s)
    rises, falls = rise(splat(-1.0), o, p, q, r), -rise(splat(1.0), o, p, q, r)
    doubt = DOUBT * (most - least)
    inside = ((s > -1.0) & (s < 1.0)) | ((s == -1.0) & (rises > -doubt)) | ((s == 1.0) & (falls > -doubt))
    left = lanes & inside & (most + UNSURE * (most - least) > sign * load(kept, KEPT_VALUE))
    if not any_lane(left):
        return
    little = ROUNDING * maximum(most, -least)
    near, bend = 1.0 / GRID, splat(0.0)
    s = minimum(maximum(s, splat(0.5 * near - 1.0)), splat(1.0 - 0.5 * near))
    first, last = maximum(s - near, splat(0.25 * near - 1.0)), minimum(s + near, splat(1.0 - 0.25 * near))
    for _ in range(NEWTON):
        bend = 2.0 * p + s * (6.0 * q + s * 12.0 * r)
        s = s - choose(bend < 0.0, rise(s, o, p, q, r) / choose(bend < 0.0, bend, 1.0), 0.0)
        s = minimum(maximum(s, first), last)
    to, x = signals(sizes, at, 0, ELSEWHERE), 0.5 * (s + 1.0)
    look(kernels, sizes, at, t, length, low + x * (high - low), to)
    found = sign * load(to, value)
    _found(at, t, length, low + x * (high - low), sign, kept, left, found)
    w, w_slope = s * (s * s - 1.0) * (s * s - SQUARE), SQUARE + s * s * (5.0 * s * s - 3.0 * (1.0 + SQUARE))
    slope = rise(s, o, p, q, r) + (found - c - risen(s, o, p, q, r)) * w_slope / w
    for _ in range(STEPS):
        shift = -slope / bend
        rest = choose((bend < 0.0) & (0.5 * slope * shift <= little), splat(0.0), 1.0)
        left = left & (rest > 0.0)
        near_by = left & (s + shift > first) & (s + shift < last)
        if not any_lane(near_by):
            break
        s = choose(near_by, s + shift, s)
        look(kernels, sizes, at, t, length, low + 0.5 * (s + 1.0) * (high - low), to)
        y = choose(near_by, sign * load(to, value), found)
        _found(at, t, length, low + 0.5 * (s + 1.0) * (high - low), sign, kept, near_by, y)
        slope = choose(near_by, (y - found) / shift + 0.5 * bend * shift, slope)
        found = y
    if any_lane(left):
        _enclose(kernels, sizes, at, t, length, low, high, value, sign, kept, left, 0.5 * (s + 1.0), little)


@apart
def keep_extreme(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, part: int,
    value: int, sign: float, kept: Address, lanes: Mask,
) -> None:  # fmt: skip
    """The largest value, or, with the sign -1, the smallest one, of a part of a step from `low` to `high`. What is
    undefined anywhere has none."""
    a, b = sign * load(signals(sizes, at, part, 0), value), sign * load(signals(sizes, at, part, 1), value)
    c, d = sign * load(signals(sizes, at, part, 2), value), sign * load(signals(sizes, at, part, 3), value)
    e = sign * load(signals(sizes, at, part, 4), value)
    for k in range(POINTS):
        x, known = sign * load(signals(sizes, at, part, k), value), sign * load(kept, KEPT_VALUE)
        better = lanes & (choose(x <= known, 1.0, 0.0) == 0.0)  # also where nothing is known yet
        store(kept, KEPT_UNDEFINED, choose(lanes & (x != x), splat(1.0), load(kept, KEPT_UNDEFINED)))
        store(kept, KEPT_VALUE, choose(better, sign * x, load(kept, KEPT_VALUE)))
        moment = time_of(at, t, length, fraction_of(k, low, high))
        store(kept, KEPT_TIME, choose(better, moment, load(kept, KEPT_TIME)))
    most, least = maximum(maximum(maximum(a, b), maximum(c, d)), e), minimum(minimum(minimum(a, b), minimum(c, d)), e)
    may = lanes & (most + BEYOND * (most - least) > sign * load(kept, KEPT_VALUE))
    o, p, q, r = through(a, b, c, d, e)
    doubt, falls, rises = DOUBT * (most - least), splat(0.0), splat(0.0)  # where the ends are the extremes
    falls = choose((a >= b) & (b >= c) & (c >= d) & (d >= e) & (rise(splat(-1.0), o, p, q, r) <= -doubt), 1.0, falls)
    rises = choose((a <= b) & (b <= c) & (c <= d) & (d <= e) & (rise(splat(1.0), o, p, q, r) >= doubt), 1.0, rises)
    may = may & (falls + rises == 0.0)
    if any_lane(may):
        _peak(kernels, sizes, at, t, length, low, high, value, sign, kept, may, a, b, c, d, e)
