"""A pendulum whose torque is a formula, and its motion by SciPy."""

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

G, L, M, J = 9.81, 0.4, 1.5, 0.02


def pendulum(torque: str, more: Any = (), *, target: Any = None, step: float = 1e-3) -> dict[str, Any]:
    """A rod on a hinge along y, its mass centre L below it, with a torque about y."""
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "rod"], "points": [[0, 0, 0], [0, 0, L]],
             "axes": [[0, 1, 0], [0, 1, 0]]}  # fmt: skip
    pointing = {"name": "pointing", "type": "rotation_error", "body": "rod"} | ({"target": target} if target else {})
    rod = {"name": "rod", "mass": M, "inertia": [J, J, J], "angular_velocity": [0, 6, 0],
           "rotation": {"axis": [0, 1, 0], "angle": 1.0}}  # fmt: skip
    return {
        "parameters": {"kp": 20, "kd": "kp/10"},
        "model": {
            "bodies": [rod],
            "joints": [hinge],
            "forces": [{"name": "motor", "type": "torque", "body": "rod", "value": [0, torque, 0]}],
        },
        "quantities": [pointing, {"name": "rate", "type": "angular_velocity", "body": "rod"}, *more],
        "integrator": {"step": step, "end_time": 0.8},
        "output": {"every": 0.1},
    }


def exact(torque, times, q=1.0, dq=6.0, inertia=J + M * L * L):
    """Angle of the pendulum under torque(t, angle, rate)."""

    def f(t, y):
        return [y[1], (torque(t, *y) - M * G * L * np.sin(y[0])) / inertia]

    return solve_ivp(f, (0, times[-1]), [q, dq], "DOP853", t_eval=times, rtol=1e-12, atol=1e-12, max_step=1e-3).y


def angles(ds):
    R = ds.rotation.values[..., 0, :, :]
    return np.arctan2(R[..., 0, 2], R[..., 0, 0])
