"""The engine against MuJoCo: accelerations to roundoff, positions by the errors of the steps; and what it lacks."""

import numpy as np
import pytest

from lienumba.engine.checks import mujoco
from lienumba.engine.checks.mujoco import check
from tests.facade import ScenarioError
from tests.rigs.parts import X, Y, Z, body, joint, resting

pytest.importorskip("mujoco")
HELD = {"points": [[0.1, 0.2, 0.3], [-0.2, 0.1, 0.05]]}


def scenario(kind, **keys):
    """Two bodies, the first free, the second on it by a joint of this type, the bodies of the joint in both orders."""
    first = body("a", 2.0, [0.3, 0.4, 0.5, 0.01, 0.02, 0.0], position=[0, 0, 1], rotation=[0.9, 0.1, 0.2, 0.3])
    first |= {"velocity": [0.1, 0, 0.2], "angular_velocity": [0.5, -0.4, 0.3]}
    second = body("b", 1.0, [0.1, 0.15, 0.2], guess={"rotation": [0.9, -0.1, 0.3, 0.1]})
    model = {"bodies": [first, second], "joints": [joint("joint", kind, "b", "a") | HELD | keys]}
    return {"model": model, "integrator": {"step": 1e-3, "end_time": 0.05}}


def silent(_):
    pass


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("spherical", {}),
        ("revolute", {"axes": [Y, Y], "references": [X, X], "angle": 0.3, "rate": 2.0}),
        ("prismatic", {"axes": [X, X], "references": [Z, Z], "displacement": 0.2, "speed": 0.4}),
        ("cylindrical", {"axes": [Z, Z], "references": [X, X], "displacement": 0.2, "rate": 1.0}),
        ("universal", {"axes": [Z, X], "references": [X, Z]}),
        ("fixed", {"axes": [Z, Z], "references": [X, X]}),
    ],
)
@pytest.mark.parametrize("reverse", [False, True])
def test_accelerations_and_motion_are_those_of_mujoco(kind, keys, reverse):
    data = scenario(kind, **keys)
    if reverse:
        data["model"]["joints"][0]["bodies"].reverse()
    found = check(data, runs=1, steps=20, tell=silent)
    assert found.agrees, found.sentence
    assert {x.name for x in found.differences} == {"acceleration", "angular_acceleration", "position", "rotation"}
    assert max(x.relative for x in found.differences if x.time == 0.0) < 1e-11


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("revolute", {"axes": [Y, Y], "references": [X, X], "angle": 0.3, "rate": 2.0}),
        ("prismatic", {"axes": [X, X], "references": [Z, Z], "displacement": 0.2, "speed": 0.4}),
    ],
)
def test_rotors_are_those_of_mujoco(kind, keys):
    found = check(scenario(kind, armature=0.7, **keys), runs=1, steps=20, tell=silent)
    assert found.agrees, found.sentence


def test_a_run_that_fails_is_named_and_hides_no_other():
    data = {"model": {"gravity": [0, 0, 0], "bodies": [resting()]}, "integrator": {"step": 0.1, "end_time": 1.0}}
    runs = {"sampler": "table", "table": {"columns": {"bodies.b.angular_velocity[2]": [1.0, 1e5, 1.5]}}}
    found = check(data | {"sweep": runs}, runs=3, steps=10, tell=silent)
    assert not found.agrees
    assert found.headline == "2 of 3 runs, 20 of 30 steps, by MuJoCo of RK4"
    assert found.sentence.startswith("run 1 ends as rotation_too_large, and only what succeeds is compared")
    assert {x.run for x in found.differences} <= {0, 2}


def test_undefined_numbers_of_mujoco_are_differences(monkeypatch):
    monkeypatch.setattr(mujoco._Theirs, "after", lambda self, steps: (np.full((2, 3), np.nan), np.zeros((2, 3, 3))))
    found = check(scenario("spherical"), runs=1, steps=20, tell=silent)
    assert not found.agrees
    assert "position differs by inf" in found.sentence


@pytest.mark.parametrize(("name", "what"), [("four_bar", "model.joints: rocker_bearing"), ("slider_crank", "")])
def test_what_has_no_equivalent_is_refused(name, what):
    with pytest.raises(ScenarioError, match=f"{what}.*MuJoCo has no equivalent"):
        check(f"scenarios/{name}.toml", 1, 10, silent)
