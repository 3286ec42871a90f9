"""The group SE(3) of rigid-body motions and its algebra se(3), as plain functions of numbers.

An element (r, R) is a tuple of 12 numbers, a point p goes to r + R p; an element (p, u) of the algebra, a twist, is a
tuple of 6: translation, rotation. se(3) is so(3) over the dual numbers u + eps p, eps**2 = 0. So every formula of so3
holds with the bracket of se(3), and each coefficient f(u.u) brings its derivative: f + 2 eps (u.p) f'.
"""

from typing import Any

from lienumba.groups import so3
from lienumba.numerics.number import Number
from lienumba.numerics.operations import kernel, where

ELEMENT, ALGEBRA = 12, 6
Motion = tuple[Any, ...]
Twist = tuple[Any, ...]

IDENTITY: Motion = (0.0, 0.0, 0.0, *so3.IDENTITY)


@kernel
def product(a: Motion, b: Motion) -> Motion:
    """(r, R) . (s, S) = (r + R s, R S).

    Parameters
    ----------
    a, b : Motion
        Elements of SE(3).

    Returns
    -------
    Motion
        a b.
    """
    return so3.add(a[0:3], so3.rotate(a[3:12], b[0:3])) + so3.multiply(a[3:12], b[3:12])


@kernel
def inverse(a: Motion) -> Motion:
    """(-R^T r, R^T).

    Parameters
    ----------
    a : Motion
        An element of SE(3).

    Returns
    -------
    Motion
        Its inverse.
    """
    return so3.scale(-1.0, so3.rotate_back(a[3:12], a[0:3])) + so3.transpose(a[3:12])


@kernel
def bracket(x: Twist, y: Twist) -> Twist:
    """[(p, u), (q, w)] = (u x q + p x w, u x w).

    Parameters
    ----------
    x, y : Twist
        Elements of se(3).

    Returns
    -------
    Twist
        Their bracket.
    """
    return so3.add(so3.cross(x[3:6], y[0:3]), so3.cross(x[0:3], y[3:6])) + so3.cross(x[3:6], y[3:6])


@kernel
def _plus(s: Number, a: Twist, b: Twist) -> Twist:
    """s a + b."""
    return so3.axpy(s, a[0:3], b[0:3]) + so3.axpy(s, a[3:6], b[3:6])


# ---------------------------------------------------------------- derivatives of the coefficients
@kernel
def _dexp_derivatives(x: Number) -> tuple[Any, Any]:
    """Of both coefficients of dexp by x = angle**2."""
    b, d = so3.dexp_coefficients(x)
    p = -9 / 2432902008176640000 + x * (10 / 1124000727777607680000)
    p = -7 / 20922789888000 + x * (8 / 6402373705728000 + x * p)
    p = -5 / 479001600 + x * (6 / 87178291200 + x * p)
    near_b = -1 / 24 + x * (2 / 720 + x * (-3 / 40320 + x * (4 / 3628800 + x * p)))
    p = -9 / 51090942171709440000 + x * (10 / 25852016738884976640000)
    p = -7 / 355687428096000 + x * (8 / 121645100408832000 + x * p)
    p = -5 / 6227020800 + x * (6 / 1307674368000 + x * p)
    near_d = -1 / 120 + x * (2 / 5040 + x * (-3 / 362880 + x * (4 / 39916800 + x * p)))
    small = x < 2.0
    half = 0.5 / where(small, 1.0, x)
    return where(small, near_b, half * (1.0 - x * d - 2.0 * b)), where(small, near_d, half * (b - 3.0 * d))


@kernel
def _dexpinv_derivative(x: Number) -> Any:
    """Of the coefficient of dexpinv by x = angle**2; infinite at angle = 2 pi."""
    c = so3.dexpinv_coefficient(x)
    p = 7 * 3617 / 10670622842880000 + x * (8 * 43867 / 5109094217170944000 + x * (9 * 174611 / 802857662698291200000))
    p = 4 / 47900160 + x * (5 * 691 / 1307674368000 + x * (6 / 74724249600 + x * p))
    near = 1 / 720 + x * (2 / 30240 + x * (3 / 1209600 + x * p))
    small = x < 1.0
    return where(small, near, (0.25 - 3.0 * c + x * (c * c)) * (0.5 / where(small, 1.0, x)))


# ---------------------------------------------------------------- exp, log, dexp
@kernel
def exp(z: Twist) -> Motion:
    """The screw motion (dexp_u(p), expm hat(u)) by a twist (p, u), at any angle.

    Parameters
    ----------
    z : Twist
        Translation in m, rotation in rad.

    Returns
    -------
    Motion
        exp(z).
    """
    return so3.dexp(z[3:6], z[0:3]) + so3.exp(z[3:6])


@kernel
def log(a: Motion) -> Twist:
    """The inverse of exp.

    Parameters
    ----------
    a : Motion
        An element of SE(3).

    Returns
    -------
    Twist
        z with exp(z) = a and a rotation of at most pi.
    """
    u = so3.log(a[3:12])
    return so3.dexpinv(u, a[0:3]) + u


@kernel
def dexp(z: Twist, y: Twist) -> Twist:
    """dexp_z(y) = sum_j ad_z^j y / (j+1)!.

    Parameters
    ----------
    z, y : Twist
        Elements of se(3).

    Returns
    -------
    Twist
        dexp_z(y).
    """
    x = so3.dot(z[3:6], z[3:6])
    b, d = so3.dexp_coefficients(x)
    db, dd = _dexp_derivatives(x)
    zy = bracket(z, y)
    zzy = bracket(z, zy)
    straight = _plus(d, zzy, _plus(b, zy, y))
    s = 2.0 * so3.dot(z[0:3], z[3:6])
    return so3.axpy(s * dd, zzy[3:6], so3.axpy(s * db, zy[3:6], straight[0:3])) + straight[3:6]


@kernel
def dexpinv(z: Twist, y: Twist) -> Twist:
    """dexp_z^{-1}(y) in closed form; singular where the angle is a multiple of 2 pi.

    Parameters
    ----------
    z, y : Twist
        Elements of se(3).

    Returns
    -------
    Twist
        dexp_z^{-1}(y).
    """
    x = so3.dot(z[3:6], z[3:6])
    zy = bracket(z, y)
    zzy = bracket(z, zy)
    straight = _plus(so3.dexpinv_coefficient(x), zzy, _plus(-0.5, zy, y))
    s = 2.0 * so3.dot(z[0:3], z[3:6])
    return so3.axpy(s * _dexpinv_derivative(x), zzy[3:6], straight[0:3]) + straight[3:6]


@kernel
def dexpinv_truncated(z: Twist, y: Twist, order: int) -> Twist:
    """sum_{j <= order} B_j/j! ad_z^j y.

    Parameters
    ----------
    z, y : Twist
        Elements of se(3).
    order : int
        The last j, from 0 to 10.

    Returns
    -------
    Twist
        The truncated series.
    """
    term, total = y, y
    for j in range(1, order + 1):
        term = bracket(z, term)
        total = _plus(so3.BERNOULLI_OVER_FACTORIAL[j], term, total)
    return total
