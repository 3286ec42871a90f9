"""The rotation group SO(3) and its algebra so(3), as plain functions of numbers.

Vectors are 3-tuples, matrices 9-tuples (row major), quaternions 4-tuples (w, x, y, z). x = u.u = angle**2 is the
variable of every coefficient: each is an entire function of x, so there is no special case at u = 0, and
exp(0) = I exactly. Closed forms: Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods (2000), appendix B.
"""

from typing import Any

from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import alike, atan2, cos, kernel, sin, sqrt, where

# What comes out is of the kind of numbers that went in, which no type checker is told.
Vec3 = tuple[Any, Any, Any]
Matrix3 = tuple[Any, ...]
Quaternion = tuple[Any, Any, Any, Any]

IDENTITY: Matrix3 = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
SERIES_BOUND = 36.0  # the polynomials of half_angle hold for angle**2 below this
LARGEST_STEP = 35.0  # rad^2, what whoever integrates promises: dexpinv ends at 2 pi, long before a step is this coarse
BERNOULLI_OVER_FACTORIAL = (1.0, -1 / 2, 1 / 12, 0.0, -1 / 720, 0.0, 1 / 30240, 0.0, -1 / 1209600, 0.0, 1 / 47900160)


# ---------------------------------------------------------------- vectors and matrices
@kernel
def dot(a: Vector, b: Vector) -> Any:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vec3:
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def add(a: Vector, b: Vector) -> Vec3:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def subtract(a: Vector, b: Vector) -> Vec3:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(s: Number, a: Vector) -> Vec3:
    """s a."""
    return (s * a[0], s * a[1], s * a[2])


@kernel
def axpy(s: Number, a: Vector, b: Vector) -> Vec3:
    """s a + b."""
    return (b[0] + s * a[0], b[1] + s * a[1], b[2] + s * a[2])


@kernel
def rotate(R: Matrix, a: Vector) -> Vec3:
    """R a."""
    return (
        R[0] * a[0] + R[1] * a[1] + R[2] * a[2],
        R[3] * a[0] + R[4] * a[1] + R[5] * a[2],
        R[6] * a[0] + R[7] * a[1] + R[8] * a[2],
    )


@kernel
def rotate_back(R: Matrix, a: Vector) -> Vec3:
    """R^T a."""
    return (
        R[0] * a[0] + R[3] * a[1] + R[6] * a[2],
        R[1] * a[0] + R[4] * a[1] + R[7] * a[2],
        R[2] * a[0] + R[5] * a[1] + R[8] * a[2],
    )


@kernel
def turning(R: Matrix, w: Vector) -> Matrix3:
    """R w^: how R changes where its axes turn with w (along them)."""
    return (*cross(R[0:3], w), *cross(R[3:6], w), *cross(R[6:9], w))


@kernel
def upright(a: Vector, b: Vector) -> tuple[Vec3, Vec3]:
    """The unit vector along a, and the one along b across it."""
    a = scale(1.0 / sqrt(dot(a, a)), a)
    b = axpy(-dot(a, b), a, b)
    return a, scale(1.0 / sqrt(dot(b, b)), b)


@kernel
def transpose(R: Matrix) -> Matrix3:
    """R^T, the inverse of a rotation."""
    return (R[0], R[3], R[6], R[1], R[4], R[7], R[2], R[5], R[8])


@kernel
def hat(u: Vector) -> Matrix3:
    """The skew matrix with hat(u) a = u x a."""
    return (0.0, -u[2], u[1], u[2], 0.0, -u[0], -u[1], u[0], 0.0)


@kernel
def vee(S: Matrix) -> Vec3:
    """The inverse of hat, from the skew part of S."""
    return (0.5 * (S[7] - S[5]), 0.5 * (S[2] - S[6]), 0.5 * (S[3] - S[1]))


@kernel
def multiply(A: Matrix, B: Matrix) -> Matrix3:
    """The group's product A B."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


# ---------------------------------------------------------------- coefficients
@kernel
def half_angle(x: Number) -> tuple[Any, Any]:
    """cos(angle/2) and sin(angle/2)/(angle/2), at any angle.

    Minimax polynomials at a quarter of the angle (error below 5e-17 for angles up to 6), then one doubling.

    Parameters
    ----------
    x : Number
        The angle squared, rad^2.

    Returns
    -------
    c, s : Number
        The cosine, and the sine over half the angle.
    """
    y = 0.0625 * x
    p = 2.480158729989807e-05 + y * (
        -2.755731877324578e-07
        + y * (2.0876699688649955e-09 + y * (-1.1467003167981846e-11 + y * 4.658011147363636e-14))
    )
    c = 1.0 + y * (-0.5 + y * (0.041666666666666664 + y * (-0.0013888888888886515 + y * p)))
    p = 2.75573192209389e-06 + y * (
        -2.5052107853056496e-08 + y * (1.6058993300652714e-10 + y * (-7.644503916385084e-13 + y * 2.73840520812008e-15))
    )
    s = 1.0 + y * (-0.16666666666666666 + y * (0.008333333333333325 + y * (-0.00019841269841261276 + y * p)))
    half = 0.5 * sqrt(x)
    small = x < SERIES_BOUND
    return (
        where(small, 1.0 - 2.0 * (y * (s * s)), cos(half)),
        where(small, s * c, sin(half) / where(small, 1.0, half)),
    )


@kernel
def dexp_coefficients(x: Number) -> tuple[Any, Any]:
    """(1 - cos angle)/angle**2 and (angle - sin angle)/angle**3."""
    c, s = half_angle(x)
    p = -1 / 1307674368000 + x * (1 / 355687428096000 + x * (-1 / 121645100408832000))
    p = 1 / 362880 + x * (-1 / 39916800 + x * (1 / 6227020800 + x * p))
    series = 1 / 6 + x * (-1 / 120 + x * (1 / 5040 - x * p))
    return 0.5 * (s * s), where(x < 2.0, series, (1.0 - s * c) / where(x < 2.0, 1.0, x))


@kernel
def dexpinv_coefficient(x: Number) -> Any:
    """(1 - (angle/2) cot(angle/2))/angle**2; infinite at angle = 2 pi."""
    c, s = half_angle(x)
    p = 3617 / 10670622842880000 + x * (43867 / 5109094217170944000 + x * (174611 / 802857662698291200000))
    p = 691 / 1307674368000 + x * (1 / 74724249600 + x * p)
    p = 1 / 30240 + x * (1 / 1209600 + x * (1 / 47900160 + x * p))
    series = 1 / 12 + x * (1 / 720 + x * p)
    small = x < 1.0
    return where(small, series, (1.0 - c / s) / where(small, 1.0, x))


# ---------------------------------------------------------------- exp, log, dexp
@kernel
def exp(u: Vector) -> Matrix3:
    """The rotation by |u| about u: I + a hat(u) + b hat(u)^2 (Terze et al. 2015, section 2, d).

    Parameters
    ----------
    u : Vec3
        The rotation vector, rad; of any length.

    Returns
    -------
    Matrix3
        The rotation. exp(0) = I exactly.
    """
    c, s = half_angle(dot(u, u))
    a, b = s * c, 0.5 * (s * s)
    ax, ay, az = a * u[0], a * u[1], a * u[2]
    bx, by, bz = b * u[0], b * u[1], b * u[2]
    xx, yy, zz = bx * u[0], by * u[1], bz * u[2]
    xy, xz, yz = bx * u[1], bx * u[2], by * u[2]
    return (1.0 - (yy + zz), xy - az, xz + ay, xy + az, 1.0 - (xx + zz), yz - ax, xz - ay, yz + ax, 1.0 - (xx + yy))


@kernel
def log(R: Matrix) -> Vec3:
    """The rotation vector of a rotation.

    Parameters
    ----------
    R : Matrix3
        A rotation.

    Returns
    -------
    Vec3
        u with exp(u) = R and |u| <= pi, rad.
    """
    w, x, y, z = to_quaternion(R)
    square = x * x + y * y + z * z
    small = square < 0.01 * (w * w)
    t = square / where(small, w * w, 1.0)
    series = 1.0 + t * (-1 / 3 + t * (1 / 5 + t * (-1 / 7 + t * (1 / 9 + t * (-1 / 11 + t * (1 / 13 - t * (1 / 15)))))))
    n = sqrt(where(small, 1.0, square))
    factor = 2.0 * where(small, series / where(small, w, 1.0), atan2(n, w) / n)
    return (factor * x, factor * y, factor * z)


@kernel
def dexp(u: Vector, w: Vector) -> Vec3:
    """dexp_u(w) = sum_j ad_u^j w / (j+1)!, with d/dt exp(u) = hat(dexp_u(u')) exp(u) (Terze et al. 2015, A.5).

    Parameters
    ----------
    u : Vec3
        A rotation vector, rad.
    w : Vec3
        What it is applied to.

    Returns
    -------
    Vec3
        dexp_u(w).
    """
    b, d = dexp_coefficients(dot(u, u))
    uw = cross(u, w)
    return axpy(d, cross(u, uw), axpy(b, uw, w))


@kernel
def dexpinv(u: Vector, w: Vector) -> Vec3:
    """dexp_u^{-1}(w) in closed form (Terze et al. 2015, A.4); singular where |u| is a multiple of 2 pi.

    Parameters
    ----------
    u : Vec3
        A rotation vector, rad.
    w : Vec3
        What it is applied to.

    Returns
    -------
    Vec3
        w - 1/2 u x w + c u x (u x w), c = (1 - (|u|/2) cot(|u|/2))/|u|^2.
    """
    uw = cross(u, w)
    return axpy(dexpinv_coefficient(dot(u, u)), cross(u, uw), axpy(-0.5, uw, w))


@kernel
def dexpinv_truncated(u: Vector, w: Vector, order: int) -> Vec3:
    """sum_{j <= order} B_j/j! ad_u^j w (Terze et al. 2015, A.4). A method of order p needs j <= p - 2.

    Parameters
    ----------
    u : Vec3
        A rotation vector, rad.
    w : Vec3
        What it is applied to.
    order : int
        The last j, from 0 to 10.

    Returns
    -------
    Vec3
        The truncated series.
    """
    term: Vector = w
    total: Vec3 = (w[0], w[1], w[2])
    for j in range(1, order + 1):
        term = cross(u, term)
        total = axpy(BERNOULLI_OVER_FACTORIAL[j], term, total)
    return total


# ---------------------------------------------------------------- quaternions
@kernel
def from_quaternion(q: Vector) -> Matrix3:
    """The rotation of a quaternion.

    Parameters
    ----------
    q : Quaternion
        (w, x, y, z), of any length but zero.

    Returns
    -------
    Matrix3
        The rotation.
    """
    w, x, y, z = q
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),
        s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x),
        s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y),
    )  # fmt: skip


@kernel
def to_quaternion(R: Matrix) -> Quaternion:
    """The unit quaternion of a rotation: the best conditioned of four rows (Shepperd).

    Parameters
    ----------
    R : Matrix3
        A rotation.

    Returns
    -------
    Quaternion
        (w, x, y, z) with w >= 0.
    """
    t0, t1, t2, t3 = R[0] + R[4] + R[8], R[0] - R[4] - R[8], R[4] - R[0] - R[8], R[8] - R[0] - R[4]
    a, b, c = R[7] - R[5], R[2] - R[6], R[3] - R[1]
    d, e, f = R[1] + R[3], R[2] + R[6], R[5] + R[7]
    low, high = alike(t0 >= t1), alike(t2 >= t3)
    first, second = where(low, t0, t1), where(high, t2, t3)
    upper = alike(first >= second)
    w = where(upper, where(low, 1.0 + t0, a), where(high, b, c))
    x = where(upper, where(low, a, 1.0 + t1), where(high, d, e))
    y = where(upper, where(low, b, d), where(high, 1.0 + t2, f))
    z = where(upper, where(low, c, e), where(high, f, 1.0 + t3))
    n = sqrt(w * w + x * x + y * y + z * z)
    n = where(w < 0.0, -n, n)
    return (w / n, x / n, y / n, z / n)
