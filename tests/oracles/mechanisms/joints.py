"""What joints and drivers hold, from tables of a scenario: functions of places that stay 0, and coordinates."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tests.oracles.mechanisms.numbers import number, vector
from tests.oracles.mechanisms.places import (
    Array,
    Function,
    Places,
    angle,
    cross,
    direction_of,
    dot,
    exp,
    log,
    point_of,
    vee,
)

Table = Mapping[str, Any]


class Sides:
    """Of a joint at places: points p, q, their distance d, and of both sides the axes z and references x."""

    def __init__(self, joint: Table, places: Places) -> None:
        a, b = joint["bodies"]
        self.bodies = places[a][1], places[b][1]
        if "points" in joint:
            self.p, self.q = (point_of(places, i, x) for i, x in zip((a, b), joint["points"], strict=True))
            self.d = self.q - self.p
        if "axes" in joint:
            self.far = int(np.argmin(np.abs(joint["axes"][0])))
            self.z = tuple(direction_of(places, i, x) for i, x in zip((a, b), joint["axes"], strict=True))
        if "references" in joint:
            self.x = tuple(direction_of(places, i, x) for i, x in zip((a, b), joint["references"], strict=True))

    def across(self, v: Array) -> list[Array]:
        """The components of v across the first axis."""
        far = cross(self.z[0], self._any())
        return [dot(v, far), dot(v, cross(self.z[0], far))]

    def _any(self) -> Array:
        """The axis of the first body that is farthest from the joint's."""
        return self.bodies[0][..., self.far]

    def turn(self) -> Array:
        """The angle from the first reference to the second about the first axis."""
        return angle(dot(self.x[0], self.x[1]), dot(cross(self.z[0], self.x[0]), self.x[1]))

    def slide(self) -> Array:
        return dot(self.z[0], self.d)

    def together(self) -> list[Array]:
        return list(np.moveaxis(self.d, -1, 0))

    def parallel(self) -> list[Array]:
        return self.across(self.z[1])

    def pins(self) -> list[Array]:
        first = angle(dot(self.x[0], self.z[1]), dot(cross(self.z[0], self.x[0]), self.z[1]))
        second = angle(dot(self.z[0], self.x[1]), dot(cross(self.z[1], self.z[0]), self.x[1]))
        return [first, second]


HELD: dict[str, Callable[[Table, Sides], list[Array]]] = {
    "spherical": lambda j, s: s.together(),
    "revolute": lambda j, s: [*s.together(), *s.parallel()],
    "universal": lambda j, s: [*s.together(), dot(*s.z)],
    "cylindrical": lambda j, s: [*s.across(s.d), *s.parallel()],
    "prismatic": lambda j, s: [*s.across(s.d), *s.parallel(), s.turn()],
    "fixed": lambda j, s: [*s.together(), *s.parallel(), s.turn()],
    "planar": lambda j, s: [s.slide(), *s.parallel()],
    "point_on_line": lambda j, s: s.across(s.d),
    "point_in_plane": lambda j, s: [s.slide()],
    "distance": lambda j, s: [np.sqrt(dot(s.d, s.d)) - j["length"]],
    "parallel_axes": lambda j, s: s.parallel(),
    "perpendicular_axes": lambda j, s: [dot(*s.z)],
    "screw": lambda j, s: [*s.across(s.d), *s.parallel(), s.slide() - j["pitch"] / (2 * np.pi) * s.turn()],
}
ANGLE = {"angle": lambda s: s.turn()}
SLIDE = {"displacement": lambda s: s.slide()}
COORDINATES: dict[str, dict[str, Callable[[Sides], Array]]] = {
    "revolute": ANGLE,
    "cylindrical": SLIDE | ANGLE,
    "screw": ANGLE | SLIDE,
    "prismatic": SLIDE,
    "point_on_line": SLIDE,
    "planar": {
        "x": lambda s: dot(s.x[0], s.d),
        "y": lambda s: dot(cross(s.z[0], s.x[0]), s.d),
        "angle": lambda s: s.turn(),
    },
    "universal": {"first_angle": lambda s: s.pins()[0], "second_angle": lambda s: s.pins()[1]},
}
COUPLED = ("gear", "coupler")
ROTOR = {"revolute": "angle", "screw": "angle", "prismatic": "displacement"}


def coordinate(joint: Table, kind: str) -> Function:
    value = COORDINATES[joint["type"]][kind]
    return lambda places, t: value(Sides(joint, places))[:, None]


def rotation_vector(joint: Table) -> Function:
    """That of the second body against the first."""

    def f(places: Places, t: Any) -> Array:
        A, B = Sides(joint, places).bodies
        return log(A.swapaxes(-1, -2) @ B)

    return f


def held(joint: Table, joints: Mapping[str, Table]) -> Function:
    """What a joint keeps as it is; of a screw as at the start."""
    if joint["type"] in COUPLED:
        first, second = (
            coordinate(joints[name], kind) for name, kind in zip(joint["joints"], joint["coordinates"], strict=True)
        )
        return lambda places, t: second(places, t) - joint["ratio"] * first(places, t) - joint["offset"]
    rows = HELD[joint["type"]]
    return lambda places, t: np.stack(rows(joint, Sides(joint, places)), -1)


# ---------------------------------------------------------------- drivers
def form(driver: Table) -> str:
    return str(driver["motion"]) if "motion" in driver else "rate" if "rate" in driver else "value"


def driven(driver: Table, joints: Mapping[str, Table]) -> Function:
    """What a driver keeps at 0, or, where it prescribes a rate, constant; not of angular velocities."""
    if "joint" in driver:
        where = coordinate(joints[driver["joint"]], driver["coordinate"])
        wanted = number(driver["value"] if "value" in driver else integral(driver["rate"]))
        return lambda places, t: where(places, t) - np.reshape(wanted(t), (-1, 1))
    wanted3, body = vector(driver["value"]), driver["body"]
    if driver["motion"] == "point":
        return lambda places, t: point_of(places, body, driver["point"]) - wanted3(t)
    return lambda places, t: vee(exp(wanted3(t)).swapaxes(-1, -2) @ places[body][1])


def integral(rate: str) -> str:
    """Of a + b*sin(w*t), which is all that is drawn."""
    a, rest = rate.split(" + ")
    b, inner = rest.split("*sin(")
    w = inner.removesuffix("*t)")
    return f"{a}*t - {b}*cos({w}*t)/{w}"


def spin(driver: Table, R: Array, t: float) -> tuple[Array, Array, Array]:
    """Of a prescribed angular velocity: the rows for w (body axes), its value and what w' shall be by them."""
    wanted = vector(driver["value"])
    rate = wanted(t + 1j * 1e-30).imag.reshape(3) / 1e-30
    return np.eye(3) if driver["frame"] == "body" else R, wanted(t).real.reshape(3), rate
