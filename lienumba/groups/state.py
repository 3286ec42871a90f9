"""The state-space group S = (R^3 x SO(3)) x (R^3 x R^3) of one rigid body (Terze et al. 2015, section 2).

An element x = (r, R, v, w) is a tuple of 18 numbers: mass centre r (global), rotation R (body to global, row
major), velocity v (global), angular velocity w (body frame). An element z of its algebra is a tuple of 12.
"""

from typing import Any

from lienumba.groups import so3
from lienumba.numerics.number import Vector
from lienumba.numerics.operations import kernel

ELEMENT, ALGEBRA = 18, 12
State = tuple[Any, ...]
Algebra = tuple[Any, ...]

IDENTITY: State = (0.0, 0.0, 0.0, *so3.IDENTITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def product(x: Vector, y: Vector) -> State:
    """(a, b, c, d) . (e, f, g, h) = (a + e, b f, c + g, d + h)."""
    return (
        so3.add(x[0:3], y[0:3]) + so3.multiply(x[3:12], y[3:12])
        + so3.add(x[12:15], y[12:15]) + so3.add(x[15:18], y[15:18])
    )  # fmt: skip


@kernel
def inverse(x: Vector) -> State:
    """(-r, R^T, -v, -w)."""
    moved, rate = so3.scale(-1.0, x[0:3]), so3.scale(-1.0, x[12:15])
    return moved + so3.transpose(x[3:12]) + rate + so3.scale(-1.0, x[15:18])


@kernel
def exp(z: Vector) -> State:
    """exp(u, w, c, d) = (u, expm hat(w), c, d)."""
    return z[0:3] + so3.exp(z[3:6]) + z[6:12]


@kernel
def log(x: Vector) -> Algebra:
    """The z with exp(z) = x and a rotation of at most pi."""
    return x[0:3] + so3.log(x[3:12]) + x[12:18]


@kernel
def bracket(y: Vector, z: Vector) -> Algebra:
    """[y, z] = (0, w_y x w_z, 0, 0)."""
    return (0.0, 0.0, 0.0) + so3.cross(y[3:6], z[3:6]) + (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def dexp(z: Vector, y: Vector) -> Algebra:
    """dexp_z(y): dexp of SO(3) in the rotation, y itself elsewhere."""
    return y[0:3] + so3.dexp(z[3:6], y[3:6]) + y[6:12]


@kernel
def dexpinv(z: Vector, y: Vector) -> Algebra:
    """dexp_z^{-1}(y): that of SO(3) in the rotation, y itself elsewhere."""
    return y[0:3] + so3.dexpinv(z[3:6], y[3:6]) + y[6:12]


@kernel
def dexpinv_truncated(z: Vector, y: Vector, order: int) -> Algebra:
    """dexp_z^{-1}(y), its series cut behind ad^order."""
    return y[0:3] + so3.dexpinv_truncated(z[3:6], y[3:6], order) + y[6:12]
