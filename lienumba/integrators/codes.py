"""How a step says whether it is good."""

from collections.abc import Iterable
from math import pi

from lienumba.groups.so3 import LARGEST_STEP
from lienumba.numerics.number import Condition, Number
from lienumba.numerics.operations import kernel, where

# What a kernel says of a run it could not advance; 0 is good.
NON_FINITE = 1.0
NOT_CONVERGED = 2.0
SINGULAR = 3.0
ROTATION = 4.0
RESELECT = 7.0  # no failure: the run needs other rows of C, which this program does not have
TOO_SHORT = 8.0  # said by a driver: the tolerance asks for a step below the shortest
STOPPED = 9.0  # no failure: an event
NOT_CLOSED = 10.0  # said by a driver: joints that were to close are apart
CHATTERING = 11.0  # changes without end
PARADOX = 12.0  # friction leaves no acceleration that fits
UNSOLVED = 13.0  # impulses of contacts were not found
UNSETTLED = 14.0  # the equations of implicit stages were not solved
PUSHED = 17.0  # said by a driver: friction gave energy
CONTRADICTS = 18.0  # what holds at once asks for different motions
VIOLATED = 19.0  # said by a driver: a contact pulled, overlapped, or held by more than its friction

# What a change is; those up to SET are told of the event that made them, the others of the switch.
LOCKED, RELEASED, ENGAGED, SET, IMPACT, CLOSED, OPENED, STUCK, SLID, KINDS = range(10)

HUGE = 1e300  # a sum of squares below this is finite
LARGEST_STAGE = LARGEST_STEP  # |u|^2 (rad^2) of a stage's rotation
QUARTER, SWING = 0.5 * pi, 1.0  # rad: see `strict`


def strict(rotation: Number, counts: bool, swings: bool) -> Number:
    """A squared rotation of a body in a step (rad^2), made so much larger where that may be less that the limit is
    another one. counts: the turns of a joint; a quarter of a turn then keeps two bodies from turning by half a turn
    relative to each other. swings: gaps with the bodies; by so little that none closes and opens unseen."""
    most = SWING if swings else QUARTER
    return rotation * (LARGEST_STAGE / most**2) if counts or swings else rotation


def finite(rows: Iterable[Number]) -> Condition:
    """Whether the sum of squares is an ordinary number: false for NaN and for infinities."""
    total: Number = 0.0
    for row in rows:
        total = total + row * row
    return total < HUGE


@kernel
def verdict(rotation: Number, square: Number, first: Number, every: Number) -> Number:
    """The code of a step, from its largest squared rotation, its sum of squares, and whether the KKT of its first stage
    and of every stage was regular. Overflow makes later stages singular: there it is the state that is not finite."""
    code = where(every > 0.0, 0.0, SINGULAR)
    code = where(square < HUGE, code, NON_FINITE)
    code = where(first > 0.0, code, SINGULAR)
    return where(rotation >= LARGEST_STAGE, ROTATION, code)


# Kinds of equilibria.
FOUND, NONE_FOUND, UNSTABLE = range(3)
EQUILIBRIA = ("found", "none_found", "unstable")
