"""A hub and a chain of panels in the plane, minimal coordinates: springs and dampers at the hinges, which are held or
latch. Latches are plastic: momenta of what stays free do not jump. SciPy's DOP853, each change a start of its own.

The hub is free (x, y, turn) or, without mass, the ground. Nothing is taken from lienumba.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Chain:
    """Panels of masses m, lengths l and inertias J (about their middle), each hinged at the end of the one before; the
    first one at `arm` from the middle of the hub. Hinge torque on its panel: stiffness (free - q) - damping q'."""

    m: np.ndarray
    l: np.ndarray  # noqa: E741
    J: np.ndarray
    stiffness: np.ndarray
    free: np.ndarray
    damping: np.ndarray
    hub: tuple[float, float, float] = (0.0, 0.0, 0.0)  # mass, inertia, arm

    @property
    def base(self) -> int:
        """How many coordinates of the hub stand before those of the hinges."""
        return 3 if self.hub[0] else 0

    def _bodies(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Jacobians of the middles (bodies, 2, n), and of the turns (bodies, n); the hub first."""
        k, b, n = len(self.m), self.base, len(q)
        turns = np.zeros((k + 1, n))
        turns[:, 2 if b else 0 : 3 if b else 0] = 1.0
        for i in range(k):
            turns[i + 1 :, b + i] = 1.0
        angle = turns @ q
        arms = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        point = np.zeros((2, n))
        if b:
            point[:, :2] = np.eye(2)
        middles = [point]
        point = point + self.hub[2] * np.outer(arms[0], turns[0])
        for i in range(k):
            lever = np.outer(arms[i + 1], turns[i + 1])
            middles.append(point + 0.5 * self.l[i] * lever)
            point = point + self.l[i] * lever
        return np.array(middles), turns

    def _centripetal(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Accelerations of the middles where the coordinates do not accelerate (bodies, 2)."""
        _, turns = self._bodies(q)
        angle, rate = turns @ q, turns @ dq
        inwards = -np.stack([np.cos(angle), np.sin(angle)], axis=1) * (rate**2)[:, None]
        out, point = [np.zeros(2)], self.hub[2] * inwards[0]
        for i, length in enumerate(self.l):
            out.append(point + 0.5 * length * inwards[i + 1])
            point = point + length * inwards[i + 1]
        return np.array(out)

    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array([self.hub[0], *self.m]), np.array([self.hub[1], *self.J])

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        (m, J), (middles, turns) = self._weights(), self._bodies(q)
        return np.einsum("b,bxi,bxj->ij", m, middles, middles) + np.einsum("b,bi,bj->ij", J, turns, turns)

    def torques(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        b = self.base
        return np.array([*np.zeros(b), *(self.stiffness * (self.free - q[b:]) - self.damping * dq[b:])])

    def rates(self, y: np.ndarray, free: np.ndarray) -> np.ndarray:
        """q', q'' where only the coordinates `free` (a mask) accelerate."""
        n = len(y) // 2
        q, dq = y[:n], y[n:]
        m, _ = self._weights()
        middles, _ = self._bodies(q)
        load = self.torques(q, dq) - np.einsum("b,bxi,bx->i", m, middles, self._centripetal(q, dq))
        ddq = np.zeros(n)
        ddq[free] = np.linalg.solve(self.mass_matrix(q)[np.ix_(free, free)], load[free])
        return np.concatenate([dq, ddq])

    def energy(self, q: np.ndarray, dq: np.ndarray) -> float:
        springs = 0.5 * self.stiffness @ (self.free - q[self.base :]) ** 2
        return float(0.5 * dq @ self.mass_matrix(q) @ dq + springs)

    def latched(self, q: np.ndarray, dq: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Rates behind a latch that leaves `free`: their momenta stay."""
        M, after = self.mass_matrix(q), np.zeros_like(dq)
        after[free] = np.linalg.solve(M[np.ix_(free, free)], M[free] @ dq)
        return after

    def momenta(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Linear (2) and angular momentum about the origin (1) of a free chain."""
        (m, J), (middles, turns) = self._weights(), self._bodies(q)
        v, angle = middles @ dq, turns @ q
        along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        r, point = [q[:2]], q[:2] + self.hub[2] * along[0]
        for i, length in enumerate(self.l):
            r.append(point + 0.5 * length * along[i + 1])
            point = point + length * along[i + 1]
        spin = sum(m[i] * (r[i][0] * v[i][1] - r[i][1] * v[i][0]) for i in range(len(m))) + J @ (turns @ dq)
        return np.array([*(m @ v), spin])


@dataclass
class Course:
    """What happened: times, hinges, what they did, energies lost; and the end."""

    times: list[float] = field(default_factory=list)
    hinges: list[int] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)
    lost: list[float] = field(default_factory=list)
    q: np.ndarray = field(default_factory=lambda: np.zeros(0))
    dq: np.ndarray = field(default_factory=lambda: np.zeros(0))


def deploy(
    chain: Chain, q: np.ndarray, dq: np.ndarray, latch: np.ndarray, let_go: Sequence[float], end: float
) -> Course:
    """Hinge i is held until let_go[i] (0: free from the start), and latches where its angle reaches latch[i]."""
    k, b = len(chain.m), chain.base
    held = np.array(let_go) > 0
    done, course, t = np.zeros(k, bool), Course(), 0.0
    pending = sorted({x for x in let_go if 0 < x < end})
    signs = np.sign(latch - q[b:])
    while True:
        free = np.concatenate([np.ones(b, bool), ~held & ~done])
        stop = pending[0] if pending else end
        watched = [i for i in range(k) if free[b + i]]
        events = []
        for i in watched:
            event = lambda t, y, i=i: signs[i] * (y[b + i] - latch[i])  # noqa: E731
            event.terminal, event.direction = True, 1  # type: ignore[attr-defined]
            events.append(event)
        run = solve_ivp(
            lambda t, y, free=free: chain.rates(y, free), (t, stop), np.concatenate([q, dq]),
            method="DOP853", rtol=1e-13, atol=1e-14, events=events or None,
        )  # fmt: skip
        y, t = run.y[:, -1], float(run.t[-1])
        q, dq = y[: len(q)], y[len(q) :]
        if run.status == 1:
            i = next(i for i, found in zip(watched, run.t_events, strict=True) if len(found))
            before = chain.energy(q, dq)
            done[i] = True
            dq = chain.latched(q, dq, np.concatenate([np.ones(b, bool), ~held & ~done]))
            course.lost.append(before - chain.energy(q, dq))
            kind, hinges = "locked", [i]
        elif pending:
            pending.pop(0)
            hinges = [i for i in range(k) if let_go[i] == stop]
            held[hinges] = False
            course.lost += [0.0] * len(hinges)
            kind = "released"
        else:
            course.q, course.dq = q, dq
            return course
        course.times += [t] * len(hinges)
        course.hinges += hinges
        course.kinds += [kind] * len(hinges)
