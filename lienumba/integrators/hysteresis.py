"""When a condition counts as true, where what it is by rounding is no change."""

from typing import Any

from lienumba.numerics.number import Number
from lienumba.numerics.operations import HOLDS, maximum, where

HYSTERESIS_RTOL = 1e-9  # of the largest number that a condition has been: a fall by less is rounding
ROOT_RTOL = 1e-12  # of that: what a condition is by rounding next to its root
STAGE_RTOL = 1e-9  # of what a signal changes by in a step: a stage may be so far from where it should be


def settled(condition: Number, peak: Number, size: Number) -> Any:
    """A condition with hysteresis: one that was true before goes on until it has fallen by HYSTERESIS_RTOL, another one
    begins when it is above 0 by more than roundoff. peak: the most that it has been since it became true, 0 where it
    was not; size: the largest that it has been. NaN stays NaN."""
    goes_on = where(peak - condition <= HYSTERESIS_RTOL * size, maximum(condition, HOLDS), condition)
    faint = where(condition > HOLDS, where(condition <= ROOT_RTOL * size, 0.0, condition), condition)
    return where(peak > 0.0, goes_on, faint)
