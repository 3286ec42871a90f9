"""What signals integrate to over a step or a part of it: by what its stages say, else by panels of Lobatto's rule.

A panel is halved until two of half its length say the same; the next one is twice as long. Kinks and jumps are enclosed
by that, and a step of many turns is divided into as many panels as it takes. Where no division brings two rules nearer
to each other, their difference is noise.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.lobatto import point
from lienumba.integrators.drivers.measuring.points import look, signals
from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import ELSEWHERE, KEPT_QUADRATURE, POINTS, Workspace
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import absolute, maximum, minimum

OUTER, INNER = 0.05, 49.0 / 180.0  # Lobatto's weights on a step of length 1, and in the middle:
CENTRE = 16.0 / 45.0
EXACT = 1e-10  # of the largest value, or of what is known, that a whole may be wrong by
FINEST = 2.0**-30  # of a part of a step: what is not divided any more
CONVERGES = 0.25  # times a difference, or less, is what is left of it by halving
PATIENCE = 16  # divisions one after the other without that
PANELS = 4096  # at most


@inlined
def gain(sizes: Sizes, at: Workspace, plan: Plan, n: int) -> Lanes:
    """What the step itself says that it adds to an integral, NaN where it does not."""
    place = plan.kept[n, KEPT_QUADRATURE]
    if place < 0:
        return splat(np.nan)
    return load(at.measures, layout.gain_row(sizes) + place)


@inlined
def _weight(k: int) -> float:
    """Lobatto's, of mean values."""
    if k == 2:
        return CENTRE
    return OUTER if k == 0 or k == POINTS - 1 else INNER


@inlined
def _simpson(k: int) -> float:
    """Simpson's, in the same points."""
    if k == 2:
        return 2.0 / 3.0
    return 1.0 / 6.0 if k == 0 or k == POINTS - 1 else 0.0


@inlined
def _seen(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, x: Lanes,
    value: int,
) -> Lanes:  # fmt: skip
    """A signal at a fraction of a part of the step."""
    to = signals(sizes, at, 0, ELSEWHERE)
    look(kernels, sizes, at, t, length, choose(x == 1.0, high, low + x * (high - low)), to)
    return load(to, value)


@apart
def _by_panels(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, value: int,
    size: Lanes, known: Lanes, lanes: Mask,
) -> Lanes:  # fmt: skip
    """The mean of a signal over a part of the step; size: the largest value so far; known: what it need not be more
    exact than."""
    x, w, total, stuck = splat(0.0), choose(lanes, splat(1.0), 0.0), splat(0.0), splat(0.0)
    for _ in range(PANELS):
        left = w > 0.0
        if not any_lane(left):
            break
        mean, simple = splat(0.0), splat(0.0)
        first, middle, last = splat(0.0), splat(0.0), splat(0.0)
        for k in range(POINTS):
            y = _seen(kernels, sizes, at, t, length, low, high, x + point(k) * w, value)
            mean, simple, size = mean + _weight(k) * y, simple + _simpson(k) * y, maximum(size, absolute(y))
            if k == 0:
                first = y
            elif k == 2:
                middle = y
            elif k == POINTS - 1:
                last = y
        differ = absolute(mean - simple)
        divided = left & (w * differ > EXACT * maximum(size, known))
        if any_lane(divided):
            begin, end = (first + middle) / 6.0, (middle + last) / 6.0
            earlier, later = OUTER * (first + middle), OUTER * (middle + last)
            for k in range(1, POINTS - 1):
                y = _seen(kernels, sizes, at, t, length, low, high, x + 0.5 * point(k) * w, value)
                z = _seen(kernels, sizes, at, t, length, low, high, x + (0.5 + 0.5 * point(k)) * w, value)
                earlier, later = earlier + _weight(k) * y, later + _weight(k) * z
                begin, end = begin + _simpson(k) * y, end + _simpson(k) * z
                size = choose(divided, maximum(size, maximum(absolute(y), absolute(z))), size)
            nearer, halves = minimum(absolute(earlier - begin), absolute(later - end)), 0.5 * (earlier + later)
            tries = choose(nearer > CONVERGES * differ, stuck + 1.0, splat(0.0))
            stuck = choose(divided & (stuck <= PATIENCE), tries, stuck)
            wrong = w * absolute(halves - mean)
            mean = choose(divided, halves, mean)
            divided = divided & (wrong > EXACT * maximum(size, known)) & (stuck <= PATIENCE) & (w > FINEST)
        done = choose(divided, splat(0.0), w)
        total, x = total + choose(done > 0.0, done * mean, splat(0.0)), x + done
        w = choose(divided, 0.5 * w, choose(left, minimum(2.0 * w, 1.0 - x), 0.0))
    return total


@apart
def mean_over(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, part: int,
    value: int, known: Lanes, lanes: Mask,
) -> Lanes:  # fmt: skip
    """The mean of a signal over a part of the step whose points were looked at; known: what it need not be more exact
    than."""
    mean, simple, size = splat(0.0), splat(0.0), splat(0.0)
    for k in range(POINTS):
        y = load(signals(sizes, at, part, k), value)
        mean, simple, size = mean + _weight(k) * y, simple + _simpson(k) * y, maximum(size, absolute(y))
    unsure = lanes & (absolute(mean - simple) > EXACT * maximum(size, known))
    if any_lane(unsure):
        exact = _by_panels(kernels, sizes, at, t, length, low, high, value, size, known, unsure)
        mean = choose(unsure, exact, mean)
    return mean
