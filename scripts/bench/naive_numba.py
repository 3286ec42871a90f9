"""The heavy top as a good engineer writes it in Numba today: the paper's equations, small arrays, one run at a time.

RKMK4 with dexpinv truncated at order 2, exp in closed form, the 9x9 KKT matrix handed to LAPACK.
"""

from typing import Any

import numpy as np
from numba import njit

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": True, "cache": True}
LIMIT = 10  # iterations of the position projection


@njit(**OPTIONS)
def hat(u: Any) -> Any:
    return np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])


@njit(**OPTIONS)
def exp(u: Any) -> Any:
    x = np.dot(u, u)
    if x < 1e-4:
        a, b = 1.0 - x / 6.0 * (1.0 - x / 20.0), 0.5 - x / 24.0 * (1.0 - x / 30.0)
    else:
        a, b = np.sin(np.sqrt(x)) / np.sqrt(x), (1.0 - np.cos(np.sqrt(x))) / x
    U = hat(u)
    return np.eye(3) + a * U + b * (U @ U)


@njit(**OPTIONS)
def kkt(A: Any, C: Any) -> Any:
    K = np.zeros((9, 9))
    K[:6, :6] = A
    K[6:, :6] = C
    K[:6, 6:] = C.T
    return K


@njit(**OPTIONS)
def jacobian(R: Any, point: Any) -> Any:
    return np.hstack((np.eye(3), -R @ hat(point)))


@njit(**OPTIONS)
def slope(x: Any, u: Any, M: Any, gravity: Any, point: Any) -> Any:
    """dexpinv_{-u}(F(x exp(u))); x = (r, R, v, w), u (12)."""
    R, w = x[1] @ exp(u[3:6]), x[3] + u[9:12]
    b = np.zeros(9)
    b[0:3] = M[0, 0] * gravity
    b[3:6] = np.cross(M[3:, 3:].copy() @ w, w)
    b[6:9] = -R @ np.cross(w, np.cross(w, point))
    f = np.zeros(12)
    f[0:3] = x[2] + u[6:9]
    first = np.cross(u[3:6], w)
    f[3:6] = w + 0.5 * first + np.cross(u[3:6], first) / 12.0
    f[6:12] = np.linalg.solve(kkt(M, jacobian(R, point)), b)[:6]
    return f


@njit(**OPTIONS)
def moved(x: Any, u: Any) -> Any:
    return x[0] + u[0:3], x[1] @ exp(u[3:6]), x[2] + u[6:9], x[3] + u[9:12]


@njit(**OPTIONS)
def step(x: Any, h: float, M: Any, gravity: Any, point: Any) -> Any:
    f1 = slope(x, np.zeros(12), M, gravity, point)
    f2 = slope(x, 0.5 * h * f1, M, gravity, point)
    f3 = slope(x, 0.5 * h * f2, M, gravity, point)
    f4 = slope(x, h * f3, M, gravity, point)
    return moved(x, h / 6.0 * (f1 + 2.0 * f2 + 2.0 * f3 + f4))


@njit(**OPTIONS)
def projected(x: Any, M: Any, point: Any, tolerance: float) -> Any:
    """Positions in local coordinates with the weight diag(I, 2 I), then velocities in the norm of M."""
    W = np.diag(np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]))
    hat_x, u, b = x, np.zeros(12), np.zeros(9)
    for _ in range(LIMIT):
        C = jacobian(x[1], point)
        b[6:] = C @ u[:6] - (x[0] + x[1] @ point)
        u[:6] = np.linalg.solve(kkt(W, C), b)[:6]
        x = moved(hat_x, u)
        if np.max(np.abs(x[0] + x[1] @ point)) <= tolerance:
            break
    C = jacobian(x[1], point)
    b[6:] = -C @ np.concatenate((x[2], x[3]))
    change = np.linalg.solve(kkt(M, C), b)
    return x[0], x[1], x[2] + change[0:3], x[3] + change[3:6]


@njit(**OPTIONS)
def integrate(
    states: Any, masses: Any, inertia: Any, gravity: Any, point: Any, h: float, steps: int, every: int,
    project: bool, tolerance: float, records: Any,
) -> None:  # fmt: skip
    """Fill records (runs, steps // every, 18) from states (runs, 18); `point`: the pivot in the body's frame."""
    for run in range(len(states)):
        s = states[run]
        x = (s[0:3].copy(), s[3:12].copy().reshape(3, 3), s[12:15].copy(), s[15:18].copy())
        M = np.zeros((6, 6))
        M[:3, :3] = masses[run] * np.eye(3)
        M[3:, 3:] = inertia
        for n in range(1, steps + 1):
            x = step(x, h, M, gravity, point)
            if project:
                x = projected(x, M, point, tolerance)
            if n % every == 0:
                records[run, n // every - 1] = np.concatenate((x[0], x[1].ravel(), x[2], x[3]))
