"""A small valid scenario as a dict, and changes to it."""

import copy
from typing import Any

EXAMPLE: dict[str, Any] = {
    "title": "example",
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [
            {
                "name": "top",
                "mass": 15,
                "inertia": [0.234375, 0.46875, 0.234375],
                "position": [0, 1, 0],
                "rotation": [1, 0, 0, 0],
                "angular_velocity": [0, 150, -4.61538],
            }
        ],
        "joints": [
            {
                "name": "pivot",
                "type": "spherical",
                "bodies": ["ground", "top"],
                "points": [[0, 0, 0], [0, -1, 0]],
            }
        ],
    },
    "integrator": {"method": "rk4", "step": 1e-3, "end_time": 0.1},
    "output": {"every": 0.01},
    "sweep": {"runs": 3, "seed": 1, "vary": {"bodies.top.mass": {"distribution": "normal", "std": 0.1}}},
}


def example(**changes: Any) -> dict[str, Any]:
    """The example with keys of its body replaced; None removes one."""
    data = copy.deepcopy(EXAMPLE)
    body = data["model"]["bodies"][0]
    body.update(changes)
    for key in [key for key, value in body.items() if value is None]:
        del body[key]
    return data
