"""Signals in Lobatto's five points of a step or of a part of it, and what the polynomial through them says."""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, all_lanes, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.events.search import locate
from lienumba.integrators.drivers.lobatto import fraction_of, point, risen, through
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import POINTS, SEEKS, UNTIL, Workspace
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import maximum, minimum

BEYOND = 0.32  # of what five values differ by, their interpolant goes beyond the largest one at most
GAP = 8  # places between two points in which an interpolant is looked at
LEANING = 2.0**-20  # of a step: so near to its ends it is looked at as they are seen from it


@inlined
def time_of(at: Workspace, t: Lanes, length: Lanes, fraction: Lanes) -> Lanes:
    return choose(fraction == 1.0, load(at.lanes, UNTIL), t + fraction * length)


@apart
def look(
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
        if any_lane(edge != 0.0):
            stages.commit(edge == -1.0, at.now, at.state, rows)
            stages.commit(edge == 1.0, at.now, at.new, rows)
    store(at.clock, layout.TIME, time_of(at, t, length, fraction))
    if sizes.leaping > 0:
        side = choose(fraction < LEANING, splat(-1.0), choose(fraction > 1.0 - LEANING, splat(1.0), 0.0))
        store(at.clock, layout.LEAN, -LEANING * side * length)
    call(kernels[layout.MEASURE], state, at.parameters, at.clock, 0, to, at.work)
    store(at.clock, layout.LEAN, splat(0.0))


@inlined
def signals(sizes: Sizes, at: Workspace, part: int, k: int) -> Address:
    """Where all signals are in a point: of a panel of the step (0), of a piece of it (1), or of a part of that (2)."""
    return at.measures + ROW * layout.signal_row(sizes, POINTS * part + k)


@apart
def look_along(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, low: Lanes, high: Lanes, part: int
) -> None:
    for k in range(POINTS):
        look(kernels, sizes, at, t, length, fraction_of(k, low, high), signals(sizes, at, part, k))


@inlined
def value_of(sizes: Sizes, at: Workspace, part: int, signal: int, k: int) -> Lanes:
    return load(signals(sizes, at, part, k), signal)


@inlined
def may_turn(sizes: Sizes, at: Workspace, part: int, signal: int) -> Mask:
    """Where the interpolant of a signal may be on both sides of 0."""
    least = value_of(sizes, at, part, signal, 0)
    most = least
    for k in range(1, POINTS):
        x = value_of(sizes, at, part, signal, k)
        least, most = minimum(least, x), maximum(most, x)
    beyond = BEYOND * (most - least)
    return (least - beyond <= 0.0) & (most + beyond > 0.0)


@apart
def turn(sizes: Sizes, at: Workspace, part: int, signal: int, k: int) -> Lanes:
    """Where, between two points of a part of the step between which a signal stays on one side of 0, its interpolant is
    the farthest on the other side: so much of the part, or -1 if it never is."""
    a, b, c = (
        value_of(sizes, at, part, signal, 0),
        value_of(sizes, at, part, signal, 1),
        value_of(sizes, at, part, signal, 2),
    )
    d, e = value_of(sizes, at, part, signal, 3), value_of(sizes, at, part, signal, 4)
    begin, end = value_of(sizes, at, part, signal, k), value_of(sizes, at, part, signal, k + 1)
    o, p, q, r = through(a, b, c, d, e)
    side, far, place = choose(begin > 0.0, splat(1.0), splat(-1.0)), splat(0.0), splat(-1.0)
    for n in range(1, GAP):
        x = point(k) + float(n) / GAP * (point(k + 1) - point(k))
        beyond = -side * (c + risen(splat(2.0 * x - 1.0), o, p, q, r))
        farther = beyond > far
        far, place = choose(farther, beyond, far), choose(farther, splat(x), place)
    return choose((begin > 0.0) & (end > 0.0), place, choose((begin <= 0.0) & (end <= 0.0), place, -1.0))


@apart
def passing(
    kernels: np.ndarray, at: Workspace, first: Workspace, rows: Rows, t: Lanes, length: Lanes, low: Lanes, high: Lanes,
    signal: int, before: Lanes, after: Lanes, lanes: Mask,
) -> Lanes:  # fmt: skip
    """Directly behind the place between two fractions of the step at which a signal passes or leaves 0, in lanes in
    which it does; before, after: what it is at these."""
    sense = choose((before > 0.0) | ((before == 0.0) & (after < 0.0)), splat(-1.0), splat(1.0))
    store(at.lanes, SEEKS, splat(float(signal)))
    return locate(
        kernels, layout.MEASURE, at, first, rows, t, length, low, high, sense * before, sense * after, lanes,
        splat(0.0) > 0.0, sense,
    )  # fmt: skip


@apart
def truth(sizes: Sizes, at: Workspace, part: int, condition: int, k: int) -> Lanes:
    """1 where a condition holds in a point of a part of the step, else 0."""
    return choose(value_of(sizes, at, part, condition, k) > 0.0, splat(1.0), splat(0.0))
