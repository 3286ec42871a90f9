"""The state-space group S = (R^3 x SO(3)) x (R^3 x R^3) of one rigid body (Terze et al. 2015, section 2).

An element x = (r, R, v, w) is a tuple of 18 numbers: mass centre r (global), rotation R (body to global, row
major), velocity v (global), angular velocity w (body frame). An element z of its algebra is a tuple of 12.
"""

from typing import Any

from lienumba.groups import so3
from lienumba.numerics.operations import kernel

ELEMENT, ALGEBRA = 18, 12
State = tuple[Any, ...]
Algebra = tuple[Any, ...]

IDENTITY: State = (0.0, 0.0, 0.0, *so3.IDENTITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def product(x: State, y: State) -> State:
    """(a, b, c, d) . (e, f, g, h) = (a + e, b f, c + g, d + h) (Terze et al. 2015, section 2, a).

    Parameters
    ----------
    x, y : State
        Elements of S.

    Returns
    -------
    State
        x y.
    """
    return (
        so3.add(x[0:3], y[0:3]) + so3.multiply(x[3:12], y[3:12])
        + so3.add(x[12:15], y[12:15]) + so3.add(x[15:18], y[15:18])
    )  # fmt: skip


@kernel
def inverse(x: State) -> State:
    """(-r, R^T, -v, -w).

    Parameters
    ----------
    x : State
        An element of S.

    Returns
    -------
    State
        Its inverse.
    """
    moved, rate = so3.scale(-1.0, x[0:3]), so3.scale(-1.0, x[12:15])
    return moved + so3.transpose(x[3:12]) + rate + so3.scale(-1.0, x[15:18])


@kernel
def exp(z: Algebra) -> State:
    """exp(u, w, c, d) = (u, expm hat(w), c, d) (Terze et al. 2015, section 2, d).

    Parameters
    ----------
    z : Algebra
        An element of the algebra.

    Returns
    -------
    State
        exp(z).
    """
    return z[0:3] + so3.exp(z[3:6]) + z[6:12]


@kernel
def log(x: State) -> Algebra:
    """The inverse of exp.

    Parameters
    ----------
    x : State
        An element of S.

    Returns
    -------
    Algebra
        z with exp(z) = x and a rotation of at most pi.
    """
    return x[0:3] + so3.log(x[3:12]) + x[12:18]


@kernel
def bracket(y: Algebra, z: Algebra) -> Algebra:
    """[y, z] = (0, w_y x w_z, 0, 0) (Terze et al. 2015, section 2, e).

    Parameters
    ----------
    y, z : Algebra
        Elements of the algebra.

    Returns
    -------
    Algebra
        Their bracket.
    """
    return (0.0, 0.0, 0.0) + so3.cross(y[3:6], z[3:6]) + (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def dexp(z: Algebra, y: Algebra) -> Algebra:
    """dexp of SO(3) in the rotation, the identity elsewhere.

    Parameters
    ----------
    z, y : Algebra
        Elements of the algebra.

    Returns
    -------
    Algebra
        dexp_z(y).
    """
    return y[0:3] + so3.dexp(z[3:6], y[3:6]) + y[6:12]


@kernel
def dexpinv(z: Algebra, y: Algebra) -> Algebra:
    """dexp^{-1} of SO(3) in the rotation, the identity elsewhere (Terze et al. 2015, A.7 and A.9).

    Parameters
    ----------
    z, y : Algebra
        Elements of the algebra.

    Returns
    -------
    Algebra
        dexp_z^{-1}(y).
    """
    return y[0:3] + so3.dexpinv(z[3:6], y[3:6]) + y[6:12]


@kernel
def dexpinv_truncated(z: Algebra, y: Algebra, order: int) -> Algebra:
    """dexp_z^{-1}(y), its series cut.

    Parameters
    ----------
    z, y : Algebra
        Elements of the algebra.
    order : int
        The last power of ad, from 0 to 10.

    Returns
    -------
    Algebra
        The truncated series.
    """
    return y[0:3] + so3.dexpinv_truncated(z[3:6], y[3:6], order) + y[6:12]
