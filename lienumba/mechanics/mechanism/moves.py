"""What a joint leaves free, as moves of a child's frame against a frame of its parent, one behind the other.

A move has a state: numbers that say where the frame is, and its rates. A step begins at a state with the coordinates
u = 0 and integrates u: as many numbers for the place as the move has freedoms, and as many for the rates.
Frames: a move starts from axes fixed in the parent, z along the axis of a turn or slide.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, NamedTuple

from lienumba.groups import so3
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import at_most, cos, sin, sqrt

ZERO = (0.0, 0.0, 0.0)
CYCLE = (0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)  # its columns are y, z, x: the new z is the old x


class Relative(NamedTuple):
    """The motion of a frame relative to another: E (its axes, as columns along those of the other) and d (its origin,
    along these); w, its angular velocity (own axes), and the rate of d (axes of the other)."""

    E: Any
    d: Any
    w: Any
    rate: Any


class Kind(NamedTuple):
    """Numbers of u of one kind: 0 to 3 for positions, rotations, velocities, angular velocities; where they are in u;
    and where in the state is what they change, but for rotations."""

    kind: int
    place: slice
    part: slice | None


@dataclass(frozen=True)
class Move:
    """cycled: the axes are exchanged before it, so that its z is the x of before. `places`: numbers of the place;
    `freedoms`: rates, and how many numbers the place has in u."""

    cycled: bool = False
    places: int = 1
    freedoms: int = 1
    letters: str = "m"  # of the coordinates that its place is made of, "m" for a length, "r" for an angle
    spins: bool = False  # whether the child's axes may be turned about z at will
    turns: bool = False  # whether it turns at all
    turning: range | None = None  # where in the state the rotation is, of which u has fewer numbers

    @property
    def state(self) -> int:
        return self.places + self.freedoms

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        """The state that leads to this relative placement, and what is left for the moves behind it."""
        raise NotImplementedError

    def relative(self, z: Vector, pitch: Number) -> Relative:
        """Where the state puts the frame."""
        raise NotImplementedError

    def place(self, q: Vector) -> Vector:
        """The place of these coordinates: of an angle (rad), a displacement (m), both of a screw, a rotation vector."""
        return q

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        """S: of each rate, what it gives to the velocity and angular velocity (own axes), where that is not zero."""
        raise NotImplementedError

    def gain(self, kind: str, pitch: Number) -> Number | None:
        """How fast the joint's coordinate of a kind grows with the rate, up to the sign; None if it does not."""
        return None

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        """The state at the coordinates u about z."""
        raise NotImplementedError

    def settled(self, z: Vector) -> Vector:
        """The state with its rotation orthogonal again after roundoff."""
        return z

    def slope(self, u: Vector, z: Vector, a: Vector, terms: int | None) -> Vector:
        """u' where the state is z and the rates change by a (along S)."""
        return self.pulled(u, (*z[self.places :], *a), terms)

    def pulled(self, u: Vector, slope: Vector, terms: int | None) -> Vector:
        """u' at u, from the slope at 0 about the state that u leads to. terms: of the series of dexpinv, or None."""
        return slope

    def rates(self, z: Vector, a: Vector, pitch: Number) -> Vector:
        """How the numbers of the state z change, where its rates change by a (along S)."""
        return (*z[self.places :], *a)

    def composed(self, u: Vector, w: Vector) -> Vector:
        """The coordinates of a move by u, and from there by w."""
        return tuple(a + b for a, b in zip(u, w, strict=True))

    def tangent(self, z: Vector, x: Vector) -> Vector:
        """The coordinates of a small displacement along S."""
        return x

    def along(self, z: Vector, a: Vector) -> Vector:
        """What the rates change by along S, where those of the state change by a."""
        return a

    def turned(self, u: Vector) -> Number:
        """The squared rotation by u (rad^2)."""
        return 0.0

    def kinds(self) -> tuple[Kind, ...]:
        """What u is made of."""
        raise NotImplementedError


@dataclass(frozen=True)
class Turn(Move):
    """About z. Its place is the cosine and the sine of the angle, so that no count of turns costs accuracy."""

    places: int = 2
    letters: str = "r"
    spins: bool = True
    turns: bool = True
    turning: range | None = range(0, 2)

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        E = found.E
        c, s = (E[0] + E[4], E[3] - E[1]) if last else (E[2], E[5])  # the next axis is across this one, along x
        n = sqrt(c * c + s * s)
        c, s = c / n, s / n
        back = about_z(c, -s)
        w = found.w  # along the parent's axes until the last move has been read
        left = Relative(so3.multiply(back, E), so3.rotate(back, found.d), so3.rotate(back, w), found.rate)
        return (c, s, w[2]), left

    def relative(self, z: Vector, pitch: Number) -> Relative:
        return Relative(about_z(z[0], z[1]), ZERO, (0.0, 0.0, z[-1]), ZERO)

    def place(self, q: Vector) -> Vector:
        return (cos(q[0]), sin(q[0]), *q[1:])

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        return ({5: 1.0},)

    def gain(self, kind: str, pitch: Number) -> Number | None:
        return 1.0 if kind == "angle" else None

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        c, s = _turn(u[0])
        return (z[0] * c - z[1] * s, z[1] * c + z[0] * s, z[-1] + u[1])

    def settled(self, z: Vector) -> Vector:
        n = 1.5 - 0.5 * (z[0] * z[0] + z[1] * z[1])
        return (n * z[0], n * z[1], *z[2:])

    def rates(self, z: Vector, a: Vector, pitch: Number) -> Vector:
        return (-(z[1] * z[-1]), z[0] * z[-1], *a)

    def turned(self, u: Vector) -> Number:
        return u[0] * u[0]

    def kinds(self) -> tuple[Kind, ...]:
        return (Kind(1, slice(0, 1), None), Kind(3, slice(1, 2), slice(-1, None)))


@dataclass(frozen=True)
class Slide(Move):
    """Along z (m)."""

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        return (found.d[2], found.rate[2]), found

    def relative(self, z: Vector, pitch: Number) -> Relative:
        return Relative(so3.IDENTITY, (0.0, 0.0, z[0]), ZERO, (0.0, 0.0, z[1]))

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        return ({2: 1.0},)

    def gain(self, kind: str, pitch: Number) -> Number | None:
        return 1.0 if kind == "displacement" else None

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        return (z[0] + u[0], z[1] + u[1])

    def kinds(self) -> tuple[Kind, ...]:
        return (Kind(0, slice(0, 1), slice(0, 1)), Kind(2, slice(1, 2), slice(1, 2)))


@dataclass(frozen=True)
class Wind(Turn):
    """A turn about z that slides along it by a pitch (m per turn)."""

    places: int = 3
    letters: str = "rm"

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        (c, s, rate), left = super().read(found, last, pitch)
        return (c, s, found.d[2], rate), left

    def relative(self, z: Vector, pitch: Number) -> Relative:
        along = (0.0, 0.0, pitch * (0.5 / pi) * z[-1])
        return Relative(about_z(z[0], z[1]), (0.0, 0.0, z[2]), (0.0, 0.0, z[-1]), along)

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        return ({5: 1.0, 2: pitch * (0.5 / pi)},)

    def gain(self, kind: str, pitch: Number) -> Number | None:
        return 1.0 if kind == "angle" else pitch * (0.5 / pi)

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        c, s, rate = super().moved((z[0], z[1], z[-1]), u, pitch)
        return (c, s, z[2] + pitch * (0.5 / pi) * u[0], rate)

    def rates(self, z: Vector, a: Vector, pitch: Number) -> Vector:
        c, s, _ = super().rates(z, a, pitch)
        return (c, s, pitch * (0.5 / pi) * z[-1], *a)


@dataclass(frozen=True)
class Ball(Move):
    """About any axis: the rotation matrix (own axes along the parent's), and the angular velocity (own axes)."""

    places: int = 9
    freedoms: int = 3
    letters: str = "rrr"
    turns: bool = True
    turning: range | None = range(0, 9)

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        return (*found.E, *so3.rotate_back(found.E, found.w)), found

    def relative(self, z: Vector, pitch: Number) -> Relative:
        return Relative(tuple(z[0:9]), ZERO, tuple(z[9:12]), ZERO)

    def place(self, q: Vector) -> Vector:
        return so3.exp(q)

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        return ({3: 1.0}, {4: 1.0}, {5: 1.0})

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        return (*so3.multiply(z[0:9], _exp(u[0:3])), *so3.add(z[9:12], u[3:6]))

    def pulled(self, u: Vector, slope: Vector, terms: int | None) -> Vector:
        return (*_coordinate_rates(u[0:3], slope[0:3], terms), *slope[3:6])

    def rates(self, z: Vector, a: Vector, pitch: Number) -> Vector:
        return (*so3.turning(z[0:9], z[9:12]), *a)

    def composed(self, u: Vector, w: Vector) -> Vector:
        return (*_behind(u[0:3], w[0:3]), *so3.add(u[3:6], w[3:6]))

    def turned(self, u: Vector) -> Number:
        return so3.dot(u[0:3], u[0:3])

    def kinds(self) -> tuple[Kind, ...]:
        return (Kind(1, slice(0, 3), None), Kind(3, slice(3, 6), slice(9, 12)))


@dataclass(frozen=True)
class Free(Move):
    """The move of a body that no joint holds: an element (r, R, v, w) of the state-space group of one body."""

    places: int = 12
    freedoms: int = 6
    turns: bool = True
    turning: range | None = range(3, 12)

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        return (*found.d, *found.E, *found.rate, *so3.rotate_back(found.E, found.w)), found

    def relative(self, z: Vector, pitch: Number) -> Relative:
        return Relative(tuple(z[3:12]), tuple(z[0:3]), tuple(z[15:18]), tuple(z[12:15]))

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        return tuple({i: 1.0} for i in range(6))

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        R = so3.multiply(z[3:12], _exp(u[3:6]))
        return (*so3.add(z[0:3], u[0:3]), *R, *so3.add(z[12:15], u[6:9]), *so3.add(z[15:18], u[9:12]))

    def slope(self, u: Vector, z: Vector, a: Vector, terms: int | None) -> Vector:
        return self.pulled(u, (*z[12:18], *so3.rotate(z[3:12], a[0:3]), *a[3:6]), terms)

    def pulled(self, u: Vector, slope: Vector, terms: int | None) -> Vector:
        return (*slope[0:3], *_coordinate_rates(u[3:6], slope[3:6], terms), *slope[6:12])

    def composed(self, u: Vector, w: Vector) -> Vector:
        moved = (*so3.add(u[0:3], w[0:3]), *_behind(u[3:6], w[3:6]))
        return (*moved, *so3.add(u[6:9], w[6:9]), *so3.add(u[9:12], w[9:12]))

    def rates(self, z: Vector, a: Vector, pitch: Number) -> Vector:
        return (*z[12:15], *so3.turning(z[3:12], z[15:18]), *so3.rotate(z[3:12], a[0:3]), *a[3:6])

    def tangent(self, z: Vector, x: Vector) -> Vector:
        return (*so3.rotate(z[3:12], x[0:3]), *x[3:6])

    def along(self, z: Vector, a: Vector) -> Vector:
        return (*so3.rotate_back(z[3:12], a[0:3]), *a[3:6])

    def turned(self, u: Vector) -> Number:
        return so3.dot(u[3:6], u[3:6])

    def kinds(self) -> tuple[Kind, ...]:
        velocities = Kind(2, slice(6, 9), slice(12, 15)), Kind(3, slice(9, 12), slice(15, 18))
        return (Kind(0, slice(0, 3), slice(0, 3)), Kind(1, slice(3, 6), None), *velocities)


@dataclass(frozen=True)
class Weld(Move):
    """Nothing moves."""

    places: int = 0
    freedoms: int = 0

    def read(self, found: Relative, last: bool, pitch: Number) -> tuple[Vector, Relative]:
        return (), found

    def relative(self, z: Vector, pitch: Number) -> Relative:
        return Relative(so3.IDENTITY, ZERO, ZERO, ZERO)

    def columns(self, pitch: Number) -> tuple[dict[int, Number], ...]:
        return ()

    def moved(self, z: Vector, u: Vector, pitch: Number) -> Vector:
        return ()

    def kinds(self) -> tuple[Kind, ...]:
        return ()


def cycled(found: Relative) -> Relative:
    """A relative motion along axes that are exchanged."""
    E = so3.multiply(so3.transpose(CYCLE), found.E)
    return Relative(E, *(so3.rotate_back(CYCLE, x) for x in (found.d, found.w, found.rate)))


def behind(first: Relative, second: Relative) -> Relative:
    """The relative motion of a third frame to the first one, where `second` is of the third to the second."""
    turning, d = so3.rotate(first.E, first.w), so3.rotate(first.E, second.d)
    rate = so3.add(first.rate, so3.add(so3.cross(turning, d), so3.rotate(first.E, second.rate)))
    w = so3.add(so3.rotate_back(second.E, first.w), second.w)
    return Relative(so3.multiply(first.E, second.E), so3.add(first.d, d), w, rate)


def about_z(c: Number, s: Number) -> Matrix:
    """The rotation about z with this cosine and sine."""
    return (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def about_x(c: Number, s: Number) -> Matrix:
    """The rotation about x."""
    return (1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)


def _turn(angle: Number) -> tuple[Number, Number]:
    """The cosine and the sine of an angle."""
    square = at_most(angle * angle, so3.LARGEST_STEP)
    c, s = so3.half_angle(square)
    return 1.0 - 0.5 * (square * (s * s)), angle * (s * c)


def _coordinate_rates(u: Vector, w: Vector, terms: int | None) -> Vector:
    """u' of a rotation vector where the rotation by it turns with w (Terze et al. 2015, A.4)."""
    minus = (-u[0], -u[1], -u[2])
    at_most(so3.dot(minus, minus), so3.LARGEST_STEP)
    return so3.dexpinv(minus, w) if terms is None else so3.dexpinv_truncated(minus, w, terms)


def _behind(u: Vector, w: Vector) -> Vector:
    """The rotation vector of a rotation by u, and from there by w."""
    return so3.log(so3.multiply(_exp(u), _exp(w)))


def _exp(u: Vector) -> Matrix:
    at_most(so3.dot(u, u), so3.LARGEST_STEP)
    return so3.exp(u)
