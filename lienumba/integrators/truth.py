"""When a condition counts as true, where what it is by rounding is no change."""

from typing import Any

from lienumba.numerics.number import Number
from lienumba.numerics.operations import HOLDS, maximum, where

BAND = 1e-9  # of the largest number that a condition has been: a fall by less is rounding
AT_ROOT = 1e-12  # of that: what a condition is by rounding next to its root
BESIDE = 1e-9  # of what a signal changes by in a step: a stage may be so far from where it should be


def settled(condition: Number, true: Number, size: Number) -> Any:
    """What a condition is where it was `true` before, above 0, or not: it goes on until it is below 0 by the BAND, and
    begins when it is above by more than rounding; size: the largest number that it has been. NaN stays NaN."""
    goes_on = where(condition > -BAND * size, maximum(condition, HOLDS), condition)
    faint = where(condition > HOLDS, where(condition <= AT_ROOT * size, 0.0, condition), condition)
    return where(true > 0.0, goes_on, faint)
