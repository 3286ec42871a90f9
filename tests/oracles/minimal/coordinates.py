"""Motion in minimal coordinates: Newton-Euler equations projected on what the coordinates leave free, by SciPy DOP853.

A mechanism is a function from coordinates and time to the place of every body. Velocities are its complex-step
derivatives, accelerations their central differences; nothing is taken from lienumba.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

Places = list[tuple[np.ndarray, np.ndarray]]  # r (3,), R (3, 3) of every body
TINY = 1e-30
STENCIL = ((1, 0.75), (2, -0.15), (3, 1 / 60))  # sixth order
REACH = 1e-3


def turn(axis, angle):
    """The rotation about an axis; the angle may be complex."""
    length = math.hypot(*axis)
    x, y, z = (float(e) / length for e in axis)
    s, c = np.sin(angle), np.cos(angle)
    d = 1 - c
    return np.array([
        [c + d * x * x, d * x * y - s * z, d * x * z + s * y],
        [d * y * x + s * z, c + d * y * y, d * y * z - s * x],
        [d * z * x - s * y, d * z * y + s * x, c + d * z * z],
    ])  # fmt: skip


def euler(a, b, c):
    return turn((0, 0, 1), a) @ turn((0, 1, 0), b) @ turn((1, 0, 0), c)


def frame(z, x):
    """The columns x, y, z of the frame with this axis and x as near as can be."""
    z = np.asarray(z, float) / np.linalg.norm(z)
    x = x - z * (z @ x)
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _twists(moved):
    """v (global) and w (body frame) of every body (k, 6), from places and their derivatives."""
    return np.array([[*v, *vee(R.T @ dR)] for _, R, v, dR in moved])


def vee(A):
    """w of the antisymmetric part of hat(w)."""
    return 0.5 * np.array([A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]])


@dataclass(frozen=True)
class Minimal:
    """masses (k,), inertias (k, 3, 3) in the body frame, places(q, t), forces(places, velocities, t) -> (k, 6): force,
    global, and torque about the mass centre, body frame."""

    masses: np.ndarray
    inertias: np.ndarray
    places: Callable[[np.ndarray, float], Places]
    gravity: np.ndarray
    forces: Callable[..., np.ndarray] | None = None

    def _moved(self, q, t, dq, dt, s):
        """Places and their derivatives along (dq, dt), s further on."""
        moved = self.places(q + (s + 1j * TINY) * dq, t + (s + 1j * TINY) * dt)
        return [(r.real, R.real, r.imag / TINY, R.imag / TINY) for r, R in moved]

    def twists(self, q, t, dq, dt):
        """v (global) and w (body frame) of every body (k, 6)."""
        return _twists(self._moved(q, t, dq, dt, 0.0))

    def _bias(self, q, t, dq, here):
        """v' and w' where the coordinates do not accelerate (k, 6); here: places and their derivatives."""
        steps = [(c, self._moved(q, t, dq, 1.0, sign * n * REACH), sign) for n, c in STENCIL for sign in (1, -1)]
        out = []
        for i, (_, R, _, _) in enumerate(here):
            a = sum(sign * c * moved[i][2] for c, moved, sign in steps) / REACH
            ddR = sum(sign * c * moved[i][3] for c, moved, sign in steps) / REACH
            out.append([*a, *vee(R.T @ ddR)])
        return np.array(out)

    def accelerations(self, q, dq, t):
        """q'', and v', w' of every body (k, 6)."""
        n, k = len(q), len(self.masses)
        J = np.stack([self.twists(q, t, e, 0.0) for e in np.eye(n)], axis=2) if n else np.zeros((k, 6, 0))
        here = self._moved(q, t, dq, 1.0, 0.0)
        bias = self._bias(q, t, dq, here)
        load = self._loads([(r, R) for r, R, _, _ in here], t, _twists(here))
        A, b = np.zeros((n, n)), np.zeros(n)
        for i in range(k):
            M = np.zeros((6, 6))
            M[:3, :3], M[3:, 3:] = self.masses[i] * np.eye(3), self.inertias[i]
            A += J[i].T @ M @ J[i]
            b += J[i].T @ (load[i] - M @ bias[i])
        ddq = np.linalg.solve(A, b)
        return ddq, J @ ddq + bias

    def _loads(self, places, t, u):
        """Weight, gyroscopic torque and given forces (k, 6)."""
        load = np.zeros((len(self.masses), 6))
        for i, (m, inertia) in enumerate(zip(self.masses, self.inertias, strict=True)):
            w = u[i, 3:]
            (a, b, c), (x, y, z) = inertia @ w, w
            load[i] = [*(m * self.gravity), b * z - c * y, c * x - a * z, a * y - b * x]
        return load if self.forces is None else load + self.forces(places, u, t)

    def run(self, q, dq, end):
        """q and q' at the end."""
        n = len(q)
        if n == 0:
            return q, dq
        rates = lambda t, y: [*y[n:], *self.accelerations(y[:n], y[n:], t)[0]]  # noqa: E731
        done = solve_ivp(rates, (0.0, end), [*q, *dq], method="DOP853", rtol=1e-10, atol=1e-11)
        return done.y[:n, -1], done.y[n:, -1]

    def state(self, q, dq, t):
        """r, R, v, w of every body."""
        return [(r, R, u[:3], u[3:]) for (r, R), u in zip(self.places(q, t), self.twists(q, t, dq, 1.0), strict=True)]

    def held_by(self, q, dq, t, bodies, point):
        """Force, and torque about a point, global, that these bodies need from outside beside weight and forces."""
        _, a = self.accelerations(q, dq, t)
        u, places = self.twists(q, t, dq, 1.0), self.places(q, t)
        load = self._loads(places, t, u)
        force, torque = np.zeros(3), np.zeros(3)
        for i in bodies:
            r, R = places[i]
            f = self.masses[i] * a[i, :3] - load[i, :3]
            force += f
            torque += R @ (self.inertias[i] @ a[i, 3:] - load[i, 3:]) + np.cross(r - point, f)
        return force, torque
