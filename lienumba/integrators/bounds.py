"""How far a signal may go between the ends of a step from what it is there, by what is known at them."""

from typing import Any

from lienumba.integrators.codes import HUGE
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, kernel, maximum, where

CHANGE_SAFETY = 4.0  # times what a signal changes by in two steps: inside of them it goes no farther
OSCILLATION_RATIO = 2.5  # a step times the largest rate so far, relative to the largest value: nearly half a period
MONOTONE_RATIO = 2.0  # times another rate, or less: about as large


@kernel
def finite_size(x: Number) -> Any:
    """The size of a signal, of which fractions are roundoff: 0 of NaN, and of an infinite one, such as before an event
    whose time it reads."""
    return where(absolute(x) < HUGE, absolute(x), 0.0)


@kernel
def by_rates(low: Number, high: Number, change: Number) -> Any:
    """low, high: the smaller and the larger rate at the ends, times the length of the step; change: from end to end.
    The cubic through the ends goes beyond them by 4/27 of its rates."""
    return maximum(high, -low) + (high - low) + absolute(change)


@kernel
def by_changes(change: Number, before: Number) -> Any:
    """change, before: by how much it changed in this step and in the one before."""
    return CHANGE_SAFETY * (absolute(change) + absolute(before))
