"""What is kept of a part of a step in which a condition holds, whose points were looked at."""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.measuring.extremes import keep_extreme
from lienumba.integrators.drivers.measuring.integrals import gain, mean_over
from lienumba.integrators.drivers.measuring.points import signals, time_of
from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import (
    COUNTS,
    INTEGRATES,
    KEEPS_FIRST,
    KEEPS_LAST,
    KEPT_KIND,
    KEPT_SIGNAL,
    KEPT_TIME,
    KEPT_UNDEFINED,
    KEPT_VALUE,
    POINTS,
    SMALLEST,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import absolute


@apart
def keep_over(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, plan: Plan, n: int, t: Lanes, length: Lanes, low: Lanes,
    high: Lanes, part: int, lanes: Mask,
) -> None:  # fmt: skip
    """Keep what has to be of it."""
    kept, kind, value = at.measures + ROW * layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND], plan.kept[n, KEPT_SIGNAL]
    begin, end = time_of(at, t, length, low), time_of(at, t, length, high)
    if kind == INTEGRATES:
        if value >= 0:
            known, gained = load(kept, KEPT_VALUE), splat(np.nan)
            if part == 0:
                gained = choose((low == 0.0) & (high == 1.0), gain(sizes, at, plan, n), np.nan)
            asked = lanes & (choose(gained == gained, 0.0, 1.0) == 1.0)
            if any_lane(asked):
                scale = absolute(known) / (end - begin)
                mean = mean_over(kernels, sizes, at, t, length, low, high, part, value, scale, asked)
                gained = choose(asked, mean * (end - begin), gained)
            store(kept, KEPT_VALUE, choose(lanes, known + gained, known))
        store(kept, KEPT_TIME, choose(lanes, load(kept, KEPT_TIME) + (end - begin), load(kept, KEPT_TIME)))
    elif KEEPS_FIRST <= kind <= KEEPS_LAST:
        k = 0 if kind == KEEPS_FIRST else POINTS - 1
        known = load(kept, KEPT_TIME)
        news = lanes if kind == KEEPS_LAST else lanes & (choose(known == known, 1.0, 0.0) == 0.0)
        store(kept, KEPT_TIME, choose(news, begin if kind == KEEPS_FIRST else end, known))
        if kind == KEEPS_LAST:
            store(kept, KEPT_UNDEFINED, choose(news, splat(0.0), load(kept, KEPT_UNDEFINED)))
        if value >= 0:
            store(kept, KEPT_VALUE, choose(news, load(signals(sizes, at, part, k), value), load(kept, KEPT_VALUE)))
    elif kind != COUNTS:
        sign = -1.0 if kind == SMALLEST else 1.0
        keep_extreme(kernels, sizes, at, t, length, low, high, part, value, sign, kept, lanes)
