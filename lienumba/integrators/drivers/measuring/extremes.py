"""Extremes in a step: in its points, and between them wherever their interpolant may go beyond what is known."""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart
from lienumba.integrators.drivers.measuring.points import (
    BEYOND,
    fraction_of,
    interpolated,
    look,
    signals,
    slope,
    time_of,
)
from lienumba.integrators.layout import ELSEWHERE, KEPT_TIME, KEPT_UNDEFINED, KEPT_VALUE, POINTS, Sizes, Workspace
from lienumba.numerics.operations import absolute, maximum, minimum

GRID = 32  # places in which an interpolant is looked at
UNSURE = 0.02  # of what they differ by, an interpolant may be wrong
TRIES = 8  # at parabolas
FLAT = 1e-9  # of a step: a place of an extreme that is known so well has its value to the last bits


@apart
def _peak(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, value: int,
    sign: float, kept: Address, lanes: Mask, a: Lanes, b: Lanes, c: Lanes, d: Lanes, e: Lanes,
) -> None:  # fmt: skip
    """The extreme inside of a part of a step, from the values in its points on, where it goes beyond what is known;
    undefined where it is that in a place that is looked at."""
    most, place = a, splat(0.0)
    least = minimum(minimum(minimum(a, b), minimum(c, d)), e)
    for n in range(1, GRID + 1):
        x = float(n) / GRID
        y = interpolated(x, a, b, c, d, e)
        more = y > most
        most, place = choose(more, y, most), choose(more, splat(x), place)
    known, rises, falls = sign * load(kept, KEPT_VALUE), slope(a, b, c, d, e), slope(e, d, c, b, a)
    inside = ((place > 0.0) & (place < 1.0)) | ((place == 0.0) & (rises > 0.0)) | ((place == 1.0) & (falls > 0.0))
    left = lanes & inside & (most + UNSURE * (most - least) > known)
    if not any_lane(left):
        return
    to, far = signals(sizes, at, 0, ELSEWHERE), high - low
    near = 0.5 / GRID
    x2 = minimum(maximum(place, splat(near)), splat(1.0 - near))
    x1, x3 = x2 - near, x2 + near
    look(kernels, sizes, at, t, length, low + x1 * far, to)
    f1 = sign * load(to, value)
    look(kernels, sizes, at, t, length, low + x3 * far, to)
    f3 = sign * load(to, value)
    look(kernels, sizes, at, t, length, low + x2 * far, to)
    f2 = sign * load(to, value)
    best, where_, gap = f2, x2, f1 + f2 + f3
    for _ in range(TRIES):
        bend = (x2 - x1) * (f2 - f3) + (x3 - x2) * (f2 - f1)
        shift = 0.5 * ((x3 - x2) * (x3 - x2) * (f2 - f1) - (x2 - x1) * (x2 - x1) * (f2 - f3))
        u = x2 + choose(bend > 0.0, shift / choose(bend > 0.0, bend, 1.0), 0.0)
        left = left & (u > x1) & (u < x3) & (absolute(u - x2) > FLAT)
        if not any_lane(left):
            break
        u = choose(left, u, x2)
        look(kernels, sizes, at, t, length, low + u * far, to)
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
        best, where_, gap = choose(f2 > best, f2, best), choose(f2 > best, x2, where_), gap + f
    store(kept, KEPT_UNDEFINED, choose(lanes & inside & (gap != gap), splat(1.0), load(kept, KEPT_UNDEFINED)))
    better = lanes & inside & (best > known)
    store(kept, KEPT_VALUE, choose(better, sign * best, load(kept, KEPT_VALUE)))
    store(kept, KEPT_TIME, choose(better, time_of(at, t, length, low + where_ * far), load(kept, KEPT_TIME)))


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
    falls, rises = splat(0.0), splat(0.0)  # where the ends are the extremes
    falls = choose((a >= b) & (b >= c) & (c >= d) & (d >= e) & (slope(a, b, c, d, e) <= 0.0), 1.0, falls)
    rises = choose((a <= b) & (b <= c) & (c <= d) & (d <= e) & (slope(e, d, c, b, a) <= 0.0), 1.0, rises)
    may = may & (falls + rises == 0.0)
    if any_lane(may):
        _peak(kernels, sizes, at, t, length, low, high, value, sign, kept, may, a, b, c, d, e)
