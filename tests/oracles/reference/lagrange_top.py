"""The exact motion of the paper's heavy top (section 7.1), to far beyond double precision.

It is a Lagrange top: inertia C about its axis e, A across it at the pivot, spin s = w.e constant. With the
angular momentum L about the pivot, all global,

    e' = L x e / A,    L' = m l e x g,    b' = (L - C s e) / A x b,

where b is a vector across e of a frame that does not spin; the body turns in that frame by s t about e. Unlike
Euler angles nothing is singular (the axis passes within a hair of the vertical), and unlike the body's own
equations nothing is fast. The right-hand sides are products, so Taylor series follow from convolutions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

DIGITS = 30
ORDER = 32
STEP = 0.04  # a quarter or less of the radius of convergence for tops like the paper's


@dataclass(frozen=True)
class Top:
    """The paper's data; inertias about the mass centre, `arm` from the pivot to it along the body's y."""

    mass: float = 15.0
    across: float = 0.234375
    axial: float = 0.46875
    arm: float = 1.0
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    angular_velocity: tuple[float, float, float] = (
        0.0,
        150.0,
        -4.61538,
    )  # body frame, which is global at t = 0


@dataclass(frozen=True)
class State:
    """r, v (3,) global; R (3,3) body to global; omega (3,) body frame."""

    time: float
    r: np.ndarray
    R: np.ndarray
    v: np.ndarray
    omega: np.ndarray


def motion(times: Sequence[float], top: Top | None = None) -> list[State]:
    """The states at ascending times (s), starting from rotation I at t = 0."""
    top = top or Top()
    with mpmath.workdps(DIGITS):
        mpf = mpmath.mpf
        across = mpf(top.across) + mpf(top.mass) * mpf(top.arm) ** 2
        spin = mpf(top.angular_velocity[1])
        wx, _, wz = (mpf(x) for x in top.angular_velocity)
        y = (
            [mpf(x) for x in (0, 1, 0)]
            + [across * wx, mpf(top.axial) * spin, across * wz]
            + [mpf(x) for x in (1, 0, 0)]
        )
        states, start = [], mpf(0)
        for time in times:
            while mpf(time) - start > STEP:
                y = _evaluate(_series(y, top, across), mpf(STEP))
                start += mpf(STEP)
            states.append(_state(mpf(time), _evaluate(_series(y, top, across), mpf(time) - start), top, across))
        return states


def _series(y: list[Any], top: Top, across: Any) -> list[list[Any]]:
    """The Taylor coefficients of e, L, b (nine lists)."""
    load = [mpmath.mpf(top.mass) * mpmath.mpf(top.arm) * mpmath.mpf(g) for g in top.gravity]
    axial = mpmath.mpf(top.axial) * mpmath.mpf(top.angular_velocity[1])
    c = [[value] for value in y]
    e, L, b = c[0:3], c[3:6], c[6:9]
    slow: list[list[Any]] = [[], [], []]  # the coefficients of L - C s e
    for n in range(ORDER):
        for i in range(3):
            slow[i].append(L[i][n] - axial * e[i][n])
        changes = [x / across for x in _cross_term(L, e, n)]
        changes += [e[i - 2][n] * load[i - 1] - e[i - 1][n] * load[i - 2] for i in range(3)]
        changes += [x / across for x in _cross_term(slow, b, n)]
        for coefficients, change in zip(c, changes, strict=True):
            coefficients.append(change / (n + 1))
    return c


def _cross_term(a: list[list[Any]], b: list[list[Any]], n: int) -> list[Any]:
    """The coefficient n of a x b."""

    def product(i: int, j: int) -> Any:
        return mpmath.fdot(a[i][: n + 1], b[j][n::-1])

    return [product(i - 2, i - 1) - product(i - 1, i - 2) for i in range(3)]


def _evaluate(c: list[list[Any]], t: Any) -> list[Any]:
    powers = [t**n for n in range(ORDER + 1)]
    return [mpmath.fdot(coefficients, powers) for coefficients in c]


def _state(t: Any, y: list[Any], top: Top, across: Any) -> State:
    e, L, b = y[0:3], y[3:6], y[6:9]
    spin = mpmath.mpf(top.angular_velocity[1])
    n = _cross(b, e)
    cosine, sine = mpmath.cos(spin * t), mpmath.sin(spin * t)
    x = [cosine * bi - sine * ni for bi, ni in zip(b, n, strict=True)]
    z = [sine * bi + cosine * ni for bi, ni in zip(b, n, strict=True)]
    arm = mpmath.mpf(top.arm)
    omega = [mpmath.fdot(x, L) / across, spin, mpmath.fdot(z, L) / across]
    v = [arm * component / across for component in _cross(L, e)]
    return State(float(t), _floats([arm * ei for ei in e]), _floats([x, e, z]).T, _floats(v), _floats(omega))


def _cross(a: list[Any], b: list[Any]) -> list[Any]:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def _floats(values: Any) -> np.ndarray:
    return np.array(values, dtype=float)
