"""What contacts are composed of: where two bodies come closest, and how fast they slide there.

Plain functions of motions (`lienumba.mechanics.mechanism.kinematics`): on numbers, on jets, on symbols.
"""

from typing import Any, NamedTuple

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Motion
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import sqrt, where

POLE = 1e-12  # the square of how near to the far pole of a hemisphere its tangents are given up
SQUARE_FLOOR = 1e-200  # below the square of every length that matters: zero divided by it is zero


class Place(NamedTuple):
    """gap: between the two surfaces (m), below 0 where they overlap; point: of the first body that is closest to the
    second (m, global frame); normal: from the second body to the first, in the frame of the second."""

    gap: Any
    point: so3.Vec3
    normal: so3.Vec3


def height(a: Motion, p: Vector, b: Motion, q: Vector, normal: so3.Vec3) -> tuple[Number, so3.Vec3, so3.Vec3]:
    """Of a point above a plane of the second body (m), the point, and the normal, both in the global frame."""
    point, up = a.point(p), so3.rotate(b.R, normal)
    return so3.dot(up, so3.subtract(point, b.point(q))), point, up


def unit(v: so3.Vec3) -> tuple[so3.Vec3, Number]:
    """A vector by its length, and this; zero has no direction."""
    length: Number = sqrt(so3.dot(v, v) + SQUARE_FLOOR)
    return so3.scale(1.0 / length, v), length


def hemisphere(n: so3.Vec3) -> Number:
    """By which tangents are chosen: 1 or -1."""
    return where(n[2] < 0.0, -1.0, 1.0)


def tangents(n: so3.Vec3, of: Number | None = None) -> tuple[so3.Vec3, so3.Vec3]:
    """Two unit vectors across a unit vector and each other (Duff et al. 2017): x and y for the z axis. They jump where
    the hemisphere changes; with that of another place they go on, up to its far pole."""
    x, y, z = n
    sign = hemisphere(n) if of is None else of
    away = sign + z
    a = -1.0 / (away if of is None else where(away * away < POLE, sign, away))
    b = x * y * a
    return (1.0 + sign * (x * x * a), sign * b, -(sign * x)), (b, sign + y * y * a, -y)


def carried(n: so3.Vec3, kept: Vector) -> Vector:
    """Along the tangents, a direction that was kept along those of a hemisphere: (d1, d2, hemisphere), which is 0 where
    nothing has been kept yet."""
    first, second = tangents(n, where(kept[2] == 0.0, hemisphere(n), kept[2]))
    d = so3.axpy(kept[0], first, so3.scale(kept[1], second))
    return tuple(so3.dot(t, d) for t in tangents(n))


def slip(place: Place, a: Motion, b: Motion) -> Vector:
    """The velocity (m/s) of the first body against the second where they touch, along the tangents."""
    apart = so3.subtract(_velocity(a, place.point), _velocity(b, place.point))
    return _across(place, b, apart)


def slid(place: Place, now: tuple[Motion, Motion], a: Motion, b: Motion) -> Vector:
    """Two coordinates (m) with these rates, to first order from where the bodies are now: 0 there. place: now."""
    held = (so3.rotate_back(m.R, so3.subtract(place.point, m.r)) for m in now)
    first, second = (m.point(p) for m, p in zip((a, b), held, strict=True))
    return _across(place, now[1], so3.subtract(first, second))


def at_rest(m: Motion) -> Motion:
    """Where a body is, whatever moves it."""
    return Motion(tuple(lift(x).a for x in m.r), tuple(lift(x).a for x in m.R))


def _across(place: Place, b: Motion, v: so3.Vec3) -> Vector:
    seen = so3.rotate_back(b.R, v)
    return tuple(so3.dot(t, seen) for t in tangents(place.normal))


def _velocity(m: Motion, point: so3.Vec3) -> so3.Vec3:
    """Of what a body has at a point (m/s, global frame)."""
    arm = so3.rotate_back(m.R, so3.subtract(point, m.r))
    return so3.add(m.v, so3.rotate(m.R, so3.cross(m.w, arm)))
