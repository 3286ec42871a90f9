"""SO(3) in mpmath: every formula to 50 digits, from its definition."""

from collections.abc import Callable, Sequence
from typing import Any

import mpmath
import numpy as np

DIGITS = 50


def vector(u: Sequence[Any]) -> Any:
    return mpmath.matrix([mpmath.mpf(x) for x in u])


def hat(u: Any) -> Any:
    return mpmath.matrix([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])


def angle(u: Any) -> Any:
    return mpmath.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)


def rotation(u: Any) -> Any:
    """Rodrigues' formula; at 50 digits its cancellation does not matter."""
    t, U = angle(u), hat(u)
    if t < mpmath.mpf(10) ** -20:
        return mpmath.eye(3) + U + U * U / 2
    return mpmath.eye(3) + mpmath.sin(t) / t * U + (1 - mpmath.cos(t)) / t**2 * U * U


def numbers(matrix: Any) -> np.ndarray:
    return np.array([float(x) for x in matrix])


def exp(u: Sequence[float]) -> np.ndarray:
    """The nine elements of exp(u)."""
    with mpmath.workdps(DIGITS):
        return numbers(rotation(vector(u)))


def trivialised_derivative(u: Sequence[float], w: Sequence[float]) -> np.ndarray:
    """The vector of (d/dt exp(u + t w)) exp(u)^T at t = 0, by central differences with a step of 1e-16."""
    with mpmath.workdps(DIGITS):
        a, b, t = vector(u), vector(w), mpmath.mpf(10) ** -16
        S = (rotation(a + t * b) - rotation(a - t * b)) / (2 * t) * rotation(a).T
        return numbers([(S[2, 1] - S[1, 2]) / 2, (S[0, 2] - S[2, 0]) / 2, (S[1, 0] - S[0, 1]) / 2])


def of_square(f: Callable[[Any], Any], x: float) -> Any:
    """f(angle) in mpmath for angle**2 = x; just beside 0, where the formula is 0/0, for it is constant there."""
    return f(mpmath.sqrt(max(mpmath.mpf(x), mpmath.mpf(10) ** -40)))
