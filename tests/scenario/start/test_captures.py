"""What an event engages has to be able to close; where it never can, the scenario is refused in a sentence."""

from typing import Any

import pytest

from lienumba.scenario.start.prepare import check_initial
from tests.facade import ScenarioError, resolve

PIN = {"name": "pin", "type": "spherical", "active": False}
SHUT = {"name": "shut", "when": "t > 0.1", "action": "engage", "joint": "pin"}


def bar(name: str) -> dict[str, Any]:
    return {"name": name, "mass": 1.0, "inertia": [0.01, 0.1, 0.1]}


def hinge(name: str, a: str, b: str, p: list[float], q: list[float], kind: str = "revolute") -> dict[str, Any]:
    turns = {"axes": [[0, 1, 0]] * 2, "references": [[1, 0, 0]] * 2} if kind != "spherical" else {}
    return {"name": name, "type": kind, "bodies": [a, b], "points": [p, q]} | turns


def scenario(there: list[Any], joints: list[Any], **pin: Any) -> dict[str, Any]:
    model = {"gravity": [0, 0, 0], "bodies": there, "joints": [*joints, PIN | pin]}
    return {"model": model, "events": [SHUT], "integrator": {"step": 1e-2, "end_time": 0.2}}


def chain(x: float) -> dict[str, Any]:
    """Two bars of one metre, one behind the other, whose end is to come to a point on the ground."""
    hinges = [
        hinge("root", "ground", "a", [0, 0, 0], [-0.5, 0, 0]) | {"angle": 0.5, "rate": 0},
        hinge("elbow", "a", "b", [0.5, 0, 0], [-0.5, 0, 0]) | {"angle": 0.5, "rate": 0},
    ]
    return scenario([bar("a"), bar("b")], hinges, bodies=["ground", "b"], points=[[x, 0, 0], [0.5, 0, 0]])


def accepted(data: dict[str, Any]) -> None:
    check_initial(resolve(data))


def refused(data: dict[str, Any]) -> str:
    with pytest.raises(ScenarioError) as said:
        accepted(data)
    return str(said.value)


def test_what_no_length_bridges_is_told_before_the_run() -> None:
    assert refused(chain(2.25)) == (
        'events.shut.joint = "pin": can never close: with root and elbow its points stay 0.25 m apart; correct its '
        "points, or those of these joints"
    )
    accepted(chain(1.99))


def test_a_point_too_near_is_as_far() -> None:
    long = chain(0.5)
    long["model"]["joints"][0]["points"][1] = [-2.0, 0, 0]
    assert "with root and elbow its points stay 1 m apart" in refused(long)


def test_bodies_that_cannot_move_do_not_meet() -> None:
    """Through slides, whose points do not stay together, only the rank tells."""
    slide = hinge("slide", "ground", "a", [0, 0, 0], [0, 0, 0], "prismatic") | {"displacement": 0, "speed": 0}
    weld = hinge("weld", "ground", "a", [0, 0, 0], [0, 0, 0], "fixed")
    pin = {"bodies": ["ground", "a"], "points": [[0, 0.3, 0], [0, 0, 0]]}
    accepted(scenario([bar("a")], [slide], **pin))
    assert "with weld its points stay 0.3 m apart" in refused(scenario([bar("a")], [weld], **pin))
    blocked = [slide, slide | {"name": "other", "axes": [[1, 0, 0]] * 2, "references": [[0, 1, 0]] * 2}]
    blocked = [{key: x for key, x in joint.items() if key not in ("displacement", "speed")} for joint in blocked]
    assert refused(scenario([bar("a")], blocked, **pin)) == (
        'events.shut.joint = "pin": can never close: it is open, and ground and a cannot move against each other; '
        "correct its points, or give a joint that lets them move"
    )


def test_a_driver_that_goes_on_moving_what_is_to_be_held_is_told_before_the_run() -> None:
    """By a driver that stands still once, as by a joint that leaves its motion, nothing is known before."""
    slide = {"name": "slide", "type": "prismatic", "bodies": ["ground", "a"], "at": [0, 0, 0], "axis": [1, 0, 0]}
    there = [bar("a") | {"position": [0, 0, 0]}]
    data = scenario(there, [slide], bodies=["ground", "a"], points=[[0.01, 0, 0], [0, 0, 0]])
    data["model"]["drivers"] = [{"name": "pull", "joint": "slide", "value": "0.1*t"}]
    assert refused(data) == (
        'events.shut.joint = "pin": can never hold: model.drivers.pull moves its bodies against each other all the '
        "time; let the driver come to rest, or let a force move them"
    )
    data["model"]["drivers"][0]["value"] = "0.1*t**2"
    accepted(data)
    data["model"]["drivers"][0]["value"] = "0.1*t"
    data["model"]["joints"][1] |= {"type": "prismatic", "axes": [[1, 0, 0]] * 2, "references": [[0, 0, 1]] * 2}
    accepted(data)
