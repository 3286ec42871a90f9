"""Mechanisms in coordinates of one's own choice, after Kane: a map from coordinates to poses, and nothing else.

A mechanism says where its bodies are as a function of its coordinates and of time. Rates come from it by complex
steps, their rates by central differences along the motion; the equations of motion are Newton's and Euler's for every
body, projected onto the partial velocities. Where a loop is closed or a motion is prescribed by its velocity,
conditions with multipliers are added. Angular velocities are global here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Array = np.ndarray
Places = list[tuple[Array, Array]]  # r (..., 3) and R (..., 3, 3) of every body

TINY = 1e-40  # complex step
WIDTH = 2e-3  # s, of the central difference
SHIFTS = WIDTH * np.arange(-3, 4)
WEIGHTS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / (60.0 * WIDTH)


@dataclass(frozen=True)
class Body:
    mass: float
    inertia: Array  # (3, 3), about the mass centre, body frame


@dataclass(frozen=True)
class Motion:
    """Of all bodies: r, v, a and the angular velocity w and acceleration alpha, (bodies, 3), global; R (bodies, 3, 3).

    multipliers: of the conditions; q, qd, qdd: coordinates.
    """

    t: float
    q: Array
    qd: Array
    qdd: Array
    r: Array
    R: Array
    v: Array
    w: Array
    a: Array
    alpha: Array
    multipliers: Array


@dataclass(frozen=True)
class Mechanism:
    """place(q, t): q is a list of arrays of one common shape.

    applied(r, R, v, w, t): forces and torques at the mass centres (bodies, 3) each beside the weight, global.
    closure(places, t): rows that vanish, (..., rows). prescribed(places, v, w, t): rows that vanish, affine in v and w.
    """

    bodies: Sequence[Body]
    place: Callable[[list[Array], Array], Places]
    gravity: Sequence[float]
    applied: Callable[..., tuple[Array, Array]] | None = None
    closure: Callable[[Places, Any], Array] | None = None
    prescribed: Callable[..., Array] | None = None


def along(m: Mechanism, q: Array, rates: Array, t: Any, dt: Any) -> tuple[Places, Array, Array, Array]:
    """Poses, v and w (bodies, members, 3) and the rates of the closure; q, rates (n, members) and t, dt (members,)."""
    time = t + 1j * TINY * dt
    places = m.place(list(q + 1j * TINY * rates), time)
    members = q.shape[1]
    v = np.array([np.broadcast_to(r, (members, 3)).imag / TINY for r, _ in places])
    turning = [np.broadcast_to(R, (members, 3, 3)) for _, R in places]
    spin = np.array([(R.imag / TINY) @ np.swapaxes(R.real, -1, -2) for R in turning])
    w = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
    closing = np.zeros((members, 0)) if m.closure is None else m.closure(places, time).imag / TINY
    real = [(np.broadcast_to(r, (members, 3)).real, R.real) for (r, _), R in zip(places, turning, strict=True)]
    return real, v, w, closing


def motion(m: Mechanism, t: float, q: Array, qd: Array) -> Motion:
    """Accelerations and multipliers of a state."""
    n = len(q)
    points = np.concatenate([np.repeat(q[:, None], n, axis=1), q[:, None] + qd[:, None] * SHIFTS], axis=1)
    rates = np.concatenate([np.eye(n), np.repeat(qd[:, None], 7, axis=1)], axis=1)
    times = np.concatenate([np.full(n, t), t + SHIFTS])
    places, v, w, closing = along(m, points, rates, times, np.concatenate([np.zeros(n), np.ones(7)]))
    r, R = np.array([x[n + 3] for x, _ in places]), np.array([X[n + 3] for _, X in places])
    V, W = v[:, :n], w[:, :n]  # (bodies, n, 3)
    vs, ws = v[:, n:], w[:, n:]
    bias_v, bias_w = (np.einsum("s,bsi->bi", WEIGHTS, x) for x in (vs, ws))

    force = np.array([b.mass * np.array(m.gravity) for b in m.bodies])
    torque = np.zeros_like(force)
    if m.applied is not None:
        more = m.applied(r, R, vs[:, 3], ws[:, 3], t)
        force, torque = force + more[0], torque + more[1]
    mass = np.array([b.mass for b in m.bodies])
    J = np.array([X @ b.inertia @ X.T for b, X in zip(m.bodies, R, strict=True)])
    spun = np.cross(ws[:, 3], np.einsum("bij,bj->bi", J, ws[:, 3]))
    M = np.einsum("b,bni,bki->nk", mass, V, V) + np.einsum("bni,bij,bkj->nk", W, J, W)
    Q = np.einsum("bni,bi->n", V, force - mass[:, None] * bias_v)
    Q += np.einsum("bni,bi->n", W, torque - np.einsum("bij,bj->bi", J, bias_w) - spun)

    C, gamma = closing[:n].T, WEIGHTS @ closing[n:]
    if m.prescribed is not None:
        ends = [(x[n:], X[n:]) for x, X in places]
        rows = m.prescribed(ends, vs, ws, times[n:])
        here = [(x[n + 3 : n + 4], X[n + 3 : n + 4]) for x, X in places]
        rest = m.prescribed(here, 0 * vs[:, :1], 0 * ws[:, :1], t)
        units = np.concatenate([m.prescribed(here, V[:, k : k + 1], W[:, k : k + 1], t) - rest for k in range(n)])
        C, gamma = np.concatenate([C, units.T]), np.concatenate([gamma, WEIGHTS @ rows])
    c = len(C)
    left = np.block([[M, -C.T], [C, np.zeros((c, c))]])
    solution = np.linalg.solve(left, np.concatenate([Q, -gamma])) if n else np.zeros(0)
    qdd = solution[:n]
    a, alpha = bias_v + np.einsum("bni,n->bi", V, qdd), bias_w + np.einsum("bni,n->bi", W, qdd)
    return Motion(t, q, qd, qdd, r, R, vs[:, 3], ws[:, 3], a, alpha, solution[n:])


def condition_loads(m: Mechanism, here: Motion) -> Array:
    """What the conditions exert on every body: forces, and torques about the mass centres (2, bodies, 3), global."""
    k = len(m.bodies)
    found = np.zeros((2, k, 3))
    time = np.array([here.t])
    at = [(here.r[i : i + 1], here.R[i : i + 1]) for i in range(k)]
    for i in range(k):
        for n, e in enumerate(np.eye(3)):
            hat = np.cross(np.eye(3), e)
            for turning in range(2):
                v, w = np.zeros((2, k, 1, 3))
                moved = list(at)
                if turning:
                    w[i, 0] = e
                    moved[i] = (at[i][0], at[i][1] + 1j * TINY * (hat @ at[i][1]))
                else:
                    v[i, 0] = e
                    moved[i] = (at[i][0] + 1j * TINY * e, at[i][1])
                rows = [np.zeros(0)]
                if m.closure is not None:
                    rows.append(np.broadcast_to(m.closure(moved, time), (1, len(here.multipliers)))[0].imag / TINY)
                if m.prescribed is not None:
                    rows.append((m.prescribed(at, v, w, time) - m.prescribed(at, 0 * v, 0 * w, time))[0])
                found[turning, i, n] = np.concatenate(rows) @ here.multipliers
    return found


def closed(m: Mechanism, q: Array, qd: Array, free: Sequence[int]) -> tuple[Array, Array]:
    """The same state with all conditions fulfilled at t = 0 by the coordinates and rates that are not in `free`."""
    q, qd, n = q.copy(), qd.copy(), len(q)
    bound = [i for i in range(n) if i not in free]
    assert m.closure is not None
    for _ in range(30):
        gaps = np.broadcast_to(m.closure(m.place(list(q[:, None]), np.zeros(1)), np.zeros(1)), (1, len(bound)))[0]
        _, _, _, C = along(m, np.repeat(q[:, None], n, axis=1), np.eye(n), np.zeros(n), np.zeros(n))
        q[bound] -= np.linalg.solve(C[bound].T, gaps)
    _, _, _, rate = along(m, q[:, None], 0 * qd[:, None], np.zeros(1), np.ones(1))
    qd[bound] = np.linalg.solve(C[bound].T, -rate[0] - C[list(free)].T @ qd[list(free)])
    return q, qd


def simulate(m: Mechanism, q: Array, qd: Array, times: Sequence[float]) -> list[Motion]:
    """The motion from t = 0 at these times, which begin with 0."""
    n = len(q)

    def flow(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], motion(m, t, y[:n], y[n:]).qdd])

    start = np.concatenate([q, qd])
    if n == 0:
        return [motion(m, t, start, start) for t in times]
    found = solve_ivp(flow, (0.0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-12)
    assert found.success
    return [motion(m, t, y[:n], y[n:]) for t, y in zip(times, found.y.T, strict=True)]


def net_load(m: Mechanism, here: Motion, members: Sequence[int], point: Array) -> tuple[Array, Array]:
    """What must act on some bodies, beside weight, applied forces and conditions, that they move as they do: force, and torque
    about a point; global."""
    force, torque = np.zeros(3), np.zeros(3)
    applied = condition_loads(m, here)
    if m.applied is not None:
        applied += np.array(m.applied(here.r, here.R, here.v, here.w, here.t))
    for i in members:
        J = here.R[i] @ m.bodies[i].inertia @ here.R[i].T
        f = m.bodies[i].mass * (here.a[i] - np.array(m.gravity)) - applied[0, i]
        force += f
        torque += J @ here.alpha[i] + np.cross(here.w[i], J @ here.w[i]) - applied[1, i]
        torque += np.cross(here.r[i] - point, f)
    return force, torque


def kinetic(m: Mechanism, here: Motion) -> float:
    spin = np.einsum("bji,bj->bi", here.R, here.w)
    turning = sum(w @ b.inertia @ w for b, w in zip(m.bodies, spin, strict=True))
    return 0.5 * float(sum(b.mass * v @ v for b, v in zip(m.bodies, here.v, strict=True)) + turning)
