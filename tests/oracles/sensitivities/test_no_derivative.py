"""What has no derivative is refused in a sentence, or flagged."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch.tangents.changes import GRAZING, MISSING, SIMULTANEOUS, TOUCHED
from tests.oracles.changing import scenarios
from tests.oracles.changing.scenarios import G
from tests.oracles.sensitivities.differences import apart, derivatives, differences
from tests.rigs import parts

FEET = (("low", 0.5), ("high", -0.5))


def rod(ends: tuple[tuple[str, float], ...] = FEET) -> dict[str, Any]:
    """A rod of 1 m falls flat on feet, in runs of 0.5 s."""
    J = 1 / 12
    feet = [parts.foot(name, "rod", [x, 0, 0], restitution=0.5, rest_speed=0.01) for name, x in ends]
    body = parts.resting("rod", 1, [1e-3, J, J], [0, 0, 0.5])
    return scenarios.scenario("A rod", {"gravity": [0, 0, -G], "bodies": [body], "contacts": feet}, 0.5)


def pendulum(**keys: Any) -> dict[str, Any]:
    """A pendulum, in runs of 1 s."""
    place = parts.frames(parts.Y, second=[0, 0, 0.5]) | {"angle": 1.2, "rate": 0}
    joints = [parts.joint("pivot", "revolute", "bob", **place)]
    model = {"gravity": [0, 0, -G], "bodies": [parts.body("bob", 1, 0.3)], "joints": joints} | keys
    data = scenarios.scenario("A pendulum", model, 1.0, coordinates="joint")
    return data | {"quantities": parts.observed("joint", "pivot")}


# ---------------------------------------------------------------- flagged
@pytest.mark.parametrize(("path", "flag"), [("angular_velocity[1]", SIMULTANEOUS), ("position[2]", 0)])
def test_impacts_at_once_that_an_input_parts(path: str, flag: int) -> None:
    """A rod that turns a little lands on one foot first; one that falls from elsewhere on both, all the same."""
    ds = derivatives(rod(), ["velocity"], {f"bodies.rod.{path}": 0.0 if flag else 0.5})
    assert int(ds.sensitivity_flags) == flag
    assert float(np.abs(ds.d_velocity[-1]).max()) > 0.5


def test_two_contacts_that_take_one_impulse() -> None:
    """What the restitution of one of two feet at one place does, is another thing upwards than downwards."""
    ds = derivatives(rod((("one", 0.0), ("other", 0.0))), ["velocity"], {"contacts.one.restitution": 0.5})
    assert int(ds.sensitivity_flags) == SIMULTANEOUS


def test_a_hinge_with_dry_friction_hits_its_stop() -> None:
    """It slides through the impact, which has a derivative."""
    stop = {"name": "stop", "joint": "pivot", "low": 0, "restitution": 0.5}
    data = pendulum(limits=[stop], forces=[parts.dry("pivot", 0.1, 0.2)])
    at = {"limits.stop.restitution": 0.5, "forces.dry.coulomb": 0.1}
    ds, expected = derivatives(data, ["velocity"], at), differences(data, ["velocity"], at)
    assert (int(ds.changes), int(ds.sensitivity_flags)) == (1, 0)
    assert apart(ds.d_velocity, expected["velocity"]) < 1e-8


def test_a_run_that_fails_has_none() -> None:
    """The position of a pendulum that turns too far in its step."""
    data = pendulum() | {"integrator": {"method": "rk4", "step": 0.5, "end_time": 1.0}}
    data["model"]["joints"][0]["rate"] = 50.0
    ds = derivatives(data, ["position"], {"bodies.bob.mass": 1.0})
    assert int(ds.status) != 0
    assert int(ds.sensitivity_flags) == MISSING
    assert np.isnan(ds.d_position).all()


def test_how_fast_a_condition_grows_is_beside_the_time() -> None:
    """An event near the highest point of a swing: its time changes much, and its rate is small."""
    data = pendulum()
    data["events"] = [{"name": "up", "when": "pivot.rate > 0"}, {"name": "turn", "when": "pivot.angle < -1.19999999"}]
    ds = derivatives(data | {"integrator": data["integrator"] | {"end_time": 2.0}}, ["event_time"], {"gravity[2]": -G})
    assert float(ds.event_rate[1]) < 1e-3 < float(ds.event_rate[0])


@pytest.mark.parametrize(("action", "flag"), [("record", TOUCHED), ("stop", GRAZING)])
def test_an_event_that_grazes_its_condition_is_flagged(action: str, flag: int) -> None:
    """Nearer to the highest point of a swing: its rate stays beside it."""
    data = pendulum()
    data["events"] = [{"name": "turn", "when": "pivot.angle < -1.1999999999", "action": action}]
    ds = derivatives(data | {"integrator": data["integrator"] | {"end_time": 2.0}}, ["event_time"], {"gravity[2]": -G})
    assert int(ds.sensitivity_flags) == flag
    assert np.isnan(ds.d_event_time).all()
    assert 0.0 < abs(float(ds.event_rate[0])) < 1e-4


@pytest.mark.parametrize("end_time", [1.0, 100.0])
def test_a_slow_beginning_is_not_grazing(end_time: float) -> None:
    """A pendulum let go, whose first motion is slow: t = sqrt(2 angle/(G/L sin(1.2))) nearly."""
    data = pendulum()
    data["events"] = [{"name": "off", "when": "pivot.angle < 1.2 - 1e-5"}]
    ds = derivatives(
        data | {"integrator": data["integrator"] | {"end_time": end_time}}, ["event_time"], {"gravity[2]": -G}
    )
    assert int(ds.sensitivity_flags) == 0
    assert float(ds.d_event_time.squeeze()) == pytest.approx(float(ds.event_time.squeeze()) / (2.0 * G), rel=1e-5)


# ---------------------------------------------------------------- refused
@pytest.mark.parametrize(
    ("of", "rule"),
    [
        ("status", "has no derivative"),
        ("event_count", "has no derivative"),
        ("energy_residual", "energy_residual"),
        ("nothing", "does not have"),
        ("average", "not made of values at events and of extremes"),
        ("last_energy", "does not have"),
    ],
)
def test_results_that_have_none(of: str, rule: str) -> None:
    data = pendulum() | {"measures": [{"name": "average", "value": "mean(pivot.angle)", "units": "rad"}]}
    data["events"] = [{"name": "down", "when": "pivot.angle < 0"}]
    with pytest.raises(lienumba.ScenarioError, match=rule) as caught:
        derivatives(data, [of], {"bodies.bob.mass": 1.0})
    assert "give some of" in str(caught.value) or "leave it out" in str(caught.value)


@pytest.mark.parametrize(
    ("by", "rule"),
    [
        (["bodies.bob.rotation"], "bodies.bob.rotation"),
        (["integrator.end_time"], "not part of the model"),
        (["bodies.none.mass"], "does not exist"),
        (["bodies.bob.mass", "bodies[0].mass"], "is there twice"),
    ],
)
def test_inputs_by_which_nothing_is_differentiated(by: list[str], rule: str) -> None:
    with pytest.raises(lienumba.ScenarioError, match=rule):
        lienumba.run(pendulum() | {"sensitivities": {"of": ["position"], "by": by}}, progress=False)


def test_what_is_asked_twice_and_nothing_that_varies() -> None:
    with pytest.raises(lienumba.ScenarioError, match="is there twice"):
        derivatives(pendulum(), ["position", "position"], {"bodies.bob.mass": 1.0})
    with pytest.raises(lienumba.ScenarioError, match="varies nothing"):
        lienumba.run(pendulum() | {"sensitivities": {"of": ["position"]}}, progress=False)
