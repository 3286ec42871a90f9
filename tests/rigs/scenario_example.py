"""A small valid scenario as a dict, and changes to it."""

import copy
from typing import Any

from tests.rigs import parts

EXAMPLE: dict[str, Any] = {
    "title": "example",
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [
            parts.body("top", 15, [0.234375, 0.46875, 0.234375], position=[0, 1, 0], rotation=[1, 0, 0, 0],
                       angular_velocity=[0, 150, -4.61538])
        ],
        "joints": [parts.joint("pivot", "spherical", "top", points=[[0, 0, 0], [0, -1, 0]])],
    },
    "integrator": {"method": "rk4", "step": 1e-3, "end_time": 0.1},
    "output": {"every": 0.01},
    "sweep": {"runs": 3, "seed": 1, "vary": {"bodies.top.mass": {"distribution": "normal", "std": 0.1}}},
}  # fmt: skip


def example(**changes: Any) -> dict[str, Any]:
    """The example with keys of its body replaced; None removes one."""
    data = copy.deepcopy(EXAMPLE)
    body = data["model"]["bodies"][0]
    body.update(changes)
    for key in [key for key, value in body.items() if value is None]:
        del body[key]
    return data
