"""A tree that has a joint of every type with coordinates, and laws along what laws may act along."""

from collections.abc import Sequence
from typing import Any

X, Y, Z = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
COORDINATES = {
    "crank": "rad", "slide": "m", "ball.rx": "rad", "ball.ry": "rad", "ball.rz": "rad", "piston.angle": "rad",
    "piston.displacement": "m", "cross.first_angle": "rad", "cross.second_angle": "rad", "puck.x": "m", "puck.y": "m",
    "puck.angle": "rad", "nut": "rad", "wheel": "rad",
}  # fmt: skip


def _body(name: str, mass: float) -> dict[str, Any]:
    return {"name": name, "mass": mass, "inertia": [0.02, 0.03, 0.04, 0.002, 0.001, -0.003]}


def _joint(name: str, kind: str, ends: tuple[str, str], axes: Any = (Z, Z), refs: Any = (X, X), **own: Any) -> Any:
    placed = {"points": [[0.1, 0.2, 0.3], [-0.2, 0.1, 0.05]], "axes": [*axes], "references": [*refs]}
    return {"name": name, "type": kind, "bodies": [*ends], **placed, **own}


def scenario(coordinates: str = "lie", only: Sequence[str] = (), **output: Any) -> dict[str, Any]:
    """A short run; of all joints, or of these, which must hang together."""
    ball = _joint("ball", "spherical", ("b", "c"))
    del ball["axes"], ball["references"]
    joints = [
        _joint("crank", "revolute", ("ground", "a"), (Y, Y), armature=0.01),
        _joint("slide", "prismatic", ("a", "b"), (X, X), (Z, Z)),
        ball,
        _joint("piston", "cylindrical", ("ground", "d")),
        _joint("cross", "universal", ("d", "e"), (Z, X), (X, Z)),
        _joint("puck", "planar", ("ground", "f"), (Y, Y)),
        _joint("nut", "screw", ("ground", "g"), pitch=0.3),
        _joint("wheel", "revolute", ("f", "h"), (X, X), (Y, Y)),
    ]
    forces: list[dict[str, Any]] = [
        {"type": "actuator", "joint": "crank", "stiffness": 4.0, "damping": 0.3, "target": "sin(2*t)"},
        {"type": "friction", "joint": "crank", "viscous": 0.05, "coulomb": 0.1, "velocity": 0.2},
        {"type": "end_stop", "joint": "slide", "stiffness": 9.0, "damping": 0.2, "lower": 5.0},
        {"type": "actuator", "joint": "slide", "value": "3*sin(5*t)"},
        {"type": "torsion_spring", "joint": "piston", "coordinate": "angle", "stiffness": 1.5, "free_angle": 0.4},
        {"type": "actuator", "joint": "piston", "coordinate": "displacement", "stiffness": 90.0, "damping": 3.0},
        {"type": "actuator", "joint": "nut", "coordinate": "displacement", "value": 20.0},
        {"type": "friction", "joint": "nut", "coordinate": "angle", "viscous": 0.2},
    ]
    drivers = [{"joint": "wheel", "value": "25*t + 0.3*sin(3*t)"}]
    joints = [x for x in joints if not only or x["name"] in only]
    forces, drivers = ([x for x in laws if not only or x["joint"] in only] for laws in (forces, drivers))
    bodies = [_body(name, 0.5 + 0.1 * n) for n, name in enumerate("abcdefgh")]
    tied = {name for x in joints for name in x["bodies"]}
    quantities = [{"name": f"of_{x['name']}", "type": "joint", "joint": x["name"]} for x in joints]
    return {
        "model": {
            "bodies": [x for x in bodies if x["name"] in tied],
            "joints": joints,
            "drivers": drivers,
            "forces": forces,
        },
        "quantities": quantities,
        "integrator": {"step": 1e-3, "end_time": 0.5, "coordinates": coordinates},
        "output": {"every": 0.05, **output},
    }
