"""What the initial state is judged by: each joint by its own size, each run for itself."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch import statuses


def pendulum(gap: float, at: float = 0.0, size: float = 1.0) -> dict[str, Any]:
    """A pendulum of this size, hung up at x = `at`, whose points miss by `gap`."""
    body = {"name": "a", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "rotation": [1, 0, 0, 0]}
    joint = {"name": "j", "type": "spherical", "bodies": ["ground", "a"], "points": [[at, 0, 0], [0, size, 0]]}
    model = {"bodies": [body | {"position": [at, -size + gap, 0]}], "joints": [joint]}
    return {"model": model, "integrator": {"method": "rk4", "step": 1e-3, "end_time": 0.01}}


def test_a_gap_is_judged_by_the_size_of_its_joint() -> None:
    lienumba.run(pendulum(1e-10))
    with pytest.raises(lienumba.ScenarioError, match=r"model\.joints\.j: its points do not meet"):
        lienumba.run(pendulum(5e-9, size=1e-8))
    far = pendulum(5e-3)
    other = {"name": "b", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [1e6, 0, 0]}
    far["model"]["bodies"].append(other)
    with pytest.raises(lienumba.ScenarioError, match=r"they miss by 0\.005 m"):
        lienumba.run(far)


def test_far_from_the_origin_rounding_is_no_gap() -> None:
    data = pendulum(0.0, at=7e6 / 3)
    del data["model"]["bodies"][0]["position"]
    assert int(lienumba.run(data)["status"][0]) == statuses.SUCCESS


def test_two_spellings_of_one_path_are_one_number() -> None:
    data = pendulum(0.0)
    normal = {"distribution": "normal", "mean": 1.5, "std": 0.1}
    data["sweep"] = {"runs": 4, "vary": {"bodies[0].mass": normal}}
    by_index = lienumba.run(data)
    assert by_index["bodies.a.mass"].attrs["role"] == "input"
    with pytest.raises(lienumba.ScenarioError, match="is varied"):
        lienumba.run(data, overrides={"bodies.a.mass": 2.0})
    data["sweep"]["vary"] = {"bodies.a.mass": normal}
    np.testing.assert_array_equal(lienumba.run(data)["bodies.a.mass"], by_index["bodies.a.mass"])
    data["sweep"]["vary"]["bodies[0].mass"] = normal
    with pytest.raises(lienumba.ScenarioError, match="is the same number as"):
        lienumba.run(data)


def test_a_run_that_cannot_be_assembled_is_data_alone_too() -> None:
    data = pendulum(0.0)
    data["sweep"] = {"runs": 3, "vary": {"bodies.a.mass": {"distribution": "normal", "std": 0.1}}}
    lengths = {"distribution": "uniform", "low": 1.0, "high": 1.5}
    data["sweep"]["vary"]["joints.j.points[1][1]"] = lengths
    with pytest.raises(lienumba.ScenarioError, match="no sampled run can be assembled"):
        lienumba.run(data)
    assert lienumba.run(data, runs=[2])["status"].values.tolist() == [statuses.NOT_ASSEMBLED]


@pytest.mark.parametrize("points", [[[0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0.5, 0, 0]]])
def test_a_rod_is_assembled_from_nothing(points: Any) -> None:
    """Both ends start in the origin, where the direction of the rod is undefined."""
    data = pendulum(0.0)
    data["model"]["bodies"] = [{"name": "a", "mass": 1.0, "inertia": [1.0, 1.0, 1.0]}]
    data["model"]["joints"] = [{"name": "rod", "type": "distance", "bodies": ["ground", "a"], "points": points}]
    data["model"]["joints"][0]["length"] = 1.0
    dataset = lienumba.run(data)
    place = dataset["position"].values[0, 0, 0] + dataset["rotation"].values[0, 0, 0] @ points[1]
    assert np.linalg.norm(place) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"runs": [1, 1]}, "named twice"),
        ({"runs": [1.5]}, "is not a label"),
        ({"runs": [True]}, "is not a label"),
        ({"workers": 0}, "must be a whole number of threads"),
        ({"workers": 1.5}, "must be a whole number of threads"),
    ],
)
def test_arguments_from_python(arguments: dict[str, Any], message: str) -> None:
    data = pendulum(0.0)
    data["sweep"] = {"runs": 4, "vary": {"bodies.a.mass": {"distribution": "normal", "std": 0.1}}}
    with pytest.raises(lienumba.ScenarioError, match=message):
        lienumba.run(data, **arguments)
