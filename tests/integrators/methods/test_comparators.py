"""What becomes of a rotation in coordinates of a vector space: where it is no rotation any more, and where its angles
have no rates."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.groups import so3
from lienumba.integrators.methods.comparators import COORDINATES, tait_bryan
from tests.integrators.methods.test_convergence import reference
from tests.rigs.in_charts import COMPARATORS, NONE, orthogonality, run_in
from tests.rigs.scenarios import TOP, scenario

STEPS = {"heun": (3, 2e-4), "kutta3": (3, 5e-4), "rk4": (5, 1e-3), "dop853": (9, 1e-2)}
SPEED = 10.0


# ---------------------------------------------------------------- the matrix
@pytest.mark.parametrize("method", STEPS)
def test_the_nine_elements_leave_the_group_and_the_lie_chart_does_not(method: str) -> None:
    """A method's stability function has |R(iy)| = 1 up to the next even power of y behind its order."""
    power, step = STEPS[method]
    keys: dict[str, Any] = {"method": method, "projection": NONE, "output": {"every": 0.05}}
    lost = [orthogonality(run_in(COMPARATORS["matrix"], TOP, h, 0.1, **keys)) for h in (step, step / 2)]
    assert np.log2(lost[0] / lost[1]) == pytest.approx(power, abs=0.2), lost
    assert lost[1] > 1e-8
    others = [{}, {"group": "SE3"}, *(keys for name, keys in COMPARATORS.items() if name in ("quaternion",))]
    for chart in others:
        assert orthogonality(run_in(chart, TOP, step, 0.1, **keys)) < 1e-13


# ---------------------------------------------------------------- three angles
def spinning(tilt: float, step: float, coordinates: str) -> tuple[int, float]:
    """A ball that turns steadily about an axis tilted by this from y, so that its second angle comes as near to a
    quarter of a turn: the status, and the largest error of R."""
    w = SPEED * np.array([0.0, np.cos(tilt), np.sin(tilt)])
    ball = {"name": "ball", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [0, 0, 0], "rotation": [1, 0, 0, 0],
            "velocity": [0, 0, 0], "angular_velocity": w.tolist()}  # fmt: skip
    data = scenario({"model": {"gravity": [0, 0, 0], "bodies": [ball]}}, step, 1.0, output={"every": 0.1})
    data["integrator"]["coordinates"] = coordinates
    dataset = lienumba.run(data, workers=1).isel(run=0)
    exact = [so3.exp(tuple(w * t)) for t in dataset["time"].values]
    error = np.abs(dataset["rotation"].values.reshape(-1, 9) - exact).max()
    return int(dataset["status"]), float(error)


def test_a_gimbal_lock_costs_every_digit() -> None:
    h = 2e-3
    assert spinning(0.01, h, "lie") < (0, 1e-13)
    assert spinning(0.01, h, "quaternion") < (0, 1e-9)
    errors = [spinning(tilt, h, "tait_bryan")[1] for tilt in (1.0, 0.1, 0.01)]
    assert errors[0] < 1e-8
    assert errors[1] > 100 * errors[0]
    assert errors[2] > 1000 * errors[1]


def test_in_the_lock_a_run_fails_and_says_so() -> None:
    """The paper's top turns by y, the second of its angles, 10.5 ms behind the start."""
    data = scenario(TOP, 1e-3, 0.1, projection=NONE)
    data["integrator"]["coordinates"] = "tait_bryan"
    dataset = lienumba.run(data, workers=1).isel(run=0)
    assert int(dataset["status"]) == 4
    assert float(dataset["end_time"]) == pytest.approx(0.010)
    assert np.isnan(dataset["position"].values[-1]).all()


def test_the_rotation_vector_jumps_at_half_a_turn_and_the_motion_does_not() -> None:
    """Every step begins with the vector of at most half a turn: the paper's top turns by 2.4 turns, at order 4."""
    keys: dict[str, Any] = {"projection": NONE, "output": {"every": 1e-3}}
    errors = []
    for h in (1e-3, 5e-4):
        dataset = run_in(COMPARATORS["rotation_vector"], TOP, h, 0.1, **keys)
        R = dataset["rotation"].values.reshape(-1, 9)
        vectors = np.array([so3.log(tuple(row.tolist())) for row in R])
        norms = np.linalg.norm(vectors, axis=1)
        assert norms.max() <= np.pi * (1 + 1e-15)
        assert (np.linalg.norm(np.diff(vectors, axis=0), axis=1) > 5.0).sum() >= 2
        assert np.abs(np.diff(R, axis=0)).max() < 0.2
        end = [dataset[n].values[-1].ravel() for n in ("position", "rotation", "velocity", "angular_velocity")]
        errors.append(np.abs(np.concatenate(end) - reference("top")).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.2), errors


def test_angles_are_those_of_successive_rotations() -> None:
    """3-2-1: about z, then the new y, then the new x."""
    phi, theta, psi = 0.4, -1.2, 2.9
    z, y, x = (so3.exp(u) for u in ((0.0, 0.0, psi), (0.0, theta, 0.0), (phi, 0.0, 0.0)))
    R = so3.multiply(z, so3.multiply(y, x))
    assert tait_bryan(R) == pytest.approx((phi, theta, psi), abs=1e-15)
    assert COORDINATES["tait_bryan"].matrix((phi, theta, psi)) == pytest.approx(R, abs=1e-15)
