"""A small engine that shares nothing with lienumba: bodies by all their velocities, dense least squares, DOP853.

It reads the tables of a scenario, with all states, frames and coordinates given. Constraints are functions of places;
C comes from them by complex steps, what accelerations they ask for by Cauchy's formula (`places`). Newton's and Euler's
equations with multipliers are solved as they stand, by least squares, where rows may be redundant.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tests.oracles.mechanisms import forces, joints
from tests.oracles.mechanisms.places import Array, Function, Places, State, cross, hat

NEGLIGIBLE = 1e-9  # singular values of C, its rows of length 1
LEAST = 3e-3  # of those that are more: nearer to a singular position, rounding and errors grow without a bound


class SingularError(Exception):
    """A motion comes near a singular position."""


@dataclass(frozen=True)
class Motion:
    """At a time: u' (6 k), and what every joint and driver adds to the generalised forces (6 k), by name;
    redundant: rows of C that say what others say; condition: of the others."""

    t: float
    state: State
    accelerations: Array
    loads: Mapping[str, Array]
    efforts: Mapping[str, Array]
    redundant: int
    condition: float

    @property
    def unique(self) -> bool:
        """Whether loads follow from the motion."""
        return not self.redundant


class Mechanism:
    """Of the table `model` of a scenario."""

    def __init__(self, model: Mapping[str, Any]) -> None:
        self.model = model
        self.bodies = {b["name"]: b for b in model["bodies"]}
        self.joints = {j["name"]: j for j in model.get("joints", [])}
        self.drivers = {d["name"]: d for d in model.get("drivers", [])}
        self.mass = np.array([b["mass"] for b in self.bodies.values()])
        self.inertia = np.array([b["inertia"] for b in self.bodies.values()])
        self.functions: dict[str, Function] = {name: joints.held(j, self.joints) for name, j in self.joints.items()}
        self.spun = {n: d for n, d in self.drivers.items() if joints.form(d) == "angular_velocity"}
        kept = {n: joints.driven(d, self.joints) for n, d in self.drivers.items() if n not in self.spun}
        self.functions |= kept
        along = [f for f in model.get("forces", []) if f["type"] in forces.ALONG_JOINTS]
        self.along = [(f, joints.coordinate(self.joints[f["joint"]], f["coordinate"])) for f in along]
        rotors = [(j["armature"], j, joints.ROTOR[j["type"]]) for j in self.joints.values() if j.get("armature")]
        self.rotors = [(size, joints.coordinate(j, kind)) for size, j, kind in rotors]

    @cached_property
    def start(self) -> State:
        """As given; an inertia that is not, of the identity."""
        every = self.bodies.values()
        given = [np.array([b[key] for b in every], float) for key in ("position", "rotation")]
        v, w = (np.array([b.get(key, [0.0] * 3) for b in every], float) for key in ("velocity", "angular_velocity"))
        return State(tuple(self.bodies), *given, v, w)

    def index(self, body: str) -> slice:
        first = 6 * list(self.bodies).index(body)
        return slice(first, first + 6)

    def constraints(self, state: State, t: float) -> tuple[Array, Array, Array, dict[str, slice]]:
        """C (rows, 6 k), C u - what C u shall be, what C u' shall be, and whose rows are which."""
        C, off, wanted, rows = [np.zeros((0, state.u.size))], [np.zeros(0)], [np.zeros(0)], {}
        if self.functions:
            sizes: list[int] = []

            def every(places: Places, t: Any) -> Array:
                parts = [f(places, t) for f in self.functions.values()]
                sizes[:] = [p.shape[-1] for p in parts]
                return np.concatenate(parts, axis=-1)

            C.append(state.partial(every, t))
            rate, bias = state.along(every, t)
            off.append(rate)
            wanted.append(-bias)
            ends = np.cumsum([0, *sizes]).tolist()
            rows = {name: slice(a, b) for name, a, b in zip(self.functions, ends[:-1], ends[1:], strict=True)}
        for name, driver in self.spun.items():
            own = self.index(driver["body"])
            first = sum(len(c) for c in C)
            E, value, rate = joints.spin(driver, state.R[own.start // 6], t)
            D = np.zeros((3, state.u.size))
            D[:, own.start + 3 : own.stop] = E
            C, off, wanted = [*C, D], [*off, D @ state.u - value], [*wanted, rate]
            rows[name] = slice(first, first + 3)
        return np.concatenate(C), np.concatenate(off), np.concatenate(wanted), rows

    def forced(self, state: State, t: float) -> tuple[Array, Array]:
        """The mass matrix (6 k, 6 k) with rotors, and the generalised forces (6 k)."""
        k, on = len(self.bodies), _Loads(self, state, t)
        M = np.zeros((6 * k, 6 * k))
        for i, (m, J) in enumerate(zip(self.mass, self.inertia, strict=True)):
            M[6 * i : 6 * i + 3, 6 * i : 6 * i + 3], M[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = m * np.eye(3), J
            on.Q[6 * i : 6 * i + 3] += m * np.array(self.model.get("gravity", [0.0, 0.0, 0.0]))
            on.Q[6 * i + 3 : 6 * i + 6] -= cross(state.w[i], J @ state.w[i])
        for force in self.model.get("forces", []):
            if force["type"] in forces.ON_BODIES:
                heavy = self.bodies[force["bodies"][1]]["mass"] if "bodies" in force else 0.0
                forces.ON_BODIES[force["type"]]({**force, "mass of the second": heavy}, on)
        for force, q in self.along:
            c = state.partial(q, t)[0]
            value = float(q(state.places(), t)[0, 0].real)
            on.Q += c * forces.ALONG_JOINTS[force["type"]](force, t, value, float(c @ state.u))
        for size, q in self.rotors:
            c, (_, bias) = state.partial(q, t)[0], state.along(q, t)
            M, on.Q = M + size * np.outer(c, c), on.Q - size * c * bias[0]
        return M, on.Q

    def motion(self, state: State, t: float) -> Motion:
        M, Q = self.forced(state, t)
        C, _, wanted, rows = self.constraints(state, t)
        columns = 1.0 / np.sqrt(np.diag(M))
        lengths = np.linalg.norm(C * columns, axis=1)
        D = np.concatenate([columns, 1.0 / lengths])
        K = np.block([[M, -C.T], [C, np.zeros((len(C), len(C)))]]) * D * D[:, None]
        x = D * np.linalg.lstsq(K, D * np.concatenate([Q, wanted]), rcond=NEGLIGIBLE)[0]
        a, mu = x[: len(Q)], x[len(Q) :]
        sizes = np.linalg.svd(C * columns / lengths[:, None], compute_uv=False) if len(C) else np.zeros(0)
        kept = sizes[sizes > NEGLIGIBLE]
        loads = {name: C[own].T @ mu[own] for name, own in rows.items()}
        efforts = {name: mu[rows[name]] for name in self.drivers}
        return Motion(t, state, a, loads, efforts, len(C) - len(kept), float(kept[0] / kept[-1]) if len(kept) else 1.0)

    def compatible(self, state: State) -> State:
        """The state with the nearest velocities that the constraints allow."""
        C, off, _, _ = self.constraints(state, 0.0)
        _, off, _, _ = self.constraints(
            state.with_velocities(u := state.u - np.linalg.lstsq(C, off, rcond=NEGLIGIBLE)[0]), 0.0
        )
        return state.with_velocities(u - np.linalg.lstsq(C, off, rcond=NEGLIGIBLE)[0])

    def slope(self, state: State, t: float) -> Array:
        """How `State.flat` changes."""
        found = self.motion(state, t)
        if found.condition * LEAST > 1.0:
            raise SingularError(f"condition {found.condition:.1e} at {t:.3g} s")
        a = found.accelerations.reshape(-1, 6)
        turning = state.R @ hat(state.w)
        return np.concatenate([state.v.ravel(), turning.ravel(), a[:, :3].ravel(), a[:, 3:].ravel()])

    def run(self, times: Sequence[float], tolerance: float = 1e-11) -> list[Motion]:
        """From the start on, at these times."""
        s = self.start

        def slope(t: float, y: Array) -> Array:
            return self.slope(s.like(y), t)

        done = solve_ivp(slope, (0.0, times[-1]), s.flat, "DOP853", times, rtol=tolerance, atol=0.01 * tolerance)
        assert done.success, done.message
        return [self.motion(s.like(y), t) for t, y in zip(done.t.tolist(), done.y.T, strict=True)]

    def kinetic(self, motion: Motion) -> float:
        u = motion.state.u
        return float(0.5 * u @ self.forced(motion.state, motion.t)[0] @ u)


class _Loads:
    """See `forces.Loads`; Q (6 k): what has been gathered."""

    def __init__(self, mechanism: Mechanism, state: State, t: float) -> None:
        self.mechanism, self.state, self.t = mechanism, state, t
        self.Q = np.zeros_like(state.u)

    def push(self, body: str, point: Array, force: Array) -> None:
        if body != "ground":
            own = self.mechanism.index(body)
            i = own.start // 6
            self.Q[own.start : own.start + 3] += force
            self.twist(body, cross(point - self.state.r[i], force))

    def twist(self, body: str, torque: Array) -> None:
        if body != "ground":
            own = self.mechanism.index(body)
            self.Q[own.start + 3 : own.stop] += self.state.R[own.start // 6].T @ torque

    def moving(self, body: str, point: Any) -> tuple[Array, Array]:
        arm = np.array(point, float)
        if body == "ground":
            return arm, np.zeros(3)
        R, w = self.turning(body)
        i = self.mechanism.index(body).start // 6
        return self.state.r[i] + R @ arm, self.state.v[i] + cross(w, R @ arm)

    def turning(self, body: str) -> tuple[Array, Array]:
        if body == "ground":
            return np.eye(3), np.zeros(3)
        i = self.mechanism.index(body).start // 6
        return self.state.R[i], self.state.R[i] @ self.state.w[i]

    def start(self, body: str) -> tuple[Array, Array]:
        if body == "ground":
            return np.zeros(3), np.eye(3)
        i = self.mechanism.index(body).start // 6
        return self.mechanism.start.r[i], self.mechanism.start.R[i]
