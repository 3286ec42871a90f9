"""Two hinges whose axes are parallel but for rounding, which says how the axes of their links are turned about them: to
every kernel the same. SciPy in the angles."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.oracles.minimal.coordinates import turn

MASS, INERTIA, END = 0.7, np.diag([0.03, 0.04, 0.02]), 0.02
CENTRES = np.array([[0.1, 0.0, -0.6], [0.1, 0.0, -1.8]])
HINGES = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.2]])
RATES, GRAVITY = (4.0, -1.0), np.array([1.0, 0.0, -9.5])
AXES = [(0.0, 0.6, 0.8), (0.2, -0.5, 0.7), (0.0, 1.0, 1e-3), (0.3, 0.0, 0.1), (-1.0, 1.0, 1.0)]
METHODS: dict[str, tuple[dict[str, Any], float]] = {  # and what they may be wrong by (m)
    "radau3": ({"step": 1e-3}, 1e-9),
    "radau5": ({"tolerance": 1e-10}, 1e-9),
    "radau9": ({"tolerance": 1e-10}, 1e-9),
    "generalized_alpha": ({"step": 1e-4}, 2e-9),
    "taylor": ({"tolerance": 1e-12}, 1e-11),
    "dop853": ({"tolerance": 1e-12}, 1e-11),
}


def scenario(axis: tuple[float, ...], integrator: dict[str, Any]) -> dict[str, Any]:
    bodies = [
        {"name": f"b{n}", "mass": MASS, "inertia": [0.03, 0.04, 0.02], "position": [*map(float, at)]}
        for n, at in enumerate(CENTRES)
    ]
    joints = [
        {"name": f"h{n}", "type": "revolute", "bodies": [above, f"b{n}"], "at": [*map(float, at)], "axis": [*axis],
         "rate": rate}
        for n, (above, at, rate) in enumerate(zip(("ground", "b0"), HINGES, RATES, strict=True))
    ]  # fmt: skip
    model = {"gravity": [*map(float, GRAVITY)], "bodies": bodies, "joints": joints}
    return {"model": model, "integrator": {"coordinates": "joint", "end_time": END, **integrator},
            "output": {"every": END}}  # fmt: skip


def in_angles(axis: tuple[float, ...]) -> np.ndarray:
    """Where both mass centres are at the end."""
    n = np.array(axis) / np.linalg.norm(axis)
    own = n @ INERTIA @ n
    near, arm, far = CENTRES[0], HINGES[1], CENTRES[1] - HINGES[1]

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        upper, both = turn(n, y[0]), turn(n, y[0] + y[1])
        x, p, z = upper @ near, upper @ arm, both @ far
        first = np.array([np.cross(n, x), np.zeros(3)]).T
        second = np.array([np.cross(n, p + z), np.cross(n, z)]).T
        w, total = y[2], y[2] + y[3]
        bias = -(w**2) * (x - n * (n @ x)), -(w**2) * (p - n * (n @ p)) - total**2 * (z - n * (n @ z))
        M = MASS * (first.T @ first + second.T @ second) + own * np.array([[2.0, 1.0], [1.0, 1.0]])
        Q = MASS * (first.T @ (GRAVITY - bias[0]) + second.T @ (GRAVITY - bias[1]))
        return np.array([*y[2:], *np.linalg.solve(M, Q)])

    a, b = solve_ivp(rates, (0.0, END), [0.0, 0.0, *RATES], method="DOP853", rtol=1e-13, atol=1e-14).y[:2, -1]
    return np.array([turn(n, a) @ near, turn(n, a) @ arm + turn(n, a + b) @ far])


@pytest.mark.parametrize("method", METHODS)
def test_they_move_as_their_angles_do(method: str) -> None:
    """With every method, whatever the axis, in some steps (of noise in their places there would be a million)."""
    integrator, allowed = METHODS[method]
    for axis in AXES:
        ds = lienumba.run(scenario(axis, {"method": method, **integrator}), progress=False)
        assert int(ds.status[0]) == 0, axis
        np.testing.assert_allclose(ds.position[0, -1], in_angles(axis), atol=allowed, err_msg=str(axis))
        assert "step" in integrator or int(ds.steps[0]) < 100, axis
