"""What forces do, from tables of a scenario: forces and torques on bodies, and efforts along coordinates of joints."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from tests.oracles.mechanisms.numbers import number
from tests.oracles.mechanisms.places import Array, State, hat, log

Table = Mapping[str, Any]


class Loads(Protocol):
    """Gathers what acts at a state."""

    state: State
    t: float

    def push(self, body: str, point: Array, force: Array) -> None:
        """A force (N, global) at a global point."""

    def twist(self, body: str, torque: Array) -> None:
        """A torque (N m, global)."""

    def moving(self, body: str, point: Any) -> tuple[Array, Array]:
        """Where a point of a body is, and how fast it moves, global."""

    def turning(self, body: str) -> tuple[Array, Array]:
        """The rotation of a body, and its angular velocity, global."""

    def start(self, body: str) -> tuple[Array, Array]:
        """Position and rotation at the start."""


def value(force: Table, key: str, t: float, default: Any = 0.0) -> Any:
    x = force.get(key, default)
    return np.array([number(c)(t) for c in x]) if isinstance(x, list) else number(x)(t)


def spring_damper(force: Table, on: Loads) -> None:
    (p, u), (q, v) = (on.moving(body, x) for body, x in zip(force["bodies"], force["points"], strict=True))
    length = np.linalg.norm(q - p)
    n = (q - p) / length
    if "free_length" in force:
        free = value(force, "free_length", on.t)
    else:
        ends = [on.start(body) for body in force["bodies"]]
        a, b = (r + R @ np.array(x) for (r, R), x in zip(ends, force["points"], strict=True))
        free = np.linalg.norm(b - a)
    pull = value(force, "stiffness", on.t) * (length - free) + value(force, "damping", on.t) * (n @ (v - u))
    _between(force, on, p, q, pull * n)


def point_mass_gravity(force: Table, on: Loads) -> None:
    points = force.get("points", [[0.0] * 3] * 2)
    (p, _), (q, _) = (on.moving(body, x) for body, x in zip(force["bodies"], points, strict=True))
    d = q - p
    _between(force, on, p, q, value(force, "mu", on.t) * force["mass of the second"] * d / np.linalg.norm(d) ** 3)


def _between(force: Table, on: Loads, p: Array, q: Array, pull: Array) -> None:
    """pull: on the first body; the opposite on the second."""
    first, second = force["bodies"]
    on.push(first, p, pull)
    on.push(second, q, -pull)


def push(force: Table, on: Loads) -> None:
    R, _ = on.turning(force["body"])
    f = value(force, "value", on.t)
    on.push(force["body"], on.moving(force["body"], force["point"])[0], R @ f if force["frame"] == "body" else f)


def torque(force: Table, on: Loads) -> None:
    R, _ = on.turning(force["body"])
    f = value(force, "value", on.t)
    on.twist(force["body"], R @ f if force["frame"] == "body" else f)


def drag(force: Table, on: Loads) -> None:
    p, v = on.moving(force["body"], force["point"])
    size = value(force, "linear", on.t) + value(force, "quadratic", on.t) * np.linalg.norm(v)
    on.push(force["body"], p, -size * v)


def bushing(force: Table, on: Loads) -> None:
    (first, second), zero = force["bodies"], [0.0] * 3
    (p, u), (q, v) = (on.moving(body, x) for body, x in zip(force["bodies"], force["points"], strict=True))
    (A, wa), (B, wb) = on.turning(first), on.turning(second)
    d, rate = A.T @ (q - p), A.T @ (v - u - np.cross(wa, q - p))
    pull = A @ (value(force, "stiffness", on.t, zero) * d + value(force, "damping", on.t, zero) * rate)
    since = A.T @ B @ (on.start(first)[1].T @ on.start(second)[1]).T
    turn = log(since)
    back = _rate_of_vector(turn)
    turns = back @ (A.T @ (wb - wa))
    wring = value(force, "rotational_stiffness", on.t, zero) * turn
    wring = wring + value(force, "rotational_damping", on.t, zero) * turns
    torque = A @ (back.T @ wring)
    on.push(second, q, -pull)
    on.push(first, q, pull)  # where the second body feels it: the frame is the first's
    on.twist(second, -torque)
    on.twist(first, torque)


def _rate_of_vector(v: Array) -> Array:
    """From an angular velocity, along the axes that stay, to the rate of the rotation vector."""
    angle, S = float(np.linalg.norm(v)), hat(v)
    rest = 1 / 12 + angle**2 / 720 + angle**4 / 30240
    if angle > 1e-2:
        rest = 1 / angle**2 - (1 + np.cos(angle)) / (2 * angle * np.sin(angle))
    return np.eye(3) - 0.5 * S + rest * (S @ S)


ON_BODIES: dict[str, Callable[[Table, Loads], None]] = {
    "spring_damper": spring_damper,
    "point_mass_gravity": point_mass_gravity,
    "force": push,
    "torque": torque,
    "drag": drag,
    "bushing": bushing,
}


# ---------------------------------------------------------------- along a coordinate: effort of its value and rate
def torsion_spring(force: Table, t: float, q: float, rate: float) -> float:
    stretched = q - value(force, "free_angle", t)
    return float(-value(force, "stiffness", t) * stretched - value(force, "damping", t) * rate)


def actuator(force: Table, t: float, q: float, rate: float) -> float:
    target = number(force.get("target", 0.0))
    wanted = np.imag(target(t + 1e-30j)) / 1e-30
    effort = value(force, "value", t) + value(force, "stiffness", t) * (np.real(target(t)) - q)
    effort = effort + value(force, "damping", t) * (wanted - rate)
    if "limit" in force:
        return float(np.clip(effort, -value(force, "limit", t), value(force, "limit", t)))
    return float(np.clip(effort, *value(force, "limits", t)) if "limits" in force else effort)


def friction(force: Table, t: float, q: float, rate: float) -> float:
    slides = np.tanh(rate / value(force, "velocity", t, 1e-3))
    return float(-value(force, "viscous", t) * rate - value(force, "coulomb", t) * slides)


def end_stop(force: Table, t: float, q: float, rate: float) -> float:
    """A spring beyond each stop, with a damper that never pulls."""
    for stop, outwards in (("lower", -1.0), ("upper", 1.0)):
        depth = outwards * (q - value(force, stop, t)) if stop in force else 0.0
        if depth > 0.0:
            back = value(force, "stiffness", t) * depth + value(force, "damping", t) * outwards * rate
            return float(-outwards * max(back, 0.0))
    return 0.0


ALONG_JOINTS: dict[str, Callable[[Table, float, float, float], float]] = {
    "torsion_spring": torsion_spring,
    "actuator": actuator,
    "friction": friction,
    "end_stop": end_stop,
}
