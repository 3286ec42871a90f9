"""SO(3) under Numba: exp and dexp^-1 (Terze et al. 2015, section 2 and appendix A).

Vectors are 3-tuples, rotations 9-tuples, row by row, from body to global.
"""

import math
from typing import Any

import numpy as np

from lienumba.reference.compiling import compiled

Vec3 = tuple[Any, Any, Any]
Matrix3 = tuple[Any, ...]

ZERO = (0.0, 0.0, 0.0)
SERIES = 0.25  # rad^2: below, the coefficient of dexp^-1 in closed form is its series, which does not cancel
# (-1)^j B_j / j! (A.4), the signs of dexp^-1_{-u}; the paper's print leaves them out.
BERNOULLI = np.array([1, 1 / 2, 1 / 12, 0, -1 / 720, 0, 1 / 30240, 0, -1 / 1209600, 0, 1 / 47900160])


@compiled
def dot(a: Vec3, b: Vec3) -> float:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vec3, b: Vec3) -> Vec3:
    """a x b, which is a~ b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def plus(a: Vec3, s: float, b: Vec3) -> Vec3:
    """a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@compiled
def rotate(R: Matrix3, a: Vec3) -> Vec3:
    """R a."""
    return (
        R[0] * a[0] + R[1] * a[1] + R[2] * a[2],
        R[3] * a[0] + R[4] * a[1] + R[5] * a[2],
        R[6] * a[0] + R[7] * a[1] + R[8] * a[2],
    )


@compiled
def rotate_back(R: Matrix3, a: Vec3) -> Vec3:
    """R^T a."""
    return (
        R[0] * a[0] + R[3] * a[1] + R[6] * a[2],
        R[1] * a[0] + R[4] * a[1] + R[7] * a[2],
        R[2] * a[0] + R[5] * a[1] + R[8] * a[2],
    )


@compiled
def vector(x: np.ndarray, row: int, run: int) -> Vec3:
    """The vector in three rows of an array."""
    return x[row, run], x[row + 1, run], x[row + 2, run]


@compiled
def matrix(x: np.ndarray, row: int, run: int) -> Matrix3:
    """The rotation in nine rows of an array."""
    return (
        x[row, run], x[row + 1, run], x[row + 2, run], x[row + 3, run], x[row + 4, run], x[row + 5, run],
        x[row + 6, run], x[row + 7, run], x[row + 8, run],
    )  # fmt: skip


@compiled
def turned(R: Matrix3, u: Vec3) -> Matrix3:
    """R exp(u), by Rodrigues' formula: exp(u) a = a + sin t/t u x a + (1 - cos t)/t^2 u x (u x a), t = |u|."""
    t = math.sqrt(dot(u, u))
    s = math.sin(0.5 * t) / (0.5 * t) if t > 0.0 else 1.0
    first, second = math.sin(t) / t if t > 0.0 else 1.0, 0.5 * s * s  # in forms that do not cancel
    # The rows of R exp(u) are exp(-u) times the rows of R.
    p, q, r = (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
    up, uq, ur = cross(u, p), cross(u, q), cross(u, r)
    p = plus(plus(p, -first, up), second, cross(u, up))
    q = plus(plus(q, -first, uq), second, cross(u, uq))
    r = plus(plus(r, -first, ur), second, cross(u, ur))
    return p[0], p[1], p[2], q[0], q[1], q[2], r[0], r[1], r[2]


@compiled
def dexpinv(u: Vec3, w: Vec3, terms: int) -> Vec3:
    """dexp^-1_{-u}(w) (A.4): the series to ad^terms, or for terms < 0 its sum
    w + u x w/2 + c u x (u x w), c = (1 - (t/2) cot(t/2))/t^2, t = |u| < 2 pi."""
    if terms >= 0:
        total, term = w, w
        for j in range(1, terms + 1):
            term = cross(u, term)
            total = plus(total, BERNOULLI[j], term)
        return total
    x = dot(u, u)
    if x < SERIES:
        c = 1 / 1209600 + x * (1 / 47900160 + x * (691 / 1307674368000 + x / 74724249600))
        c = 1 / 12 + x * (1 / 720 + x * (1 / 30240 + x * c))
    else:
        half = 0.5 * math.sqrt(x)
        c = (1.0 - half / math.tan(half)) / x
    uw = cross(u, w)
    return plus(plus(w, 0.5, uw), c, cross(u, uw))
