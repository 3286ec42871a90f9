"""What SE(3) is for: a joint to ground whose motions form a subgroup holds by itself, in every step and at any order
(Mueller, Terze 2014). Others do not."""

from typing import Any

import numpy as np
import pytest

from lienumba.groups import se3, so3
from lienumba.integrators.methods.charts import SE3
from tests.rigs.in_charts import NONE, run_in
from tests.rigs.scenarios import TOP, exact_top

BODY = {"name": "body", "mass": 1.3, "inertia": [0.06, 0.05, 0.02, 0.004, -0.006, 0.005]}
THROWN = {"guess": {"angular_velocity": [2, -9, 4], "velocity": [1, 0.5, -0.3]}}
SUBGROUPS = ("spherical", "revolute", "cylindrical", "prismatic", "fixed", "planar", "screw", "parallel_axes")
SCREWED = ("spherical", "revolute", "cylindrical", "screw")  # whose motions are none of R^3 x SO(3)
OTHERS = ("universal", "point_on_line", "point_in_plane", "distance", "perpendicular_axes")
STEPS, STEP = 1000, 2e-3
ROUNDING = 1e-12


def tied(kind: str) -> dict[str, Any]:
    """A skew body that is thrown, on a joint askew to ground; no axis of either is special."""
    joint: dict[str, Any] = {"name": "joint", "type": kind, "bodies": ["ground", "body"]}
    if kind not in ("parallel_axes", "perpendicular_axes"):
        joint["points"] = [[0.1, -0.2, 0.3], [0.2, 0.3, -0.1]]
    if kind not in ("spherical", "distance"):
        joint["axes"] = [[2 / 7, 3 / 7, 6 / 7], [0.6, 0.0, 0.8]]
    joint |= {"screw": {"pitch": 0.3}, "distance": {"length": 0.7}}.get(kind, {})
    return {"model": {"bodies": [BODY | (THROWN if kind != "fixed" else {})], "joints": [joint]}}


def violations(group: str, kind: str, method: str = "rk4") -> tuple[float, float]:
    """The largest of positions and of velocities."""
    keys: dict[str, Any] = {"projection": NONE, "method": method, "output": {"every": STEPS * STEP / 10}}
    dataset = run_in({"group": group}, tied(kind), STEP, STEPS * STEP, **keys)
    moved = np.abs(dataset["velocity"].values).max() + np.abs(dataset["angular_velocity"].values).max()
    assert (moved > 1.0) == (kind != "fixed")
    return float(dataset["position_violation"].max()), float(dataset["velocity_violation"].max())


@pytest.mark.parametrize("kind", SUBGROUPS)
def test_a_subgroup_holds_by_itself(kind: str) -> None:
    assert max(violations("SE3", kind)) < ROUNDING
    if kind in SCREWED:
        assert min(violations("R3xSO3", kind)) > 100 * ROUNDING


@pytest.mark.parametrize("kind", OTHERS)
def test_other_joints_drift_on_either(kind: str) -> None:
    on_se3, on_product = violations("SE3", kind), violations("R3xSO3", kind)
    assert min(on_se3) > 100 * ROUNDING
    assert max(on_se3) > 0.2 * max(on_product)


@pytest.mark.parametrize("method", ["euler", "cf4", "dop853"])
def test_it_holds_whatever_the_method(method: str) -> None:
    assert max(violations("SE3", "spherical", method)) < ROUNDING
    assert max(violations("SE3", "screw", method)) < ROUNDING


@pytest.mark.parametrize(("step", "bound"), [(1e-3, 2e-13), (1e-4, 1e-12)])
def test_the_paper_s_top_without_projection(step: float, bound: float) -> None:
    """Over 2 s: on R^3 x SO(3) its pivot drifts by 2.7e-3 and 2.7e-7."""
    keys: dict[str, Any] = {"projection": NONE, "output": {"every": 0.5}}
    on_se3, on_product = (run_in({"group": group}, TOP, step, 2.0, **keys) for group in ("SE3", "R3xSO3"))
    for level in ("position_violation", "velocity_violation"):
        assert float(on_se3[level].max()) < bound
        assert float(on_product[level].max()) > 2e-3 * (step / 1e-3) ** 4
    exact = exact_top(2.0)
    errors = [np.abs(ds["position"].values[-1] - exact.r).max() for ds in (on_se3, on_product)]
    assert errors[0] < 0.1 * errors[1]


def test_velocities_turned_there_and_back_do_not_grow() -> None:
    """A rotation that is none by as much as those of long runs are: its transpose alone would not do."""
    R = tuple((1.0 + 1e-9) * x for x in so3.exp((0.4, -1.1, 0.3)))
    x = (0.0, 0.0, 0.0, *R, 3.0, -2.0, 1.0, 0.5, 0.1, -0.7)
    for _ in range(1000):
        x = SE3(2).moved(x, (0.0,) * 12)
    assert x[12:15] == pytest.approx((3.0, -2.0, 1.0), abs=1e-13)
    assert se3.product(x[0:12], se3.IDENTITY) == x[0:12]
