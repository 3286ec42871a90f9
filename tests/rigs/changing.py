"""A hinge that latches, and a ball that is let go and bounces."""

from functools import cache
from typing import Any

import xarray as xr

import lienumba
from tests.rigs import parts

CHANGING: dict[str, Any] = {
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [parts.body("door", 1.0, 0.02), parts.body("ball", 0.5, 0.002, position=[1, 0, 0.15])],
        "joints": [
            parts.joint("hinge", "revolute", "door", points=[[0, 0, 0], [0, 0.5, 0]], axis=[0, 0, 1], rate=2.0),
            parts.joint("hook", "spherical", "ball", points=[[1, 0, 0.15], [0, 0, 0]]),
        ],
        "contacts": [parts.sphere("floor", "ball", 0.1, normal=[0, 0, 1], restitution=0.5)],
    },
    "events": [
        {"name": "shut", "when": "t > 0.1", "action": "lock", "joint": "hinge"},
        {"name": "let_go", "when": "t > 0.05", "action": "release", "joint": "hook"},
    ],
    "integrator": {"method": "dop853", "tolerance": 1e-9, "end_time": 0.4},
    "output": {"every": 0.01},
    "sweep": parts.sweep(4, {"contacts.floor.restitution": (0.0, 0.6)}),
}  # fmt: skip


@cache
def changing() -> xr.Dataset:
    """Four runs of it."""
    return lienumba.run(CHANGING)
