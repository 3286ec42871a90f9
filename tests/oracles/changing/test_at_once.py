"""What happens at one time: several events, one that changes what a stop feels, one that ends the run; changes at times
that are stored, and at the end."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch import statuses
from tests.oracles.changing import scenarios
from tests.rigs import parts

G, MASS, PULL = 9.81, 20.0, 250.0


def slide(end: float, events: list[Any], **more: Any) -> dict[str, Any]:
    """A gate on a vertical slide that falls on its sill from one metre, and a winch."""
    model = {
        "gravity": [0, 0, -G],
        "bodies": [parts.body("gate", MASS, 1.0)],
        "joints": [parts.slide("rail", "gate", parts.Z, displacement=1.0, speed=0)],
        "forces": [{"name": "winch", "type": "actuator", "joint": "rail", "value": "pull"}],
        "limits": [{"name": "sill", "joint": "rail", "low": 0.0}],
    }
    seen = {"quantities": parts.observed("joint", "rail"), "events": events, "parameters": {"pull": 0.0}}
    return scenarios.scenario("A gate", model, end, coordinates="joint") | seen | more


def event(name: str, when: str, action: str, **more: Any) -> dict[str, Any]:
    joint = {"joint": "rail"} if action in ("lock", "unlock") else {}
    return {"name": name, "when": when, "action": action} | joint | more


def test_a_number_that_is_set_lifts_what_lies() -> None:
    """The winch pulls by more than the weight at t = 1; the gate is locked where it lies, and freed at that time."""
    pull = event("hoist", "t > 1", "set", parameters={"pull": PULL})
    for events in [pull], [event("catch", "t > 0.7", "lock"), event("open", "t > 1", "unlock"), pull]:
        ds = lienumba.run(slide(1.5, events)).isel(run=0)
        assert float(ds["rail.displacement"][-1]) == pytest.approx(0.5 * (PULL / MASS - G) * 0.5**2, abs=1e-11)
        assert ds.change_time.values[scenarios.kinds(ds, "opened")] == pytest.approx([1.0])
        assert abs(ds.energy_residual).max() < 1e-10


def test_stored_states_at_a_change_are_those_before_it_and_the_last_one_that_behind() -> None:
    data = slide(0.4, [event("catch", "t >= 0.2", "lock"), event("at_last", "t >= 0.4", "unlock")])
    ds = lienumba.run(data | {"output": {"times": [0, 0.2, 0.3, 0.4]}}).isel(run=0)
    np.testing.assert_allclose(ds["rail.speed"], [0, -G * 0.2, 0, 0], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(ds["mode"].sel(switch="rail.lock"), [0, 0, 1, 1])
    assert int(ds.last_mode.sel(switch="rail.lock")) == 0
    np.testing.assert_allclose(ds.change_time[:2], [0.2, 0.4], rtol=0, atol=1e-15)
    assert abs(ds.energy_residual).max() < 1e-12


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_that_is_so_where_times_are_equal_up_to_rounding(method: str) -> None:
    """Walls are hit at the times that are stored, as a search finds them, on either side."""
    body = parts.resting("body", 1, 1, velocity=[1, 0, 0])
    wall = parts.foot("wall", "body", on=[1, 0, 0], normal=[-1, 0, 0], restitution=0.5)
    times = np.arange(61) * (1 / 60)
    ds = lienumba.run({
        "model": {"gravity": [0] * 3, "bodies": [body], "contacts": [wall]},
        "integrator": scenarios.settings(1.0, 1e-9, method=method), "output": {"times": times.tolist()},
        "sweep": scenarios.table({"contacts.wall.points[1][0]": times[1:-1].tolist()}),
    })  # fmt: skip
    np.testing.assert_allclose(ds.change_time[:, 0], times[1:-1], rtol=1e-14)
    assert (ds.change_time[:, 0].values < times[1:-1]).any()
    before = np.arange(61) <= np.arange(1, 60)[:, None]
    np.testing.assert_allclose(ds.velocity[..., 0, 0], np.where(before, 1.0, -0.5), rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_run_that_ends_where_it_is_stored_has_that_state(method: str) -> None:
    """Also where its end is found before that time by rounding."""
    body = parts.resting("body", 1, 1, velocity=[1, 0, 0])
    times = np.arange(61) * (1 / 60)
    ds = lienumba.run({
        "parameters": {"far": 0.5},
        "model": {"gravity": [0] * 3, "bodies": [body]},
        "quantities": [{"name": "centre", "type": "point", "body": "body"}],
        "events": [{"name": "there", "when": "centre.x > far", "action": "stop"}],
        "integrator": scenarios.settings(1.0, 1e-9, method=method), "output": {"times": times.tolist()},
        "sweep": scenarios.table({"parameters.far": times[1:-1].tolist()}),
    })  # fmt: skip
    assert (ds.end_time.values < times[1:-1]).any()
    np.testing.assert_array_equal(np.isfinite(ds.position[..., 0, 0]).sum("time"), np.arange(2, 61))
    np.testing.assert_allclose(ds.last_position[:, 0, 0], times[1:-1], rtol=0, atol=1e-14)


def test_an_event_that_ends_the_run_goes_first() -> None:
    """What acts does not happen then, nor is it counted: beside what ends the run, at the start, and caused with it."""
    together = [event("catch", "t > 0.2", "lock"), event("enough", "t > 0.2", "stop")]
    ds = lienumba.run(slide(0.4, together)).isel(run=0)
    assert (int(ds.changes), float(ds.end_time), ds.event_count.values.tolist()) == (0, 0.2, [0, 1])
    falls = [event("catch", "rail.speed < -1", "lock"), event("enough", "rail.speed < -1", "stop")]
    ds = lienumba.run(slide(0.4, falls)).isel(run=0)
    assert (int(ds.changes), ds.event_count.values.tolist()) == (0, [0, 1])
    at_once = [event("catch", "t >= 0", "lock"), event("seen", "t >= 0", "record"), event("enough", "t >= 0", "stop")]
    ds = lienumba.run(slide(0.4, at_once)).isel(run=0)
    assert (int(ds.changes), float(ds.end_time), ds.event_count.values.tolist()) == (0, 0.0, [0, 1, 1])
    assert np.isnan(ds.event_time[0])
    caused = [event("catch", "t > 0.2", "lock"), event("enough", "rail.speed > -1 and t > 0.15", "stop")]
    caused.append(event("free", "rail.speed > -1 and t > 0.15", "unlock"))
    ds = lienumba.run(slide(0.4, caused)).isel(run=0)
    assert (int(ds.changes), float(ds.end_time), ds.event_count.values.tolist()) == (1, 0.2, [1, 1, 0])


def test_once_is_once() -> None:
    wave = "sin(20*t) > 0.5"
    events = [event("catch", wave, "lock", once=True), event("free", "sin(20*t) < -0.5", "unlock")]
    data = slide(0.4, events)
    data["integrator"]["max_step"] = 0.02
    ds = lienumba.run(data).isel(run=0)
    assert scenarios.kinds(ds, "locked").sum() == 1
    data["events"][0]["once"] = False
    assert scenarios.kinds(lienumba.run(data).isel(run=0), "locked").sum() == 2


@pytest.mark.parametrize("settings", [{"method": "dop853", "tolerance": 1e-9}, {"method": "rk4", "step": 0.01}])
@pytest.mark.parametrize("action", ["stop", "record", "lock"])
def test_an_event_where_a_stop_is_hit_comes_with_it(action: str, settings: dict[str, Any]) -> None:
    """Rounding says which of the two is found first: the run ends before the gate bounces, the event is counted, and
    what catches the gate catches it, whatever it would have given back."""
    down = [event("down", "rail.displacement < 0", action)]
    data = slide(0.5, down) | {"integrator": settings | {"end_time": 0.5, "coordinates": "joint"}}
    data["model"]["limits"][0]["restitution"] = 0.3
    heights = np.random.default_rng(4).uniform(0.6, 1.2, 64)
    hits = np.sqrt(2 * heights / G)
    ds = lienumba.run(data | {"sweep": scenarios.table({"joints.rail.displacement": heights.tolist()})})
    assert (ds.status == (statuses.STOPPED if action == "stop" else statuses.SUCCESS)).all()
    assert (ds.event_count == 1).all()
    np.testing.assert_allclose(ds.event_time[:, 0], hits, rtol=0, atol=1e-12)
    speed = {"stop": -G * hits, "record": 0.3 * G * hits - G * (0.5 - hits), "lock": 0.0 * hits}[action]
    np.testing.assert_allclose(ds.last_velocity[:, 0, 2], speed, rtol=0, atol=1e-9)


@pytest.mark.parametrize("action", ["stop", "record"])
def test_so_it_does_far_away_and_slowly(action: str) -> None:
    """Where rounding of positions, over a small speed, is more than that of times."""
    body = parts.resting("body", 1, 1, [11, 0, 0], velocity=[-1e-3, 0, 0])
    wall = parts.sphere("wall", "body", 0.1, on=[10, 0, 0], normal=[1, 0, 0], restitution=0.5)
    starts = 10.1 + np.random.default_rng(5).uniform(0.01, 0.5, 64)
    ds = lienumba.run({
        "model": {"gravity": [0] * 3, "bodies": [body], "contacts": [wall]},
        "quantities": [{"name": "centre", "type": "point", "body": "body"}],
        "events": [{"name": "there", "when": "centre.x < 10.1", "action": action}],
        "integrator": scenarios.settings(600.0, 1e-9), "output": {"times": [0, 600.0]},
        "sweep": scenarios.table({"bodies.body.position[0]": starts.tolist()}),
    })  # fmt: skip
    assert (ds.event_count == 1).all()
    assert (ds.changes == (0 if action == "stop" else 1)).all()


@pytest.mark.parametrize("settings", [{"method": "dop853", "tolerance": 1e-9}, {"method": "rk4", "step": 0.01}])
def test_what_a_latch_does_not_hold_comes_back(settings: dict[str, Any]) -> None:
    """A ball reaches the floor at the time at which the gate beside it reaches its stop and is caught there."""
    data = slide(0.5, [event("down", "rail.displacement < 0", "lock")])
    data |= {"integrator": settings | {"end_time": 0.5, "coordinates": "joint"}}
    data["model"]["limits"][0]["restitution"] = 0.3
    heights = np.random.default_rng(6).uniform(0.6, 1.2, 16)
    ball = parts.resting("ball", 2, 1, [5, 0, "drop + 0.1"])
    floor = parts.sphere("floor", "ball", 0.1, on=[5, 0, 0], normal=[0, 0, 1], restitution=0.6)
    data["model"]["bodies"].append(ball)
    data["model"]["contacts"] = [floor]
    data["parameters"]["drop"] = 1.0
    vary = {"joints.rail.displacement": heights.tolist(), "parameters.drop": heights.tolist()}
    ds = lienumba.run(data | {"sweep": scenarios.table(vary)})
    assert (ds.status == statuses.SUCCESS).all()
    hits = np.sqrt(2 * heights / G)
    np.testing.assert_allclose(ds.last_velocity[:, 0, 2], 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ds.last_velocity[:, 1, 2], 0.6 * G * hits - G * (0.5 - hits), rtol=0, atol=1e-9)
