"""Small mechanisms that the laws act on, and what is known of them without lienumba."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs import parts
from tests.rigs.scenarios import LINK

FUNCTIONS = Path(__file__).parent / "functions.py"
M, L, J, G = 1.3, 0.6, 0.11, 9.81  # of the pendulum: its mass centre lies L below its hinge
TURNING = J + M * L * L


def own(function: str, name: str = "own", **keys: Any) -> dict[str, Any]:
    """A force by a function of the file `functions.py`."""
    return {"name": name, "type": "python", "function": f"{FUNCTIONS}:{function}", **keys}


def pendulum(
    *forces: dict[str, Any],
    angle: float = 0.5,
    rate: float = 1.0,
    step: float = 0.01,
    end: float = 1.0,
    **sections: Any,
) -> dict[str, Any]:
    """A rod on a hinge along y, with its angle from hanging down."""
    hinge = parts.pivot("hinge", "rod", second=[0, 0, L])
    rod = parts.body("rod", M, [0.1, J, 0.12], angular_velocity=[0, rate, 0])
    rod["rotation"] = {"axis": [0, 1, 0], "angle": angle}
    return {
        "model": {"bodies": [rod], "joints": [hinge], "forces": copy.deepcopy(list(forces))},
        "integrator": {"step": step, "end_time": end},
        "output": {"times": [0.0, end]},
    } | sections


def pair(*forces: dict[str, Any], step: float = 2e-3, end: float = 0.4, **sections: Any) -> dict[str, Any]:
    """A free body beside a skew one on a hinge and a block on a rail; all of them move."""
    return {
        "model": {
            "gravity": [0.5, -0.3, -9.81],
            "bodies": [
                parts.body("arm", **LINK, position=[0, 0.3, -0.2], rotation=[1, 0, 0, 0]),
                parts.body("ball", 0.7, [0.02, 0.03, 0.025, 0.001, 0, 0.002], position=[0.6, 0, -1],
                           rotation={"axis": [0.3, 1, 0.2], "angle": 0.7}, velocity=[0.3, 1, 2],
                           angular_velocity=[3, -2, 4]),
                parts.body("block", 0.9, 0.02, position=[1, 1, 0], rotation=[1, 0, 0, 0]),
                parts.body("tube", 0.8, [0.02, 0.04, 0.03], position=[-1, 0, 0], rotation=[1, 0, 0, 0]),
            ],
            "joints": [
                parts.hinge("shoulder", "arm", [0, 0.2, 0], [0, 1, 0.2], rate=3.0),
                parts.joint("rail", "prismatic", "block", at=[1, 1, 0], axis=[1, 0.3, 0.5], speed=0.4),
                parts.joint("sleeve", "cylindrical", "tube", at=[-1, 0.1, 0], axis=[0.2, 1, 0.3], speed=0.4, rate=2.0),
            ],
            "forces": copy.deepcopy(list(forces)),
        },
        "integrator": {"step": step, "end_time": end},
        "output": {"times": [0.0, end / 2, end]},
    } | sections  # fmt: skip


def run(data: dict[str, Any], **options: Any) -> Any:
    dataset = lienumba.run(data, **{"workers": 1, **options})
    assert (dataset.status == 0).all(), dataset.status.values
    return dataset


def angle(dataset: Any, body: int = 0) -> np.ndarray:
    """The angle about y of a body (run, time), within half a turn."""
    R = dataset.rotation.values[:, :, body]
    return np.arctan2(R[..., 0, 2], R[..., 0, 0])


def rate(dataset: Any, body: int = 0) -> np.ndarray:
    return dataset.angular_velocity.values[:, :, body, 1]


def missed(dataset: Any, y: Any) -> float:
    """By how much the last angle and rate differ from these; whole turns do not count."""
    turn = angle(dataset)[0, -1] - y[0]
    return float(max(abs(np.arctan2(np.sin(turn), np.cos(turn))), abs(rate(dataset)[0, -1] - y[1])))


def exact(torque: Any, end: float, start: Any = (0.5, 1.0), begin: float = 0.0, more: Any = None) -> np.ndarray:
    """Angle, rate and further states of the pendulum at the end: torque(t, y) and the rates more(t, y) of these."""

    def slope(t: float, y: np.ndarray) -> list[float]:
        rest = [] if more is None else list(more(t, y))
        return [y[1], (torque(t, y) - M * G * L * np.sin(y[0])) / TURNING, *rest]

    return solve_ivp(slope, (begin, end), list(start), "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


def order(errors: Any) -> np.ndarray:
    """The slopes of errors at steps that are halved."""
    return np.log2(np.divide(errors[:-1], errors[1:]))


def close(a: Any, b: Any, *names: str, rtol: float = 0.0, atol: float = 1e-11) -> None:
    """The same numbers in these variables."""
    for name in names:
        np.testing.assert_allclose(a[name], b[name], rtol=rtol, atol=atol, err_msg=name)
