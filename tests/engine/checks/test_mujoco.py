"""The engine against MuJoCo: accelerations to roundoff, positions by the errors of the steps; and what it lacks."""

import pytest

from lienumba.engine.checks.mujoco import check
from tests.facade import ScenarioError
from tests.rigs.parts import X, Y, Z, body, joint

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


@pytest.mark.parametrize(("name", "what"), [("four_bar", "model.joints: rocker_bearing"), ("slider_crank", "")])
def test_what_has_no_equivalent_is_refused(name, what):
    with pytest.raises(ScenarioError, match=f"{what}.*MuJoCo has no equivalent"):
        check(f"scenarios/{name}.toml", 1, 10, silent)
