"""From a scenario to numbers: the forms of rotations and inertias, and varied numbers as arrays."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lienumba.scenario.start.build import build, unphysical
from tests.facade import GROUND, ScenarioError, resolve
from tests.rigs.every_law import alone
from tests.rigs.scenario_example import example

SEQUENCES = ["".join(axes) for axes in product("XYZ", repeat=3) if axes[0] != axes[1] and axes[1] != axes[2]]


def rotation_of(form: Any) -> np.ndarray:
    _, start = build(resolve(example(rotation=form)), {})
    return np.array(start.poses[0].rotation).reshape(3, 3)


def test_the_nominal_model_has_plain_floats() -> None:
    model, start = build(resolve(example()), {})
    (pose,) = start.poses
    assert model.gravity == (0.0, 0.0, -9.81)
    assert model.bodies[0].inertia == (0.234375, 0.46875, 0.234375, 0.0, 0.0, 0.0)
    assert model.joints[0].bodies == (GROUND, 0)
    assert model.joints[0].points == ((0.0, 0.0, 0.0), (0.0, -1.0, 0.0))
    assert pose.position == (0.0, 1.0, 0.0)
    assert pose.velocity is None
    numbers = [*model.gravity, model.bodies[0].mass, *model.bodies[0].inertia, *pose.rotation]
    assert all(type(number) is float for number in numbers)


def test_all_12_euler_sequences_are_known() -> None:
    assert len(SEQUENCES) == 12


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_are_intrinsic(sequence: str) -> None:
    angles = [0.3, -1.2, 2.5]
    expected = Rotation.from_euler(sequence, angles).as_matrix()
    np.testing.assert_allclose(rotation_of({"euler": sequence, "angles": angles}), expected, atol=1e-15)


def test_other_forms_agree_with_scipy() -> None:
    vector = np.array([0.3, -0.7, 1.1])
    angle = float(np.linalg.norm(vector))
    turn = Rotation.from_rotvec(vector)
    x, y, z, w = turn.as_quat()
    forms = [
        {"rotation_vector": vector},
        {"axis": 3 * vector, "angle": angle},
        [w, x, y, z],
        [-2 * w, -2 * x, -2 * y, -2 * z],
        turn.as_matrix(),
    ]
    for form in forms:
        np.testing.assert_allclose(rotation_of(form), turn.as_matrix(), atol=2e-15)


def test_a_rounded_matrix_is_made_orthonormal() -> None:
    exact = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1]).as_matrix()
    matrix = rotation_of(np.round(exact, 7).tolist())
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(matrix, exact, atol=1e-7)


def test_exact_zeros_of_a_matrix_stay_exact() -> None:
    c, s = 0.8775826, 0.4794255
    matrix = rotation_of([[1, 0, 0], [0, c, -s], [0, s, c]])
    assert (matrix[0] == [1, 0, 0]).all()
    assert (matrix[:, 0] == [1, 0, 0]).all()


@pytest.mark.parametrize(
    "inertia",
    [
        [2.0, 3.0, 4.0, 0.1, 0.2, 0.3],
        [[2.0, 0.1, 0.2], [0.1, 3.0, 0.3], [0.2, 0.3, 4.0]],
        [[2.0, 0.1, 0.2], [0.1 + 1e-12, 3.0, 0.3], [0.2, 0.3, 4.0]],
    ],
)
def test_forms_of_inertia(inertia: Any) -> None:
    model, _ = build(resolve(example(inertia=inertia)), {})
    assert model.bodies[0].inertia == pytest.approx((2.0, 3.0, 4.0, 0.1, 0.2, 0.3), abs=1e-12)


VARIED: dict[str, tuple[Any, str]] = {
    "mass": (15.0, "bodies.top.mass"),
    "quaternion": ([1.0, 0.2, 0.3, 0.4], "bodies.top.rotation[2]"),
    "angle": ({"axis": [0.0, 1.0, 2.0], "angle": 0.3}, "bodies.top.rotation.angle"),
    "axis": ({"axis": [0.0, 1.0, 2.0], "angle": 0.3}, "bodies.top.rotation.axis[0]"),
    "euler": ({"euler": "ZYX", "angles": [0.1, 0.2, 0.3]}, "bodies.top.rotation.angles[1]"),
    "vector": ({"rotation_vector": [0.1, 0.2, 0.3]}, "bodies.top.rotation.rotation_vector[2]"),
    "inertia": ([2.0, 3.0, 4.0, 0.1, 0.2, 0.3], "bodies.top.inertia[3]"),
    "point": (None, "joints.pivot.points[1][0]"),
    "gravity": (None, "gravity[2]"),
}


@pytest.mark.parametrize("name", VARIED)
def test_a_varied_number_equals_as_many_single_models(name: str) -> None:
    value, path = VARIED[name]
    key = path.split(".")[2].split("[")[0] if path.startswith("bodies") else None
    data = example(**{key: value}) if key else example()
    data["sweep"]["vary"] = {path: {"distribution": "normal", "std": 0.1}}
    scenario = resolve(data)
    samples = scenario.nominal()[path] + np.linspace(-0.05, 0.1, 4)
    model, start = build(scenario, {path: samples})
    (pose,) = start.poses
    del data["sweep"]["vary"]
    for run, sample in enumerate(samples):
        single, single_start = build(resolve(data, overrides={path: float(sample)}), {})
        for many, one in (
            (model.gravity, single.gravity),
            ((model.bodies[0].mass,), (single.bodies[0].mass,)),
            (model.bodies[0].inertia, single.bodies[0].inertia),
            (model.joints[0].points[1], single.joints[0].points[1]),
            (pose.rotation, single_start.poses[0].rotation),
        ):
            picked = [np.broadcast_to(number, len(samples))[run] for number in many]
            np.testing.assert_allclose(picked, one, rtol=1e-15, atol=1e-16)


def test_runs_with_unphysical_samples_are_found() -> None:
    scenario = resolve(example())
    samples = {
        "bodies.top.mass": np.array([1.0, -1.0, 1.0, 1.0, np.nan]),
        "bodies.top.inertia[0]": np.array([1.0, 1.0, -1.0, 1.0, 1.0]),
        "bodies.top.rotation[0]": np.array([1.0, 1.0, 1.0, 0.0, 1.0]),
    }
    assert unphysical(*build(scenario, samples), samples, 5).tolist() == [False, True, True, True, True]


def test_runs_whose_friction_sets_in_at_no_speed_are_found() -> None:
    data, _ = alone("forces", 5)
    samples = {"forces.rub.velocity": np.array([0.1, 0.0, -0.1])}
    assert unphysical(*build(resolve(data), samples), samples, 3).tolist() == [False, True, True]


@pytest.mark.parametrize("rotation", [[1e-200, 0, 0, 0], {"axis": [1e-200, 0, 0], "angle": 1}, [1e200, 0, 0, 0]])
def test_rotations_beyond_floating_point_are_refused(rotation: Any) -> None:
    with pytest.raises(ScenarioError):
        resolve(example(rotation=rotation))
