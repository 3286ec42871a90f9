"""Charts: how coordinates about an element of S move it, and how fast they change along its motion.

A step begins at x with the coordinates u = 0, integrates u' by a method for vector spaces, and ends at the element
that u then belongs to.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from lienumba.groups import se3, so3, state
from lienumba.groups.state import State
from lienumba.integrators.codes import LARGEST_STAGE
from lienumba.keys.literature import Reference
from lienumba.keys.registry import Registry
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import at_most

MUELLER = Reference(
    "mueller2014", "article", "Müller, Andreas and Terze, Zdravko", 2014,
    "The significance of the configuration space Lie group for the constraint satisfaction in numerical time "
    "integration of multibody systems",
    "Mechanism and Machine Theory", "82:173--202",
)  # fmt: skip

JOINT = "joint"  # the coordinates of all joints together, of which no body has its own
Coordinates = Vector
Field = Vector  # F (Terze et al. 2015, eq. 15) for one element: v (global), w (body frame), v', w'


class Chart(Protocol):
    """`size`: the coordinates of an element; the last six are those of its velocities. `plain`: their slopes are v'
    and w' as they are."""

    @property
    def size(self) -> int: ...

    @property
    def plain(self) -> bool: ...

    @property
    def orthogonal(self) -> bool:
        """Whether R R^T stays I but for rounding, so that equations may be written along the axes of bodies."""
        return True

    def moved(self, x: State, u: Coordinates) -> State:
        """The element at u about x."""

    def slope(self, x: State, u: Coordinates, at: State, f: Field) -> Coordinates:
        """u' where x is moved to `at` by u, and F is f there."""

    def accelerations(self, x: State, rates: Vector) -> Vector:
        """v' and w' of x where the coordinates of its velocities change by these, six each."""
        return rates

    def along(self, x: State, load: Vector) -> Vector:
        """A force (global) and a torque (body frame) on x, along those coordinates."""
        return load

    def composed(self, u: Coordinates, w: Coordinates) -> Coordinates:
        """Those of the element that is moved by u, and from there by w."""

    def rotation(self, u: Coordinates) -> Number:
        """The squared rotation by u (rad^2), which the driver keeps below LARGEST_STAGE."""

    def settled(self, x: State) -> State:
        """The element at the end of a step, where rounding leads off it."""
        return x


class Exponential(Chart, Protocol):
    """A chart of a group, where the slope at 0 says all of F."""

    def back(self, u: Coordinates, slope: Coordinates) -> Coordinates:
        """u' at u about x, from the slope at 0 about the element that u leads to."""


# Of each body: chart(terms), terms of the series of dexpinv. `words`: what a citation calls it, with [@key] for each of
# its `references`; `note`: what the key's description says behind the name.
GROUPS: Registry[Any] = Registry("group", lambda chart: chart.__name__)


@GROUPS.add
@dataclass(frozen=True)
class R3xSO3(Exponential):
    """The paper's (Terze et al. 2015, eqs. 17 to 19): x exp(u) on (R^3 x SO(3)) x R^6, so that u' = dexpinv_{-u}(F),
    its series cut behind ad^terms or in closed form for None."""

    terms: int | None
    size: int = state.ALGEBRA
    plain: bool = True
    words: ClassVar[str] = "R^3 x SO(3)"
    note: ClassVar[str] = ""
    references: ClassVar[tuple[Reference, ...]] = ()

    def moved(self, x: State, u: Coordinates) -> State:
        return state.product(x, state.exp(_promised(u)))

    def slope(self, x: State, u: Coordinates, at: State, f: Field) -> Coordinates:
        minus = tuple(-c for c in _promised(u))
        return state.dexpinv(minus, f) if self.terms is None else state.dexpinv_truncated(minus, f, self.terms)

    def back(self, u: Coordinates, slope: Coordinates) -> Coordinates:
        return self.slope((), u, (), slope)

    def composed(self, u: Coordinates, w: Coordinates) -> Coordinates:
        return state.log(state.product(state.exp(_promised(u)), state.exp(_promised(w))))

    def rotation(self, u: Coordinates) -> Number:
        return so3.dot(u[3:6], u[3:6])


@GROUPS.add
@dataclass(frozen=True)
class SE3(Exponential):
    """x exp(u) on SE(3) x R^6, where the velocities are the body's twist (R^T v, w): it stays in every subalgebra to
    which joints confine it, as the motion stays in the subgroup (Mueller, Terze 2014)."""

    terms: int | None
    size: int = state.ALGEBRA
    plain: bool = False
    words: ClassVar[str] = "SE(3) [@mueller2014]"
    note: ClassVar[str] = "which keeps joints to ground without projection"
    references: ClassVar[tuple[Reference, ...]] = (MUELLER,)

    def moved(self, x: State, u: Coordinates) -> State:
        g = se3.product(x[0:12], se3.exp(_promised(u)[0:6]))
        V = so3.add(_turned_back(x[3:12], x[12:15]), u[6:9])
        return g + so3.rotate(g[3:12], V) + so3.add(x[15:18], u[9:12])

    def slope(self, x: State, u: Coordinates, at: State, f: Field) -> Coordinates:
        """V' = R^T v' - w x V."""
        R, w = at[3:12], f[3:6]
        V = _turned_back(R, f[0:3])
        return self._pulled(u, V + w) + so3.subtract(_turned_back(R, f[6:9]), so3.cross(w, V)) + f[9:12]

    def accelerations(self, x: State, rates: Vector) -> Vector:
        """v' = R (V' + w x V)."""
        turning = so3.cross(x[15:18], _turned_back(x[3:12], x[12:15]))
        return so3.rotate(x[3:12], so3.add(rates[0:3], turning)) + tuple(rates[3:6])

    def along(self, x: State, load: Vector) -> Vector:
        return so3.rotate_back(x[3:12], tuple(load[0:3])) + tuple(load[3:6])

    def back(self, u: Coordinates, slope: Coordinates) -> Coordinates:
        return self._pulled(u, slope[0:6]) + slope[6:12]

    def _pulled(self, u: Coordinates, twist: Vector) -> Vector:
        minus = tuple(-c for c in _promised(u)[0:6])
        return se3.dexpinv(minus, twist) if self.terms is None else se3.dexpinv_truncated(minus, twist, self.terms)

    def composed(self, u: Coordinates, w: Coordinates) -> Coordinates:
        moving = se3.log(se3.product(se3.exp(_promised(u)[0:6]), se3.exp(_promised(w)[0:6])))
        return moving + so3.add(u[6:9], w[6:9]) + so3.add(u[9:12], w[9:12])

    def rotation(self, u: Coordinates) -> Number:
        return so3.dot(u[3:6], u[3:6])


def _turned_back(R: Matrix, a: Vector) -> Vector:
    """The inverse of R times a, R orthogonal up to rounding: with R^T a alone, a velocity that is turned there and back
    in every step would grow by what R R^T lacks of I."""
    b = so3.rotate_back(R, a)
    return so3.add(b, so3.rotate_back(R, so3.subtract(a, so3.rotate(R, b))))


def _promised(u: Coordinates) -> Coordinates:
    """u, of whose squared rotation whoever compares it may know that the driver keeps it below LARGEST_STAGE."""
    at_most(so3.dot(u[3:6], u[3:6]), LARGEST_STAGE)
    return u
