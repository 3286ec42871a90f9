"""Events that contradict each other at one time act in the order of the file; what has acted comes true again only when
it has really been false. A body on a slide, whose motion has a closed form."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

WAYS = [{"coordinates": "joint"}, {"coordinates": "lie"}, {"coordinates": "joint", "method": "taylor"}]


def slide(events: list[Any], end: float = 1.0, *, way: dict[str, Any] = WAYS[0], **joint: Any) -> dict[str, Any]:
    """It rises by half the acceleration, 1 m/s2, times the square of the time."""
    gate = parts.resting("gate", 2.0, 1.0)
    rail = parts.slide("rail", "gate", parts.Z, **joint)
    model = {"gravity": [0, 0, 1.0], "bodies": [gate], "joints": [rail]}
    return scenarios.scenario("A gate", model, end, **way) | {
        "quantities": [*parts.observed("joint", "rail"), {"name": "gate", "type": "point", "body": "gate"}],
        "events": events,
    }


def event(name: str, when: str, action: str, **more: Any) -> dict[str, Any]:
    return {"name": name, "when": when, "action": action, "joint": "rail"} | more


def told(ds: Any) -> list[str]:
    """What happened, in its order."""
    names, codes = ds.change_kind.flag_meanings.split(), ds.change_kind.flag_values.tolist()
    return [names[codes.index(kind)] for kind in ds.change_kind.values if kind >= 0]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("on", [True, False])
@pytest.mark.parametrize("turns", [("lock", "unlock"), ("unlock", "lock")])
def test_of_two_that_contradict_each_other_the_last_of_the_file_has_the_say(
    way: dict[str, Any], on: bool, turns: tuple[str, str]
) -> None:
    """Each sees what the one before it has done, and does nothing where that is so already."""
    whens = ("t > 0.5", "t > 1 - 0.5"), ("rail.displacement > 0.125", "8*rail.displacement > 1")
    does = [turn for turn, was in zip(turns, (on, turns[0] == "lock"), strict=True) if (turn == "lock") != was]
    moves = {"lock": 0.0 if on else 0.125, "unlock": 0.125 if on else 0.5}
    for when in whens[:1] if on else whens:
        events = [event(f"e{n}", at, turn) for n, (at, turn) in enumerate(zip(when, turns, strict=True))]
        ds = lienumba.run(slide(events, way=way, locked=True) if on else slide(events, way=way)).isel(run=0)
        assert told(ds) == [{"lock": "locked", "unlock": "released"}[x] for x in does]
        np.testing.assert_allclose(ds["change_time"][: len(does)], 0.5, rtol=0, atol=1e-12)
        assert int(ds.last_mode[-1]) == (turns[1] == "lock")
        assert float(ds.position[-1, 0, 2]) == pytest.approx(moves[turns[1]], abs=1e-12)
        assert abs(ds.energy_residual).max() < 1e-12


@pytest.mark.parametrize("turns", [("release", "engage"), ("engage", "release")])
def test_a_joint_that_is_released_and_engaged_at_once_is_as_the_last_leaves_it(turns: tuple[str, str]) -> None:
    """What the last one releases need not close, and is not hit."""
    for active, does in (True, turns if turns[0] == "release" else turns[1:]), (
        False, turns if turns[0] == "engage" else turns[1:],
    ):  # fmt: skip
        events = [
            event(f"e{n}", when, turn)
            for n, (when, turn) in enumerate(zip(("gate.z > 0.125", "2*gate.z > 0.25"), turns, strict=True))
        ]
        data = slide(events, active=active)
        data["model"]["bodies"][0] |= {"position": [0 if active else 0.03 * (turns[1] == "release"), 0, 0]}
        ds = lienumba.run(data).isel(run=0)
        assert told(ds) == [f"{x}d" for x in does]
        assert int(ds.last_mode[0]) == (turns[1] == "engage")
        assert float(ds.position[-1, 0, 2]) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize("way", WAYS)
def test_a_latch_that_is_opened_where_it_holds_does_not_close_again(way: dict[str, Any]) -> None:
    """Though its condition is beside its limit there, by rounding on either side; when the gate has been below, it
    does."""
    catch, free = event("catch", "rail.displacement > 0.125", "lock"), event("free", "t > 1", "unlock")
    turn = {"name": "turn", "when": "t > 2", "action": "set", "parameters": {"lift": -10.0}}
    data = slide([catch, free, turn], 4.0, way=way | {"max_step": 0.1})
    lift = {"name": "lift", "type": "actuator", "joint": "rail", "value": "lift"}
    data |= {"parameters": {"lift": 0.0}, "sweep": scenarios.table({"gravity[2]": np.linspace(1.0, 1.9, 24)})}
    data["model"]["forces"] = [lift]
    back = {"name": "back", "when": "t > 3", "action": "set", "parameters": {"lift": 20.0}}
    ds = lienumba.run(data)
    np.testing.assert_array_equal(ds.event_count.sel(event="catch"), 1)
    g = ds["gravity[2]"].values
    up, v = 0.125 + 0.5 * g, g
    np.testing.assert_allclose(ds.position[:, -1, 0, 2], up + 2 * v + 0.5 * (g - 5) * 4, rtol=0, atol=1e-11)
    data["events"].append(back)
    again = lienumba.run(data)
    z, v, a = up + v + 0.5 * (g - 5), v + (g - 5), g + 10  # at t = 3, and how it goes on
    below = z - v**2 / (2 * a) < 0.125
    meets = 3 + (-v + np.sqrt(np.maximum(v**2 + 2 * a * (0.125 - z), 0))) / a
    np.testing.assert_array_equal(again.event_count.sel(event="catch"), 1 + below)
    assert 0 < below.sum() < len(g)
    found = again.change_time.values[np.arange(len(g)), again.changes.values - 1]
    np.testing.assert_allclose(found[below], meets[below], rtol=0, atol=1e-11)


def test_what_jumps_back_to_zero_is_false_again() -> None:
    """A condition of what is on or off, and never below 0."""
    sees = {"name": "sees", "when": "bolt.on > 0"}
    events = [event("hold", "sin(20*t) > 0.5", "lock"), event("free", "sin(20*t) < -0.5", "unlock"), sees]
    data = slide(events)
    data["quantities"].append({"name": "bolt", "type": "lock", "joint": "rail"})
    data["integrator"]["max_step"] = 0.02
    ds = lienumba.run(data).isel(run=0)
    counts = dict(zip(ds.event.values.tolist(), ds.event_count.values.tolist(), strict=True))
    assert counts == {"hold": 4, "free": 3, "sees": 4}


def test_what_does_nothing_is_no_event_wherever_it_comes_true() -> None:
    """At the start; by an impact, once; and of a joint that is gone."""
    ds = lienumba.run(slide([event("hold", "t >= 0", "lock")], locked=True)).isel(run=0)
    assert (told(ds), ds.event_count.values.tolist()) == ([], [0])
    gone = [event("let_go", "t > 0.2", "release"), event("hold", "gate.z > 0.125", "lock")]
    ds = lienumba.run(slide(gone)).isel(run=0)
    assert (told(ds), ds.event_count.values.tolist()) == (["released"], [1, 0])
    assert float(ds.position[-1, 0, 2]) == pytest.approx(0.5, abs=1e-12)
    bounces = {"name": "stop", "joint": "rail", "high": 0.125, "restitution": 0.5}
    first = {"name": "first", "when": "rail.speed < -0.01", "action": "set", "parameters": {"lift": 0.5}, "once": True}
    data = slide([first, {"name": "each", "when": "rail.speed < -0.01"}], 2.0) | {"parameters": {"lift": 0.0}}
    data["model"] |= {"limits": [bounces]}
    data["model"]["forces"] = [{"name": "lift", "type": "actuator", "joint": "rail", "value": "lift"}]
    ds = lienumba.run(data).isel(run=0)
    assert int(ds.event_count[0]) == 1
    assert int(ds.event_count[1]) > 2


def test_what_is_set_is_not_told_as_lost_by_what_is_engaged_at_once() -> None:
    """The potential energy of a spring whose force is set while the gate is caught; it loses its kinetic energy."""
    events = [
        {"name": "wind", "when": "t > 0.5", "action": "set", "parameters": {"rest": 1.0}},
        event("catch", "t > 1 - 0.5", "engage"),
    ]
    data = slide(events) | {"parameters": {"rest": 0.0}}
    data["model"]["joints"][0] |= {"active": False, "type": "fixed", "points": [[0, 0, 0.125], [0, 0, 0]]}
    del data["model"]["joints"][0]["axes"], data["quantities"][0]
    spring = {"name": "spring", "type": "spring_damper", "bodies": ["ground", "gate"], "stiffness": 1e-12}
    data["model"]["forces"] = [spring | {"damping": 0, "free_length": "1e6*rest", "points": [[0, 3, 0], [0, 0, 0]]}]
    ds = lienumba.run(data).isel(run=0)
    assert told(ds) == ["set", "engaged"]
    np.testing.assert_allclose(ds.change_energy[:2], [0, 0.25], rtol=0, atol=1e-9)
    assert abs(ds.energy_residual).max() < 1e-11
