"""A hinge that latches, and a ball that is let go and bounces."""

from functools import cache
from typing import Any

import xarray as xr

import lienumba

CHANGING: dict[str, Any] = {
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [
            {"name": "door", "mass": 1.0, "inertia": [0.02, 0.02, 0.02]},
            {"name": "ball", "mass": 0.5, "inertia": [0.002, 0.002, 0.002], "position": [1, 0, 0.15]},
        ],
        "joints": [
            {"name": "hinge", "type": "revolute", "bodies": ["ground", "door"], "points": [[0, 0, 0], [0, 0.5, 0]],
             "axis": [0, 0, 1], "rate": 2.0},
            {"name": "hook", "type": "spherical", "bodies": ["ground", "ball"], "points": [[1, 0, 0.15], [0, 0, 0]]},
        ],
        "contacts": [
            {"name": "floor", "type": "sphere_plane", "bodies": ["ball", "ground"], "points": [[0, 0, 0], [0, 0, 0]],
             "normal": [0, 0, 1], "radius": 0.1, "restitution": 0.5},
        ],
    },
    "events": [
        {"name": "shut", "when": "t > 0.1", "action": "lock", "joint": "hinge"},
        {"name": "let_go", "when": "t > 0.05", "action": "release", "joint": "hook"},
    ],
    "integrator": {"method": "dop853", "tolerance": 1e-9, "end_time": 0.4},
    "output": {"every": 0.01},
    "sweep": {"runs": 4, "vary": {"contacts.floor.restitution": {"distribution": "uniform", "low": 0.0, "high": 0.6}}},
}  # fmt: skip


@cache
def changing() -> xr.Dataset:
    """Four runs of it."""
    return lienumba.run(CHANGING)
