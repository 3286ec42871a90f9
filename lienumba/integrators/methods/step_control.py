"""How long a step may be: the error of an embedded pair, measured in the algebra, and the controller of step sizes.

Hairer, Norsett and Wanner (1993), sections II.4 and II.10; Gustafsson, ACM Trans. Math. Softw. 17 (1991).
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass

from lienumba.groups.state import State
from lienumba.integrators.codes import HUGE
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import absolute, exp, log, maximum, minimum, sqrt, where

LOG_SAFETY = -0.10536051565782628  # of 0.9
LEAST, MOST = 0.2, 6.0  # factors between two steps
SMALLEST, LARGEST = 1e-10, 1e10  # errors beyond which a factor says no more
P, I = 0.4, 0.7  # noqa: E741  # gains, over the order of the error of one step


@dataclass(frozen=True)
class Tolerance:
    """Of the error of one step: relative, and absolute by kind (m, rad, m/s, rad/s, and that of states of laws and of
    the work, in J)."""

    relative: float
    position: float
    rotation: float
    velocity: float
    angular_velocity: float
    state: float

    @property
    def numbers(self) -> tuple[float, ...]:
        return astuple(self)


def error_square(estimates: Sequence[Vector], x: State, y: State, tolerance: Vector) -> Number:
    """The squared error of one body in a step from x to y, as a fraction of what is allowed: that of its worst kind.

    estimates: one or two (elements of the algebra, the same rows as in the body's slopes); tolerance: the numbers of a
    `Tolerance`. Positions and velocities are measured by their length, rotations by their angle.
    """
    places = (slice(0, 3), slice(3, -6), slice(-6, -3), slice(-3, None))
    zero: Number = 0.0
    worst = zero
    for kind, place, part in zip(range(4), places, (slice(0, 3), None, slice(12, 15), slice(15, 18)), strict=True):
        sizes = () if part is None else (x[part], y[part])
        worst = maximum(kind_error_square([z[place] for z in estimates], kind, sizes, tolerance), worst)
    return worst


def kind_error_square(estimates: Sequence[Vector], kind: int, sizes: Sequence[Vector], tolerance: Vector) -> Number:
    """The same of numbers of one kind (0 to 3: see `Tolerance`). sizes: before and after the step, what the relative
    tolerance counts from; none for rotations."""
    zero: Number = 0.0
    allowed = tolerance[1 + kind]
    if sizes:
        before, after = (sum((c * c for c in x), start=zero) for x in sizes)
        allowed = allowed + tolerance[0] * sqrt(maximum(before, after))
    return joined(tuple(sum((c * c for c in z), start=zero) / (allowed * allowed) for z in estimates))


def state_error_square(estimates: Vector, x: Number, y: Number, tolerance: Vector) -> Number:
    """The same of one state of a law: numbers instead of rows."""
    allowed = tolerance[-1] + tolerance[0] * maximum(absolute(x), absolute(y))
    return joined(tuple(z * z / (allowed * allowed) for z in estimates))


def work_error_square(estimates: Vector, x: Number, y: Number, kinetic: Number, tolerance: Vector) -> Number:
    """The same of the work (J) before and after the step, with the kinetic energy (J) behind it: what the relative
    tolerance allows of all velocities is twice as much of that."""
    allowed = tolerance[-1] + tolerance[0] * (2.0 * kinetic + maximum(absolute(x), absolute(y)))
    return joined(tuple(z * z / (allowed * allowed) for z in estimates))


def worst(squares: Sequence[Number]) -> Number:
    """The largest; infinite if one is not finite."""
    largest, total = squares[0], squares[0]
    for square in squares[1:]:
        largest, total = maximum(square, largest), total + square
    return where(total < HUGE, largest, HUGE)


def joined(squares: Vector) -> Number:
    """One estimate from two of different order (Hairer, Norsett and Wanner, eq. II.10.17)."""
    if len(squares) == 1:
        return squares[0]
    fifth, third = squares
    below = fifth + 0.01 * third
    return where(below > 0.0, fifth * fifth / where(below > 0.0, below, 1.0), below)


def factor(square: Number, memory: Number, order: int) -> tuple[Number, Number]:
    """By how much the next step is longer if this one is accepted, or the next trial shorter if it is not, and what to
    remember.

    square: of the error, at most 1 where a step is accepted, NaN if there is none; memory: of the last accepted step, 0
    at the start; order: of the error of one step.
    """
    accepted = square <= 1.0
    within = where(square < LARGEST * LARGEST, maximum(square, SMALLEST * SMALLEST), LARGEST * LARGEST)
    size = 0.5 * log(within)
    grown = LOG_SAFETY - (I / order) * size + (P / order) * memory
    scale = exp(where(accepted, grown, LOG_SAFETY - size / order))
    return maximum(minimum(scale, where(accepted, MOST, 1.0)), LEAST), size
