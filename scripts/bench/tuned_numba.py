"""`naive_numba` after an afternoon of tuning: work arrays allocated once, small products written out.

The 9x9 KKT matrix still goes to LAPACK: what remains slow is the shape of the method, not carelessness.
"""

from typing import Any

import numpy as np
from numba import njit

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": True, "cache": True}
LIMIT = 10  # iterations of the position projection


@njit(**OPTIONS)
def _exp(u: Any, E: Any) -> None:
    """E (3, 3) = exp(u)."""
    x = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    if x < 1e-4:
        a = 1.0 - x / 6.0 * (1.0 - x / 20.0)
        b = 0.5 - x / 24.0 * (1.0 - x / 30.0)
    else:
        angle = np.sqrt(x)
        a = np.sin(angle) / angle
        b = (1.0 - np.cos(angle)) / x
    for i in range(3):
        for j in range(3):
            E[i, j] = b * u[i] * u[j]
        E[i, i] += 1.0 - b * x
    E[0, 1] -= a * u[2]
    E[0, 2] += a * u[1]
    E[1, 0] += a * u[2]
    E[1, 2] -= a * u[0]
    E[2, 0] -= a * u[1]
    E[2, 1] += a * u[0]


@njit(**OPTIONS)
def _cross(a: Any, b: Any, c: Any) -> None:
    """c = a x b."""
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]


@njit(**OPTIONS)
def _fill_jacobian(K: Any, R: Any, point: Any) -> None:
    """C = [I, -R hat(point)] and its transpose in the KKT matrix."""
    for i in range(3):
        K[6 + i, i] = K[i, 6 + i] = 1.0
        K[6 + i, 3] = K[3, 6 + i] = R[i, 2] * point[1] - R[i, 1] * point[2]
        K[6 + i, 4] = K[4, 6 + i] = R[i, 0] * point[2] - R[i, 2] * point[0]
        K[6 + i, 5] = K[5, 6 + i] = R[i, 1] * point[0] - R[i, 0] * point[1]


@njit(**OPTIONS)
def _slope(x: Any, u: Any, mass: float, inertia: Any, gravity: Any, point: Any, K: Any, b: Any, f: Any, t: Any) -> None:
    """f (12) = dexpinv_{-u}(F(x exp(u))); x: r, R, v, w (18); K (9, 9) and b (9): scratch; t: five vectors of it."""
    R, E, w, p, q = t[0], t[1], t[2, 0], t[2, 1], t[2, 2]
    _exp(u[3:6], E)
    for i in range(3):
        for j in range(3):
            R[i, j] = x[3 + 3 * i] * E[0, j] + x[4 + 3 * i] * E[1, j] + x[5 + 3 * i] * E[2, j]
        w[i] = x[15 + i] + u[9 + i]
        f[i] = x[12 + i] + u[6 + i]
    K[:] = 0.0
    for i in range(3):
        K[i, i] = mass
        for j in range(3):
            K[3 + i, 3 + j] = inertia[i, j]
        p[i] = inertia[i, 0] * w[0] + inertia[i, 1] * w[1] + inertia[i, 2] * w[2]
        b[i] = mass * gravity[i]
    _fill_jacobian(K, R, point)
    _cross(p, w, b[3:6])
    _cross(w, point, p)
    _cross(w, p, q)
    for i in range(3):
        b[6 + i] = -(R[i, 0] * q[0] + R[i, 1] * q[1] + R[i, 2] * q[2])
    a = np.linalg.solve(K, b)
    _cross(u[3:6], w, p)
    _cross(u[3:6], p, q)
    for i in range(3):
        f[3 + i] = w[i] + 0.5 * p[i] + q[i] / 12.0
        f[6 + i] = a[i]
        f[9 + i] = a[3 + i]


@njit(**OPTIONS)
def _move(x: Any, u: Any, E: Any) -> None:
    """x = x exp(u)."""
    _exp(u[3:6], E)
    for i in range(3):
        a, b, c = x[3 + 3 * i], x[4 + 3 * i], x[5 + 3 * i]
        for j in range(3):
            x[3 + 3 * i + j] = a * E[0, j] + b * E[1, j] + c * E[2, j]
        x[i] += u[i]
        x[12 + i] += u[6 + i]
        x[15 + i] += u[9 + i]


@njit(**OPTIONS)
def _project(x: Any, mass: float, inertia: Any, point: Any, K: Any, b: Any, E: Any, u: Any, tolerance: float) -> None:
    """Positions in local coordinates with the weight diag(I, 2 I), then velocities in the norm of M."""
    hat = x[0:12].copy()
    correction = np.zeros(6)
    for _ in range(LIMIT):
        R = x[3:12].reshape(3, 3)
        K[:] = 0.0
        for i in range(3):
            K[i, i] = 1.0
            K[3 + i, 3 + i] = 2.0
        _fill_jacobian(K, R, point)
        b[:] = 0.0
        for i in range(3):
            b[6 + i] = -(x[i] + R[i, 0] * point[0] + R[i, 1] * point[1] + R[i, 2] * point[2])
            for j in range(6):
                b[6 + i] += K[6 + i, j] * correction[j]
        correction[:] = np.linalg.solve(K, b)[0:6]
        x[0:12] = hat
        u[:] = 0.0
        u[0:6] = correction
        _move(x, u, E)
        R = x[3:12].reshape(3, 3)
        worst = 0.0
        for i in range(3):
            gap = x[i] + R[i, 0] * point[0] + R[i, 1] * point[1] + R[i, 2] * point[2]
            worst = max(worst, abs(gap))
        if worst <= tolerance:
            break
    K[:] = 0.0
    for i in range(3):
        K[i, i] = mass
        for j in range(3):
            K[3 + i, 3 + j] = inertia[i, j]
    _fill_jacobian(K, x[3:12].reshape(3, 3), point)
    b[:] = 0.0
    for i in range(3):
        for j in range(6):
            b[6 + i] -= K[6 + i, j] * x[12 + j]
    x[12:18] += np.linalg.solve(K, b)[0:6]


@njit(**OPTIONS)
def integrate(
    states: Any, masses: Any, inertia: Any, gravity: Any, point: Any, h: float, steps: int, every: int,
    project: bool, tolerance: float, records: Any,
) -> None:  # fmt: skip
    """Fill records (runs, steps // every, 18) from states (runs, 18); `point`: the pivot in the body's frame."""
    K, b, t, u = np.zeros((9, 9)), np.zeros(9), np.zeros((3, 3, 3)), np.zeros(12)
    f = np.zeros((4, 12))
    for run in range(len(states)):
        x = states[run].copy()
        for n in range(1, steps + 1):
            u[:] = 0.0
            _slope(x, u, masses[run], inertia, gravity, point, K, b, f[0], t)
            u[:] = 0.5 * h * f[0]
            _slope(x, u, masses[run], inertia, gravity, point, K, b, f[1], t)
            u[:] = 0.5 * h * f[1]
            _slope(x, u, masses[run], inertia, gravity, point, K, b, f[2], t)
            u[:] = h * f[2]
            _slope(x, u, masses[run], inertia, gravity, point, K, b, f[3], t)
            u[:] = h / 6.0 * (f[0] + 2.0 * f[1] + 2.0 * f[2] + f[3])
            _move(x, u, t[1])
            if project:
                _project(x, masses[run], inertia, point, K, b, t[1], u, tolerance)
            if n % every == 0:
                records[run, n // every - 1] = x
