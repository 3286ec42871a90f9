"""A mechanism with joints of several types, drivers and forces on a base that moves, and everything seen of it."""

import copy
from typing import Any

import numpy as np

import lienumba
from tests.rigs import parts
from tests.rigs.scenarios import LINK

STEP, END = 5e-4, 0.6
GRAVITY = np.array([0.5, -0.3, -9.81])
TIP, HAND, PUSH = np.array([0.1, -0.05, 0.3]), np.array([0.05, 0.1, -0.1]), np.array([0.02, 0.03, 0.1])
TILT = {"axis": [0.3, 1, 0.2], "angle": 0.7}
RIG: dict[str, Any] = {
    "parameters": {"reach": 0.3, "spring": 300},
    "model": {
        "gravity": GRAVITY.tolist(),
        "bodies": [
            parts.body("base", 4, [0.2, 0.3, 0.25], position=[0, 0, 0], rotation=[1, 0, 0, 0]),
            parts.body("arm", **LINK, position=[0, 0.3, -0.2], rotation=[1, 0, 0, 0]),
            parts.body("slider", 0.7, LINK["inertia"], position=[0.2, 0.5, -0.4], rotation=TILT),
            parts.body("ball", 0.4, [0.01, 0.012, 0.014], position=[0.3, 0.6, -0.6]),
        ],
        "joints": [
            parts.joint("mast", "cylindrical", "base", at=[0, 0, 0], axis=[0, 0, 1], rate=2.0),
            parts.hinge("shoulder", "arm", [0, 0.2, 0], [0, 1, 0.2], to="base", rate=30.0),
            parts.joint("rail", "prismatic", "slider", "arm", at=[0.2, 0.4, -0.3], axis=[0.2, 1, 0.4], speed=0.3),
            parts.joint("wrist", "spherical", "ball", "slider", at=[0.25, 0.55, -0.5]),
        ],
        "drivers": [
            {"name": "lift", "joint": "mast", "coordinate": "displacement", "value": "0.1*sin(4*t)"},
            {"name": "spin", "body": "ball", "motion": "angular_velocity", "frame": "body",
             "value": ["5*cos(3*t)", "2", "3*t"]},
        ],
        "forces": [
            {"name": "tie", "type": "spring_damper", "bodies": ["arm", "slider"], "stiffness": "spring", "damping": 2,
             "points": [[0, 0, 0], [0, 0.1, 0]]},
            {"name": "push", "type": "force", "body": "slider", "point": PUSH.tolist(), "value": ["2*sin(9*t)", 0, 1]},
            {"name": "brake", "type": "torque", "body": "arm", "frame": "body", "value": [0.3, "-0.2*t", 0.1]},
        ],
    },
    "integrator": {"step": STEP, "end_time": END},
    "output": {"every": STEP},
}  # fmt: skip
TARGET = {"rotation_vector": [0.5, 0.9, -1.1]}
QUANTITIES: list[dict[str, Any]] = [
    {"name": "tip", "type": "point", "body": "slider", "point": TIP.tolist()},
    {"name": "tip0", "type": "point", "body": "slider", "point": ["reach/3", -0.05, "reach"]},
    {"name": "hand", "type": "point", "body": "ball", "point": HAND.tolist(), "relative_to": "base"},
    *(
        {"name": f"hand{n}", "type": "point", "body": "ball", "point": HAND.tolist(), "relative_to": "base",
         "frame": "arm", "derivative": n}
        for n in range(3)
    ),
    {"name": "tip1", "type": "point", "body": "slider", "point": TIP.tolist(), "derivative": 1, "frame": "body"},
    {"name": "tip2", "type": "point", "body": "slider", "point": TIP.tolist(), "derivative": 2},
    *({"name": j, "type": "joint", "joint": j} for j in ("mast", "shoulder", "rail")),
    {"name": "pointing", "type": "rotation_error", "body": "slider", "relative_to": "base", "target": TARGET},
    {"name": "tilt", "type": "rotation_error", "body": "base"},
    {"name": "turning", "type": "angular_velocity", "body": "ball"},
    {"name": "turning_seen", "type": "angular_velocity", "body": "ball", "relative_to": "arm", "frame": "base"},
    {"name": "turning_global", "type": "angular_velocity", "body": "ball", "frame": "global"},
    {"name": "load", "type": "reaction", "joint": "shoulder"},
    {"name": "load1", "type": "reaction", "joint": "rail", "frame": "first"},
    {"name": "load2", "type": "reaction", "joint": "wrist", "frame": "second"},
    {"name": "lifting", "type": "driver_effort", "driver": "lift"},
    {"name": "spinning", "type": "driver_effort", "driver": "spin"},
    {"name": "swing", "type": "momentum"},
    {"name": "swing_arm", "type": "momentum", "bodies": ["arm", "slider"], "about": [0.1, 0.2, -0.3]},
    {"name": "swing_own", "type": "momentum", "bodies": ["ball", "arm"], "about": "mass_centre"},
    {"name": "far", "type": "expression", "value": "sqrt(tip.x**2 + tip.y**2) - reach*t", "units": "m"},
    {"name": "bending", "type": "expression", "value": "max(far, 0)*load.torque.x + lifting", "units": "N m"},
]  # fmt: skip


def rig(*, quantities: list[dict[str, Any]] | None = None, **sections: Any) -> dict[str, Any]:
    """The mechanism with these quantities, by default with all; sections are replaced."""
    data = copy.deepcopy(RIG)
    data["quantities"] = copy.deepcopy(QUANTITIES if quantities is None else quantities)
    return data | sections


def run(data: dict[str, Any], **options: Any) -> Any:
    dataset = lienumba.run(data, **{"workers": 1, **options})
    assert (dataset.status == 0).all()
    return dataset


class Seen:
    """What is stored of the bodies in one run, along global axes: r, R, v, w and more by name, (times, ...) each."""

    def __init__(self, dataset: Any) -> None:
        self.names = dataset.body.values.tolist()
        self.t = dataset.time.values
        self.all = tuple(dataset[name].values for name in ("position", "rotation", "velocity", "angular_velocity"))

    def __call__(self, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        if name == "ground":
            zero = np.zeros((len(self.t), 3))
            return zero, np.broadcast_to(np.eye(3), (len(self.t), 3, 3)), zero, zero
        r, R, v, w = (x[:, self.names.index(name)] for x in self.all)
        return r, R, v, along(R, w)

    def point(self, name: str, p: Any) -> tuple[np.ndarray, np.ndarray]:
        """A point's position and velocity."""
        r, R, v, w = self(name)
        return r + R @ p, v + np.cross(w, R @ p)


def along(R: np.ndarray, x: np.ndarray) -> np.ndarray:
    """R x at every time."""
    return np.einsum("tij,tj->ti", R, x)


def back(R: np.ndarray, x: np.ndarray) -> np.ndarray:
    """R^T x at every time."""
    return np.einsum("tji,tj->ti", R, x)


def slope(x: np.ndarray) -> np.ndarray:
    """The rate of what is stored at every step, of fourth order; without the two times at either end."""
    return (8 * (x[3:-1] - x[1:-3]) - x[4:] + x[:-4]) / (12 * STEP)
