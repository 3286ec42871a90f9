"""Samples of limits and contacts: those that begin beyond, or that nothing has, are marked; others go on."""

import pytest

from lienumba.batch.statuses import INVALID, NOT_ASSEMBLED, SUCCESS
from lienumba.scenario.base.units import units
from lienumba.scenario.start.prepare import check_initial, prepare
from tests.facade import ScenarioError, resolve

BODY = {"name": "b", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "rotation": [1, 0, 0, 0]}
RAIL = {"name": "rail", "type": "prismatic", "bodies": ["ground", "b"], "points": [[0, 0, 0]] * 2,
        "axes": [[1, 0, 0]] * 2}  # fmt: skip
STOP = {"joint": "rail", "low": -1.0, "high": 2.0, "restitution": 0.5}
FLOOR = {"name": "floor", "type": "sphere_plane", "bodies": ["b", "ground"], "points": [[0, 0, 0], [0, 0, -1]],
         "radius": 0.5, "restitution": 0.1, "friction": {"static": 0.5, "kinetic": 0.4}}  # fmt: skip


def scenario(path: str, *values: float) -> dict:
    given = {"column": path}
    return {
        "model": {"bodies": [{**BODY, "position": [0.0, 0, 0]}], "joints": [RAIL], "limits": [STOP],
                  "contacts": [FLOOR]},
        "integrator": {"step": 1e-3, "end_time": 0.01},
        "sweep": {"runs": len(values), "sampler": "table", "table": {"columns": {path: list(values)}},
                  "vary": {path: given}},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("path", "fine", "wrong", "code"),
    [
        ("bodies.b.position[0]", 2.0, 2.001, NOT_ASSEMBLED),
        ("limits.rail.low", 0.0, 1e-6, NOT_ASSEMBLED),
        ("contacts.floor.radius", 1.0, 1.1, NOT_ASSEMBLED),
        ("contacts.floor.points[1][2]", -0.5, -0.4, NOT_ASSEMBLED),
        ("contacts.floor.radius", 0.1, -0.1, INVALID),
        ("contacts.floor.friction.static", 0.4, 0.3, INVALID),
        ("contacts.floor.friction.kinetic", 0.0, -0.1, INVALID),
        ("limits.rail.restitution", 1.0, 1.1, INVALID),
        ("contacts.floor.restitution", 0.0, -0.1, INVALID),
    ],
)
def test_a_run_that_cannot_be_is_marked(path: str, fine: float, wrong: float, code: int) -> None:
    ready = prepare(resolve(scenario(path, fine, wrong, fine)), range(3))
    assert ready.codes.tolist() == [SUCCESS, code, SUCCESS]


def test_units_of_what_varies() -> None:
    model = resolve(scenario("limits.rail.low", -1.0, -2.0)).data.model
    named = dict(model)
    assert units("limits.rail.low", named) == "m"
    assert units("limits.rail.rest_speed", named) == "m s-1"
    assert units("limits.rail.restitution", named) == "1"
    assert units("contacts.floor.radius", named) == "m"
    assert units("contacts.floor.stiffness", named) == "N m-1"
    assert units("contacts.floor.friction.static", named) == "1"


def test_all_inside_is_an_error_of_the_scenario() -> None:
    with pytest.raises(ScenarioError, match="no sampled run can be assembled"):
        prepare(resolve(scenario("contacts.floor.radius", 1.1, 1.2)), range(2))


def test_a_joint_that_waits_counts_neither_in_rank_nor_in_the_start() -> None:
    data = scenario("limits.rail.low", -1.0)
    del data["sweep"]
    other = {**BODY, "name": "c", "position": [3.0, 0, 0], "velocity": [0.0, 1.0, 0.0]}
    weld = {"name": "weld", "type": "fixed", "bodies": ["b", "c"], "points": [[0, 0, 0]] * 2, "active": False}
    data["model"]["bodies"].append(other)
    data["model"]["joints"].append(weld)
    data["events"] = [{"name": "catch", "when": "t > 0.005", "action": "engage", "joint": "weld"}]
    nominal = check_initial(resolve(data))
    assert (nominal.rank.rows, nominal.rank.rank, nominal.rank.freedom) == (5, 5, 7)
    assert nominal.now.bodies[1][0:3] == (3.0, 0.0, 0.0)
    assert [joint.switched for joint in nominal.model.joints] == [False, True]


def test_a_joint_that_is_let_go_holds_at_the_start_and_shares_its_reactions() -> None:
    data = scenario("limits.rail.low", -1.0)
    del data["sweep"]
    second = {**RAIL, "name": "second", "points": [[0, 1, 0], [0, 1, 0]]}
    data["model"]["joints"].append(second)
    data["events"] = [{"name": "drop", "when": "t > 0.005", "action": "release", "joint": "second"}]
    nominal = check_initial(resolve(data))
    assert (nominal.rank.rows, nominal.rank.rank, nominal.rank.freedom) == (10, 5, 1)
    assert nominal.rank.shared == ("rail", "second")
    assert (nominal.lasting.rows, nominal.lasting.rank, nominal.lasting.exchangeable) == (5, 5, ())


HINGE = {"name": "hinge", "type": "revolute", "bodies": ["b", "c"], "points": [[0, 0, 0]] * 2, "axes": [[0, 0, 1]] * 2,
         "locked": True}  # fmt: skip


def hinged(hinge: dict, **says: list[float]) -> dict:
    """A body that moves, and one on it by a joint that begins locked."""
    data = scenario("limits.rail.low", -1.0)
    del data["sweep"]
    data["model"]["joints"].append(HINGE | hinge)
    data["model"]["bodies"][0] |= {"velocity": [0.25, 0, 0], "angular_velocity": [0, 0, 0]}
    data["model"]["bodies"].append({**BODY, "name": "c"} | says)
    data["events"] = [{"name": "let", "when": "t > 0.005", "action": "unlock", "joint": "hinge"}]
    return data


def test_a_joint_that_begins_locked_begins_at_rest() -> None:
    (*_, vx, vy, vz, wx, wy, wz) = check_initial(resolve(hinged({}))).now.bodies[1]
    assert (vx, vy, vz, wx, wy, wz) == pytest.approx((0.25, 0, 0, 0, 0, 0), abs=1e-12)


@pytest.mark.parametrize(
    ("hinge", "says", "message"),
    [
        (
            {"rate": 0.5}, {},
            "model.joints.hinge.rate = 0.5: must be 0 where the joint begins locked; give 0, or leave out one of the "
            "two",
        ),
        (
            {}, {"angular_velocity": [0, 0, 0.5]},
            "model.joints.hinge.locked: contradicts what else is given for the start, by 0.5 rad/s",
        ),
    ],
)  # fmt: skip
def test_a_joint_that_begins_locked_and_turns_is_told(hinge: dict, says: dict, message: str) -> None:
    with pytest.raises(ScenarioError) as error:
        check_initial(resolve(hinged(hinge, **says)))
    assert message in str(error.value)
