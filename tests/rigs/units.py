"""Mechanisms expressed in any system of units."""

from dataclasses import dataclass
from math import prod
from typing import Any

from lienumba.keys.units import factors
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES

X, Y, ZERO = [1, 0, 0], [0, 1, 0], [0, 0, 0]


@dataclass(frozen=True)
class Units:
    """What a metre, a kilogram and a second count in a system of units."""

    m: float = 1.0
    kg: float = 1.0
    s: float = 1.0

    @property
    def N(self) -> float:
        return self.kg * self.m / self.s**2

    @property
    def J(self) -> float:
        return self.N * self.m

    def of(self, symbols: str) -> float:
        """What a unit such as "N m" counts."""
        known = {"m": self.m, "kg": self.kg, "s": self.s, "rad": 1.0, "N": self.N, "J": self.J}
        return prod(known[symbol] ** power for symbol, power in factors(symbols) or ())


# The scales are powers of 2, so that rescaling rounds nothing.
SI, OTHER = Units(), Units(m=2.0**7, kg=2.0**-3, s=2.0**5)


def times(scale: float, values: Any) -> Any:
    """Numbers in lists of lists, scaled."""
    return [times(scale, x) for x in values] if isinstance(values, list) else scale * values


def _body(u: Units, name: str, **keys: Any) -> dict[str, Any]:
    return {"name": name, "mass": 1.5 * u.kg, "inertia": times(u.kg * u.m**2, [0.05, 0.06, 0.04]), **keys}


def _joint(u: Units, name: str, kind: str, second: str, points: Any, **keys: Any) -> dict[str, Any]:
    return {"name": name, "type": kind, "bodies": ["ground", second], "points": times(u.m, points), **keys}


def _adaptive(u: Units) -> dict[str, Any]:
    absolute = {"position": u.m, "rotation": 1.0, "velocity": u.m / u.s, "angular_velocity": 1 / u.s, "state": u.J}
    tolerance = {"relative": 1e-5, "absolute": {key: 1e-6 * x for key, x in absolute.items()}}
    return {"tolerance": tolerance, "end_time": 0.5 * u.s}


def moving(u: Units) -> dict[str, Any]:
    """A top on a spring, and a slide that is driven. Nothing is projected, so that no violation is 0."""
    swing = {"position": times(u.m, [0.3, 0, 0]), "angular_velocity": times(1 / u.s, [2.0, 1.0, 9.0])}
    tie = {
        "name": "tie", "type": "spring_damper", "bodies": ["top", "slide"],
        "points": times(u.m, [[0.1, 0.2, 0], [0, 0, 0.1]]), "free_length": 0.5 * u.m,
        "stiffness": 40 * u.N / u.m, "damping": 0.7 * u.N * u.s / u.m,
    }  # fmt: skip
    tip = {"type": "point", "body": "top", "point": times(u.m, [0, 0, 0.1])}
    return {
        "parameters": {"reach": 0.2 * u.m, "rate": 3 / u.s},
        "model": {
            "gravity": times(u.m / u.s**2, [0.5, 1.0, -9.81]),
            "bodies": [_body(u, "top", rotation=[1, 0, 0, 0], **swing), _body(u, "slide")],
            "joints": [
                _joint(u, "pivot", "spherical", "top", [ZERO, [-0.3, 0, 0]]),
                _joint(u, "rail", "prismatic", "slide", [[0, 1, 0], ZERO], axes=[X, X], references=[Y, Y]),
            ],
            "drivers": [{"name": "lift", "joint": "rail", "value": "reach*sin(rate*t)"}],
            "forces": [tie, {"type": "torque", "body": "top", "value": times(u.N * u.m, [0.1, 0.3, -0.2])}],
        },
        "quantities": [
            *({"name": f"tip{n}", "derivative": n, **tip} for n in range(3)),
            {"name": "tilt", "type": "rotation_error", "body": "top", "target": {"axis": X, "angle": 0.2}},
            {"name": "spin", "type": "angular_velocity", "body": "top", "frame": "global"},
            {"name": "load", "type": "reaction", "joint": "rail"},
            {"name": "pull", "type": "driver_effort", "driver": "lift"},
            {"name": "sum", "type": "momentum"},
            {"name": "apart", "type": "distance", "bodies": ["top", "slide"]},
            {"name": "along", "type": "joint", "joint": "rail"},
            {"name": "power", "type": "expression", "value": "pull*along.speed", "units": "N m s-1"},
        ],
        "measures": [
            {"name": "lowest", "value": "min(tip0.z)"},
            {"name": "when", "value": "time_of_max(apart.distance)"},
            {"name": "done", "value": "integral(power)"},
            {"name": "load on average", "value": "mean(load.torque.y)"},
        ],
        "integrator": _adaptive(u),
        "projection": {"position": "none", "velocity": "none"},
        "output": {
            "every": 0.1 * u.s, "joint_coordinates": True, "also": [x for x, y in OUTPUT_VARIABLES.items() if y.asked],
        },
        "sweep": {
            "runs": 2,
            "vary": {
                "bodies.top.mass": {"distribution": "uniform", "low": 1.0 * u.kg, "high": 2.0 * u.kg},
                "forces.tie.stiffness": {"distribution": "normal", "std": 2 * u.N / u.m},
            },
        },
    }  # fmt: skip


def changing(u: Units) -> dict[str, Any]:
    """A puck that falls on a floor, bounces and slides; a flap that falls on its stop; a lever that is locked."""
    flight = {"position": times(u.m, [0, 0, 0.05]), "velocity": times(u.m / u.s, [1.0, 0.3, 0])}
    floor = {
        "name": "floor", "type": "point_plane", "bodies": ["puck", "ground"], "normal": [0, 0, 1], "restitution": 0.3,
        "friction": 0.2, "rest_speed": 0.4 * u.m / u.s,
    }  # fmt: skip
    hinge = {"axes": [Y, Y], "references": [X, X], "rate": 0.0}
    return {
        "model": {
            "gravity": times(u.m / u.s**2, [0, 0, -9.81]),
            "bodies": [_body(u, "puck", rotation=[1, 0, 0, 0], **flight), _body(u, "flap"), _body(u, "lever")],
            "joints": [
                _joint(u, "hinge", "revolute", "flap", [[0, 1, 0], [-0.2, 0, 0]], angle=0.2, **hinge),
                _joint(u, "clamp", "revolute", "lever", [[0, 2, 0], [-0.2, 0, 0]], angle=0.1, locked=True, **hinge),
            ],
            "contacts": [floor],
            "limits": [{"name": "stop", "joint": "hinge", "high": 0.5, "rest_speed": 100 / u.s}],
        },
        "quantities": [
            {"name": "touch", "type": "contact", "contact": "floor"},
            {"name": "stop", "type": "limit", "limit": "stop"},
            {"name": "grip", "type": "lock", "joint": "clamp"},
        ],
        "events": [{"name": "down", "when": "touch.gap < 0"}],
        "requirements": [{"name": "soft", "value": "max(touch.normal)", "below": 50 * u.N, "probability": 0.5}],
        "integrator": _adaptive(u),
        "output": {"every": 0.05 * u.s},
    }


# Units of each number of those variables whose attribute can only say "1".
SEVERAL = {
    "multiplier": ["N"] * 5 + ["N m"] * 3 + ["N"], "driver_effort": ["N"], "tau": ["N m"] * 3 + ["N"],
    "q": ["rad"] * 3 + ["m"], "qd": ["rad s-1"] * 3 + ["m s-1"], "requirement_margin": ["N"], "change_impulse": None,
}  # fmt: skip
