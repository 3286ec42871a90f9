"""A valid scenario with a joint, driver and force of every kind, as a dict."""

from typing import Any

UP, ACROSS = [0, 0, 1], [1, 0, 0]
POINTS, AXES = [[0, 0, 0], [0, 0, 0]], [UP, UP]
HELD: dict[str, Any] = {"points": POINTS, "axes": AXES}

# One body on the ground for each joint; all in the origin.
ON_GROUND: dict[str, dict[str, Any]] = {
    "spherical": {"points": POINTS},
    "revolute": HELD | {"references": [ACROSS, ACROSS], "angle": 0.0, "rate": 0.5},
    "universal": {"at": [0, 0, 0], "axis": [UP, ACROSS]},
    "cylindrical": HELD | {"displacement": 0.0, "speed": 0.1},
    "prismatic": HELD | {"references": [ACROSS, ACROSS]},
    "fixed": {"at": [0, 0, 0]},
    "planar": HELD,
    "point_on_line": {"points": POINTS, "axes": [UP], "speed": 0.1},
    "point_in_plane": {"at": [0, 0, 0], "axis": UP},
    "distance": {"points": [[0, 0, 1], [0, 0, 0]], "length": 1.0},
    "parallel_axes": {"axes": AXES},
    "perpendicular_axes": {"axis": [UP, ACROSS]},
    "screw": HELD | {"pitch": 0.01},
}
BODIES: list[dict[str, Any]] = [
    {"name": f"b_{kind}", "mass": 1.5, "inertia": [0.1, 0.2, 0.25], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    for kind in ON_GROUND
] + [
    {"name": "flyer", "mass": 1.0, "inertia": [1, 2, 2, 0, 0, 0.1], "relative_to": "b_spherical",
     "guess": {"position": [0, 1, 0], "rotation": {"axis": UP, "angle": 0.1}}},
]  # fmt: skip
JOINTS: list[dict[str, Any]] = [
    {"name": kind, "type": kind, "bodies": ["ground", f"b_{kind}"]} | keys for kind, keys in ON_GROUND.items()
] + [
    {"name": "gear", "type": "gear", "joints": ["revolute", "cylindrical"], "coordinates": ["angle", "angle"],
     "ratio": -2.0},
    {"name": "coupler", "type": "coupler", "joints": ["prismatic", "point_on_line"], "ratio": 0.5, "offset": 0.0},
]  # fmt: skip
DRIVERS: list[dict[str, Any]] = [
    {"name": "pull", "joint": "prismatic", "value": "0.2*t"},
    {"joint": "screw", "coordinate": "angle", "rate": 0.1},
    {"name": "carry", "body": "flyer", "motion": "point", "point": [0, 0, 0.1], "value": [0, "1 + t", 0.1]},
    {"name": "spin", "body": "b_planar", "motion": "angular_velocity", "frame": "body", "value": [0, 0, "2*t"]},
    {"name": "point", "body": "b_spherical", "motion": "orientation", "value": [0, 0, "t**2"]},
]
PAIR: dict[str, Any] = {"bodies": ["ground", "flyer"], "points": [[0, 0, 0.1], [0, 0, 0]]}
FORCES: list[dict[str, Any]] = [
    {"type": "spring_damper", "stiffness": 10, "damping": "1 + t", "free_length": 0.5} | PAIR,
    {"name": "push", "type": "force", "body": "flyer", "point": [0, 0, 0.1], "frame": "body", "value": [0, "t", 1]},
    {"name": "turn", "type": "torque", "body": "flyer", "value": [0, 0, 1]},
    {"name": "coil", "type": "torsion_spring", "joint": "revolute", "stiffness": 1, "damping": 1, "free_angle": 0.1},
    {"name": "servo", "type": "actuator", "joint": "cylindrical", "coordinate": "displacement", "stiffness": 3,
     "damping": 1, "target": "sin(t)", "limit": 5},
    {"name": "rub", "type": "friction", "joint": "revolute", "viscous": 0.1, "coulomb": 1, "velocity": 0.01},
    {"name": "stop", "type": "end_stop", "joint": "prismatic", "lower": -1, "upper": 1, "stiffness": 10},
    {"name": "mount", "type": "bushing", "stiffness": [1, 2, 3], "rotational_damping": [0, "t", 1]} | PAIR,
    {"name": "air", "type": "drag", "body": "flyer", "linear": 0.1, "quadratic": 0.1},
    {"name": "planet", "type": "point_mass_gravity", "mu": 3.0} | PAIR,
]  # fmt: skip
EVERY_LAW: dict[str, Any] = {
    "model": {"gravity": [0, 0, "-9.81*cos(t)"], "bodies": BODIES, "joints": JOINTS, "drivers": DRIVERS,
              "forces": FORCES},
    "integrator": {"step": 1e-3, "end_time": 0.01},
    "sweep": {"runs": 3, "vary": {
        "forces.coil.stiffness": {"distribution": "normal", "std": 0.1},
        "drivers.driver_2.rate": {"distribution": "uniform", "low": 0.1, "high": 0.2},
        "joints.gear.ratio": {"distribution": "normal", "std": 0.1, "relative": True},
    }},
}  # fmt: skip


def alone(kind: str, index: int) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """A scenario with one joint, driver or force and what it refers to, and the place of that one."""
    model = EVERY_LAW["model"]
    item = model[kind][index]
    joints = list(item.get("joints", [item["joint"]] if "joint" in item else []))
    kept = [joint for joint in model["joints"] if joint["name"] in joints or joint is item]
    names = {name for table in [item, *kept] for name in [*table.get("bodies", ()), table.get("body")]}
    names |= {body["relative_to"] for body in BODIES if body["name"] in names and "relative_to" in body}
    small = {
        "gravity": model["gravity"],
        "bodies": [body for body in BODIES if body["name"] in names],
        "joints": kept,
        "drivers": [item] if kind == "drivers" else [],
        "forces": [item] if kind == "forces" else [],
    }
    place = small[kind].index(item)
    return {"model": small, "integrator": EVERY_LAW["integrator"]}, ("model", kind, place)
