"""Mechanisms in coordinates of one's own choice, after Kane: a map from coordinates to poses, and nothing else.

A mechanism says where its bodies are as a function of its coordinates and of time. Partial velocities come from it by
complex steps, the two derivatives along the motion by Cauchy's formula on a circle in complex time; the equations of
motion are Newton's and Euler's for every body, projected onto the partial velocities. Where a loop is closed or a
motion is prescribed by its velocity, conditions with multipliers are added. Angular velocities are global here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Array = np.ndarray
Places = list[tuple[Array, Array]]  # r (..., 3) and R (..., 3, 3) of every body

TINY = 1e-40  # complex step
CIRCLE = np.exp(1j * np.pi * (np.arange(8) + 0.5) / 8)  # its upper half; the lower one is conjugate
FIRST, SECOND = CIRCLE**-1 / 8, 2 * CIRCLE**-2 / 8  # the first and second derivative, after Cauchy


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
    """place(q, t): q is a list of arrays of one common shape; rotors: of each coordinate, what turns with its rate.

    closure(places, t): rows that vanish, (..., rows). prescribed(places, v, w, t): rows that vanish, affine in v and w.
    """

    bodies: Sequence[Body]
    place: Callable[[list[Array], Array], Places]
    gravity: Sequence[float]
    closure: Callable[[Places, Any], Array] | None = None
    prescribed: Callable[..., Array] | None = None
    rotors: Sequence[float] = ()
    speed: float = 5.0  # 1/s; of functions of time: their angular frequency, or several times 1/distance to a pole


def poses(m: Mechanism, q: Array, t: Array) -> tuple[Array, Array, Array]:
    """r (bodies, members, 3), R (bodies, members, 3, 3), closure (members, rows); q (n, members), t (members,)."""
    places = m.place(list(q), t)
    members = len(t)
    r = np.array([np.broadcast_to(x, (members, 3)) for x, _ in places])
    R = np.array([np.broadcast_to(X, (members, 3, 3)) for _, X in places])
    gap = np.zeros((members, 0)) if m.closure is None else m.closure(list(zip(r, R, strict=True)), t)
    return r, R, np.broadcast_to(gap, (members, gap.shape[-1]))


def vee(A: Array) -> Array:
    """Of the antisymmetric part."""
    return 0.5 * np.stack([A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]], -1)


def partial(m: Mechanism, q: Array, t: float) -> tuple[Array, Array, Array]:
    """What a unit rate of every coordinate does: v (bodies, n, 3), w (bodies, n, 3), closure (n, rows)."""
    n = len(q)
    return _rates(*poses(m, q[:, None] + 1j * TINY * np.eye(n), np.full(n, t)))


def _rates(r: Array, R: Array, gap: Array) -> tuple[Array, Array, Array]:
    """What the steps of size i TINY that these poses have taken say."""
    return r.imag / TINY, vee((R.imag / TINY) @ np.swapaxes(R.real, -1, -2)), gap.imag / TINY


def motion(m: Mechanism, t: float, q: Array, qd: Array) -> Motion:
    """Accelerations and multipliers of a state."""
    n = len(q)
    reach = 1.0 / (m.speed + float(np.abs(qd).sum()))
    members = np.array(np.broadcast_to(q[:, None], (n, 1 + n + len(CIRCLE))), complex)  # here, partially, and around
    members[:, 1 : n + 1] += 1j * TINY * np.eye(n)
    members[:, n + 1 :] += reach * qd[:, None] * CIRCLE
    places, turns, gaps = poses(m, members, t + reach * np.concatenate([np.zeros(n + 1), CIRCLE]))
    r, R = places[:, 0].real, turns[:, 0].real
    V, W, C = _rates(places[:, 1 : n + 1], turns[:, 1 : n + 1], gaps[1 : n + 1])
    around = places[:, n + 1 :], turns[:, n + 1 :], gaps[None, n + 1 :]
    v, dR, _ = (np.einsum("k,bk...->b...", FIRST / reach, x).real for x in around)
    a, ddR, gamma = (np.einsum("k,bk...->b...", SECOND / reach**2, x).real for x in around)
    w, alpha = (vee(x @ np.swapaxes(R, -1, -2)) for x in (dR, ddR))

    # a, alpha and gamma so far: as if the coordinates did not accelerate
    mass = np.array([b.mass for b in m.bodies])
    J = np.array([X @ b.inertia @ X.T for b, X in zip(m.bodies, R, strict=True)])
    M = np.einsum("b,bni,bki->nk", mass, V, V) + np.einsum("bni,bij,bkj->nk", W, J, W)
    Q = np.einsum("bni,bi->n", V, mass[:, None] * (np.array(m.gravity) - a))
    Q += np.einsum("bni,bi->n", W, -np.einsum("bij,bj->bi", J, alpha) - np.cross(w, np.einsum("bij,bj->bi", J, w)))
    M += np.diag(m.rotors or np.zeros(n))
    C, gamma = C.T, gamma[0]
    if m.prescribed is not None:
        i = 1j * TINY
        later = list(zip((r + i * v)[:, None], (R + i * dR)[:, None], strict=True))
        rate = m.prescribed(later, (v + i * a)[:, None], (w + i * alpha)[:, None], t + i)[0].imag / TINY
        C, gamma = np.concatenate([C, prescribed_columns(m, r, R, V, W, t)]), np.concatenate([gamma, rate])
    left = np.block([[M, -C.T], [C, np.zeros((len(C), len(C)))]])
    solution = np.linalg.solve(left, np.concatenate([Q, -gamma])) if n else np.zeros(0)
    qdd = solution[:n]
    a, alpha = a + np.einsum("bni,n->bi", V, qdd), alpha + np.einsum("bni,n->bi", W, qdd)
    return Motion(t, q, qd, qdd, r, R, v, w, a, alpha, solution[n:])


def prescribed_columns(m: Mechanism, r: Array, R: Array, V: Array, W: Array, t: float) -> Array:
    """What unit velocities (bodies, n, 3) add to the rows of the prescribed motion (rows, n)."""
    assert m.prescribed is not None
    here = list(zip(r[:, None], R[:, None], strict=True))
    return (m.prescribed(here, V, W, t) - m.prescribed(here, 0 * V, 0 * W, t)).T


def condition_loads(m: Mechanism, here: Motion) -> Array:
    """What the conditions exert on every body: forces, and torques about the mass centres (2, bodies, 3), global."""
    k = len(m.bodies)
    found = np.zeros((2, k, 3))
    hats = np.stack([np.cross(e, np.eye(3)).T for e in np.eye(3)])
    for i in range(k):
        units = np.zeros((k, 6, 3))
        units[i, :3] = units[i, 3:] = np.eye(3)
        V, W = units * np.repeat([1.0, 0.0], 3)[:, None], units * np.repeat([0.0, 1.0], 3)[:, None]
        C = np.zeros((0, 6))
        if m.closure is not None:
            turn = np.concatenate([np.zeros((3, 3, 3)), hats]) @ here.R[i] * 1j * TINY
            moved = [(here.r[b] + 1j * TINY * V[b], here.R[b] + (turn if b == i else 0j * turn)) for b in range(k)]
            C = m.closure(moved, np.full(6, here.t)).imag.T / TINY
        if m.prescribed is not None:
            C = np.concatenate([C, prescribed_columns(m, here.r, here.R, V, W, here.t)])
        found[:, i] = (here.multipliers @ C).reshape(2, 3)
    return found


def closed(m: Mechanism, q: Array, qd: Array, free: Sequence[int]) -> tuple[Array, Array]:
    """The same state with the closure fulfilled at t = 0 by the coordinates and rates that are not in `free`."""
    q, qd = q.copy(), qd.copy()
    bound = [i for i in range(len(q)) if i not in free]
    for _ in range(20):
        gap = poses(m, q[:, None], np.zeros(1))[2][0]
        C = partial(m, q, 0.0)[2]
        q[bound] -= np.linalg.solve(C[bound].T, gap)
    rate = poses(m, q[:, None] + 0j, np.array([1j * TINY]))[2][0].imag / TINY
    qd[bound] = np.linalg.solve(C[bound].T, -rate - C[list(free)].T @ qd[list(free)])
    return q, qd


def simulate(m: Mechanism, q: Array, qd: Array, times: Sequence[float]) -> list[Motion]:
    """The motion from t = 0 at these times, which begin with 0."""
    n = len(q)

    def flow(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], motion(m, t, y[:n], y[n:]).qdd])

    state, found = np.concatenate([q, qd]), [motion(m, times[0], q, qd)]
    for start, end in pairwise(times):
        if n:
            done = solve_ivp(flow, (start, end), state, "DOP853", rtol=1e-10, atol=1e-11)
            assert done.success
            state = done.y[:, -1]
        found.append(motion(m, end, state[:n], state[n:]))
    return found


def net_load(m: Mechanism, here: Motion, members: Sequence[int], point: Array) -> tuple[Array, Array]:
    """What must act on some bodies, beside weight and conditions, that they move as they do: force,
    and torque about a point; global."""
    force, torque = np.zeros(3), np.zeros(3)
    loads = condition_loads(m, here)
    for i in members:
        J = here.R[i] @ m.bodies[i].inertia @ here.R[i].T
        f = m.bodies[i].mass * (here.a[i] - np.array(m.gravity)) - loads[0, i]
        force += f
        torque += J @ here.alpha[i] + np.cross(here.w[i], J @ here.w[i]) - loads[1, i]
        torque += np.cross(here.r[i] - point, f)
    return force, torque


def kinetic(m: Mechanism, here: Motion) -> float:
    spin = np.einsum("bji,bj->bi", here.R, here.w)
    turning = sum(w @ b.inertia @ w for b, w in zip(m.bodies, spin, strict=True))
    turning += here.qd**2 @ (m.rotors or np.zeros(len(here.qd)))
    return 0.5 * float(sum(b.mass * v @ v for b, v in zip(m.bodies, here.v, strict=True)) + turning)
