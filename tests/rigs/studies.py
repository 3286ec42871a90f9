"""Small studies: of the heavy top, and of a ball under forces of the time, whose motion is known in closed form."""

import copy
from typing import Any

from tests.rigs import parts
from tests.rigs.scenarios import TOP

BALL: dict[str, Any] = {  # thrown, pushed and twisted by forces of the time
    "parameters": {"spin": 7.0, "height": 2.0, "push": 4.0},
    "model": {
        "bodies": [
            parts.body("ball", 0.5, 0.002, position=[0, 0, "height"], rotation=[1, 0, 0, 0], velocity=[3, 0, 1],
                       angular_velocity=[0, "0.6*spin", "0.8*spin"])
        ],
        "forces": [
            {"type": "force", "body": "ball", "value": ["0.5*push*cos(3*t)", 0, 0]},
            {"type": "torque", "body": "ball", "value": [0, "0.002*12*cos(3*t)", "0.002*16*cos(3*t)"]},
        ],
    },
    "integrator": {"method": "rk4", "step": 0.01, "end_time": 0.4},
    "output": {"every": 0.1},
}  # fmt: skip
EXACT = {
    "position": {"ball": ["3*t + push/9*(1 - cos(3*t))", 0, "height + t - 4.905*t**2"]},
    "rotation": {"ball": {"axis": [0, 0.6, 0.8], "angle": "spin*t + 20/9*(1 - cos(3*t))"}},
}
SAMPLED = {"runs": 3, "seed": 1, "vary": {"parameters.spin": {"distribution": "normal", "std": 1.0}}}
VARIED = {"runs": 3, "seed": 4, "vary": {"bodies.top.mass": {"distribution": "normal", "std": 0.1}}}


def ball(*grids: dict[str, Any], reference: dict[str, Any] | None = None, **sections: Any) -> dict[str, Any]:
    return _study(BALL, grids, reference or EXACT, sections)


def top(*grids: dict[str, Any], reference: dict[str, Any] | None = None, **sections: Any) -> dict[str, Any]:
    """The paper's heavy top for 0.04 s."""
    timed = {**TOP, "integrator": {"step": 1e-3, "end_time": 0.04}, "output": {"every": 0.01}}
    return _study(timed, grids, reference or {"method": "dop853", "step": 1e-3}, sections)


def _study(base: dict[str, Any], grids: Any, reference: dict[str, Any], sections: dict[str, Any]) -> dict[str, Any]:
    data = copy.deepcopy({**base, **sections})
    repeats = {"repeats": data.pop("repeats", 1)}
    if grids:
        data["study"] = {"reference": reference, "grid": [*grids], **repeats}
    return data
