"""Charts: how coordinates about an element of S move it, and how fast they change along its motion.

A step begins at x with the coordinates u = 0, integrates u' by a method for vector spaces, and ends at the element
that u then belongs to.
"""

from dataclasses import dataclass
from typing import Any, Protocol

from lienumba.groups import so3, state
from lienumba.operations import at_most

LARGEST_STAGE = 35.0  # |u|^2 (rad^2) of a stage's rotation: dexpinv ends at 2 pi, long before a step is this coarse

State = tuple[Any, ...]
Coordinates = tuple[Any, ...]
Field = tuple[Any, ...]  # F of eq. (15) for one element: v (global), w (body frame), v', w'


class Chart(Protocol):
    """`size`: the coordinates of an element; behind all others stand those of its velocities, six."""

    @property
    def size(self) -> int: ...

    def moved(self, x: State, u: Coordinates) -> State:
        """The element at u about x."""

    def slope(self, x: State, u: Coordinates, at: State, f: Field) -> Coordinates:
        """u' where x is moved to `at` by u, and F is f there."""

    def back(self, u: Coordinates, slope: Coordinates) -> Coordinates:
        """u' at u about x, from the slope at 0 about the element that u leads to."""

    def rotation(self, u: Coordinates) -> Any:
        """The squared rotation by u (rad^2), which the driver keeps below LARGEST_STAGE."""


@dataclass(frozen=True)
class R3xSO3:
    """The paper's: x exp(u) on (R^3 x SO(3)) x R^6, so that u' = dexpinv_{-u}(F), its series cut behind ad^terms or in
    closed form for None."""

    terms: int | None
    size: int = state.ALGEBRA

    def moved(self, x: State, u: Coordinates) -> State:
        return state.product(x, state.exp(u))

    def slope(self, x: State, u: Coordinates, at: State, f: Field) -> Coordinates:
        minus = tuple(-c for c in u)
        return state.dexpinv(minus, f) if self.terms is None else state.dexpinv_truncated(minus, f, self.terms)

    def back(self, u: Coordinates, slope: Coordinates) -> Coordinates:
        return self.slope((), u, (), slope)

    def rotation(self, u: Coordinates) -> Any:
        return promised(u[3:6])


def promised(u: Any) -> Any:
    """The square of a rotation vector (rad^2), which the driver keeps below LARGEST_STAGE."""
    return at_most(so3.dot(u, u), LARGEST_STAGE)
