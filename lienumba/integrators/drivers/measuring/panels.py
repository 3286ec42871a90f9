"""What is kept of a step panel by panel: as long as what is asked for is a polynomial of few points there.

A step that is long beside what a signal does is halved until that is so; most are one panel. Where halving does not
help, the signal is noise.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.lane_queue import NEVER
from lienumba.integrators.drivers.lobatto import missed, point
from lienumba.integrators.drivers.measuring.extremes import UNLIKE
from lienumba.integrators.drivers.measuring.pieces import bend, keep_pieces
from lienumba.integrators.drivers.measuring.points import look, look_along, signals, value_of
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    ELSEWHERE,
    KEPT_BENDS,
    KEPT_CONDITION,
    KEPT_EVENT,
    KEPT_OPEN,
    KEPT_SIGNAL,
    KEPT_TRUST,
    KEPT_TURNS,
    KEPT_UNLIKE,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import absolute, maximum, minimum

PATIENCE = 9  # halvings more than panels of which the polynomial is right
PANELS = 4096  # at most
ROUNDING = 2.0**-40  # of values: what differs by less is no course


@apart
def _unlike(sizes: Sizes, at: Workspace, signal: int, x: float) -> Lanes:
    """1 where the polynomial through the points of a panel is not like a signal, which was looked at at this fraction
    of it, else 0."""
    a, b, c = value_of(sizes, at, 0, signal, 0), value_of(sizes, at, 0, signal, 1), value_of(sizes, at, 0, signal, 2)
    d, e = value_of(sizes, at, 0, signal, 3), value_of(sizes, at, 0, signal, 4)
    wrong, least, most = missed(x, a, b, c, d, e, load(signals(sizes, at, 0, ELSEWHERE), signal))
    allowed = maximum(UNLIKE * (most - least), ROUNDING * maximum(absolute(most), absolute(least)))
    return choose(wrong > allowed, splat(1.0), 0.0)


@apart
def _opens(sizes: Sizes, at: Workspace, plan: Plan, n: int, cut: Mask) -> Mask:
    """Where what is between the ends of the step matters to the nth that is kept, or the step is left."""
    return cut | (load(at.measures + ROW * layout.KEPT_ROWS * n, KEPT_OPEN) != 0.0)


@apart
def _find_unlike(sizes: Sizes, at: Workspace, plan: Plan, cut: Mask, x: float) -> None:
    """The same of each that is kept and that the panel matters to, beside what another point has said."""
    for n in range(sizes.kept):
        kept, unlike = at.measures + ROW * layout.KEPT_ROWS * n, splat(0.0)
        value, condition = plan.kept[n, KEPT_SIGNAL], plan.kept[n, KEPT_CONDITION]
        if value >= 0 and plan.straight[value] != 0:
            unlike = _unlike(sizes, at, value, x)
        if condition >= 0 and plan.straight[condition] != 0:
            unlike = maximum(unlike, _unlike(sizes, at, condition, x))
        for k in range(plan.kept[n, KEPT_BENDS] + plan.kept[n, KEPT_TURNS]):
            signal = bend(plan, n, k)
            if plan.straight[signal] != 0:
                unlike = maximum(unlike, _unlike(sizes, at, signal, x))
        unlike = choose(_opens(sizes, at, plan, n, cut), unlike, 0.0)
        store(kept, KEPT_UNLIKE, maximum(load(kept, KEPT_UNLIKE), unlike))


@apart
def _forget(sizes: Sizes, at: Workspace, trust: float) -> None:
    """Nothing is unlike; trust: in everything from now on, where it is not negative."""
    for n in range(sizes.kept):
        kept = at.measures + ROW * layout.KEPT_ROWS * n
        store(kept, KEPT_UNLIKE, splat(0.0))
        if trust >= 0.0:
            store(kept, KEPT_TRUST, splat(trust))


@apart
def _judge(sizes: Sizes, at: Workspace, left: Mask) -> Lanes:
    """1 where anything asks for a halved panel in which there still is trust, else 0; each that does so loses some of
    it, and has some back where it does not. What is noise takes none of another's."""
    found, most = splat(0.0), splat(float(PATIENCE))
    for n in range(sizes.kept):
        kept = at.measures + ROW * layout.KEPT_ROWS * n
        trust, unlike = load(kept, KEPT_TRUST), load(kept, KEPT_UNLIKE)
        asks = left & (unlike > 0.0) & (trust > 0.0)
        found = choose(asks, splat(1.0), found)
        calm = left & (unlike == 0.0) & (trust > 0.0)
        store(kept, KEPT_TRUST, choose(asks, trust - 1.0, choose(calm, minimum(trust + 1.0, most), trust)))
    return found


@apart
def _happens(sizes: Sizes, at: Workspace, plan: Plan, n: int, until: Lanes, lanes: Mask) -> Lanes:
    """1 in the lanes in which an event leaves the step that has the condition of the nth that is kept, else 0."""
    event, time = plan.kept[n, KEPT_EVENT], splat(NEVER)
    if event >= 0:
        time = load(at.conditions, 2 * layout.conditions(sizes) + event)
    return choose(lanes & (time < NEVER) & (time <= until), splat(1.0), 0.0)


@apart
def keep_panels(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan, t: Lanes, length: Lanes,
    until: Lanes, whole: Lanes, good: Mask, cut: Mask,
) -> bool:  # fmt: skip
    """Keep what has to be of so much of a step, in the lanes `good`; cut: where it is left. Whether it was divided, so
    that its start is no longer among the points."""
    divided = False
    x, w = splat(0.0), choose(good, splat(1.0), 0.0)
    _forget(sizes, at, float(PATIENCE))
    for _ in range(PANELS):
        left = w > 0.0
        if not any_lane(left):
            return divided
        low, high = x * whole, choose(x + w == 1.0, whole, (x + w) * whole)
        look_along(kernels, sizes, at, t, length, low, high, 0)
        _forget(sizes, at, -1.0)
        for k in range(2):
            part = 0.5 * (point(2 * k) + point(2 * k + 1))
            look(kernels, sizes, at, t, length, low + part * (high - low), signals(sizes, at, 0, ELSEWHERE))
            _find_unlike(sizes, at, plan, cut, part)
        halved = left & (_judge(sizes, at, left) > 0.0)
        done, divided = left & (choose(halved, 1.0, 0.0) == 0.0), divided or any_lane(halved)
        for n in range(sizes.kept):
            opens = done & _opens(sizes, at, plan, n, cut)
            if any_lane(opens):
                comes = _happens(sizes, at, plan, n, until, opens & cut & (high == whole))
                keep_pieces(kernels, sizes, at, first, rows, plan, n, t, length, low, high, opens, comes)
        x = choose(done, x + w, x)
        w = choose(halved, 0.5 * w, choose(left, minimum(2.0 * w, 1.0 - x), 0.0))
    return divided
