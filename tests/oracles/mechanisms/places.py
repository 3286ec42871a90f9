"""Places of bodies, moved: by small amounts to any side, and along a motion in complex time. NumPy alone.

A place is a position (n, 3) and a rotation (n, 3, 3): n members at once. What is a function of places has its
derivatives by complex steps, and those along the motion by Cauchy's formula on a circle in complex time.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray
Places = Mapping[str, tuple[Array, Array]]
Function = Callable[[Places, Any], Array]  # (n, rows) of places and time

TINY = 1e-30
CIRCLE = np.exp(1j * np.pi * (np.arange(8) + 0.5) / 8)  # its upper half; the lower one is conjugate
FIRST, SECOND = CIRCLE**-1 / 8, 2 * CIRCLE**-2 / 8
REACH = 0.02  # of the circle, in radians of the fastest body: points far from its mass centre are faster
NEAR = 0.25  # m, which count as a radian: lengths of rods are no smooth functions beyond


@dataclass(frozen=True)
class State:
    """Of bodies by name: r, v global, w along their own axes, (k, 3); R (k, 3, 3)."""

    names: tuple[str, ...]
    r: Array
    R: Array
    v: Array
    w: Array

    @property
    def u(self) -> Array:
        """Velocities (6 k)."""
        return np.concatenate([self.v, self.w], axis=1).ravel()

    @property
    def flat(self) -> Array:
        """All of its numbers (18 k)."""
        return np.concatenate([x.ravel() for x in (self.r, self.R, self.v, self.w)])

    def like(self, flat: Array) -> "State":
        """Another state of the same bodies."""
        k = len(self.names)
        parts = np.split(flat, np.cumsum([3 * k, 9 * k, 3 * k]))
        shapes = ((3,), (3, 3), (3,), (3,))
        return State(self.names, *(x.reshape(k, *s) for x, s in zip(parts, shapes, strict=True)))

    def with_velocities(self, u: Array) -> "State":
        v, w = np.split(u.reshape(-1, 6), 2, axis=1)
        return State(self.names, self.r, self.R, v, w)

    def places(self) -> Places:
        return _named(self, self.r[:, None], self.R[:, None])

    def beside(self) -> Places:
        """6 k members, each with one velocity of one body for an imaginary moment."""
        k = len(self.names)
        step = 1j * TINY * np.eye(6 * k).reshape(6 * k, k, 6).swapaxes(0, 1)
        turned = self.R[:, None] @ (np.eye(3) + hat(step[..., 3:]))
        return _named(self, self.r[:, None] + step[..., :3], turned)

    def later(self, tau: Array, a: Array | None = None) -> Places:
        """As they move on; a: accelerations (6 k)."""
        dv, dw = np.split((np.zeros_like(self.u) if a is None else a).reshape(-1, 6), 2, axis=1)
        s = tau[None, :, None]
        r = self.r[:, None] + s * self.v[:, None] + 0.5 * s * s * dv[:, None]
        return _named(self, r, self.R[:, None] @ exp(s * self.w[:, None] + 0.5 * s * s * dw[:, None]))

    def partial(self, f: Function, t: float) -> Array:
        """The derivatives of f by all velocities (rows, 6 k)."""
        return f(self.beside(), t).imag.T / TINY

    def along(self, f: Function, t: float, a: Array | None = None) -> tuple[Array, Array]:
        """The first two derivatives of f along the motion (rows,)."""
        fastest = max(float(np.abs(x).max(initial=0.0)) for x in (self.w, self.v / NEAR))
        reach = REACH / max(1.0, fastest)
        values = f(self.later(reach * CIRCLE, a), t + reach * CIRCLE)
        return (FIRST @ values).real / reach, (SECOND @ values).real / reach**2


def _named(state: State, r: Array, R: Array) -> Places:
    places = {name: (r[i], R[i]) for i, name in enumerate(state.names)}
    members = r.shape[1]
    return places | {"ground": (np.zeros((members, 3)), np.broadcast_to(np.eye(3), (members, 3, 3)))}


def hat(v: Array) -> Array:
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    o = np.zeros_like(x)
    return np.stack([np.stack([o, -z, y], -1), np.stack([z, o, -x], -1), np.stack([-y, x, o], -1)], -2)


def vee(A: Array) -> Array:
    """Of the antisymmetric part."""
    return 0.5 * np.stack([A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]], -1)


def exp(v: Array) -> Array:
    """The rotation by a vector, after Rodrigues."""
    angle = np.sqrt((v * v).sum(-1))[..., None, None] / np.pi
    S = hat(v)
    return np.eye(3) + np.sinc(angle) * S + 0.5 * np.sinc(0.5 * angle) ** 2 * (S @ S)


def log(R: Array) -> Array:
    """The vector of a rotation by less than half a turn, from its quaternion, (n, 3, 3) or (3, 3)."""
    w = 0.5 * np.sqrt(1.0 + R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2])
    v = vee(R) / (2.0 * w[..., None])
    square = (v * v).sum(-1)
    small = np.abs(square) < 1e-8
    s = np.sqrt(np.where(small, 1.0, square))
    over = np.where(small, (1.0 + square / 6.0) * 2.0, 2.0 * np.arctan(s / w) / s)
    return over[..., None] * v


def angle(c: Array, s: Array) -> Array:
    """That of a direction with the components c, s: between -pi and pi in the first member, near it in the others."""
    start = np.arctan2(s.real[:1], c.real[:1])
    across, along = s * np.cos(start) - c * np.sin(start), c * np.cos(start) + s * np.sin(start)
    return np.asarray(start + np.arctan(across / along))


def cross(a: Array, b: Array) -> Array:
    """As np.cross, in a tenth of the time."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], -1)


def dot(a: Array, b: Array) -> Array:
    return (a * b).sum(-1)


def point_of(places: Places, body: str, point: Any) -> Array:
    r, R = places[body]
    return r + R @ np.asarray(point, float)


def direction_of(places: Places, body: str, direction: Any) -> Array:
    d = np.asarray(direction, float)
    return places[body][1] @ (d / np.linalg.norm(d))
