"""Impacts of pendulums, rods, blocks and balls against closed forms, and what the rule gives where several happen."""

import math
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.closed_forms import (
    block_rocks,
    cradle,
    housner,
    painleve,
    rod_hits,
    rod_lies_down,
    swings_on_a_stop,
)  # fmt: skip
from tests.rigs import parts
from tests.rigs.places import SCENARIOS

G = 9.81
LENGTH = 1.0


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_pendulum_bounces_off_a_rigid_stop(coordinates: str) -> None:
    J, arm, e, amplitude = 0.3, 0.5, 0.8, 1.2
    place = parts.frames(parts.Y, second=[0, 0, arm]) | {"angle": amplitude, "rate": 0}
    model = {
        "gravity": [0, 0, -G],
        "bodies": [parts.body("bob", 1, J)],
        "joints": [parts.joint("pivot", "revolute", "bob", **place)],
        "limits": [{"name": "stop", "joint": "pivot", "low": 0, "restitution": e}],
    }
    data = scenarios.scenario("A pendulum on a stop", model, 8.0, coordinates=coordinates)
    ds = lienumba.run(data).isel(run=0)
    pulsation = math.sqrt(G * arm / (J + arm**2))
    known = swings_on_a_stop(amplitude, pulsation, e, 6)
    np.testing.assert_allclose(ds.change_time.values[scenarios.kinds(ds, "impact")][:6], known, rtol=0, atol=1e-10)
    first = (1 - e**2) * G * arm * (1 - math.cos(amplitude))
    assert ds.change_energy.values[0] == pytest.approx(first, abs=1e-11)
    assert abs(ds.energy_residual).max() < 1e-11


def rod(end: float, angle: float, height: float, **contact: Any) -> dict[str, Any]:
    """A uniform rod of 1 kg in the plane of x and z, turned upwards by `angle`, its lower end at this height."""
    J, half = LENGTH**2 / 12, 0.5 * LENGTH
    rigid = {"restitution": 0.0, "rest_speed": 0.01} | contact
    ends = [parts.foot(n, "rod", [x, 0, 0], **rigid) for n, x in (("low", half), ("high", -half))]
    place = [0, 0, height + half * math.sin(angle)]
    body = parts.resting("rod", 1, [1e-3, J, J], place, rotation=turned(angle))
    return scenarios.scenario("A rod", {"gravity": [0, 0, -G], "bodies": [body], "contacts": ends}, end)


def turned(angle: float) -> dict[str, Any]:
    return {"axis": [0, 1, 0], "angle": angle}


def test_a_rod_falls_hits_and_lies_down() -> None:
    """Without friction: the impact in closed form, then energy alone says when it lies flat, and how hard."""
    angle, height = 0.7, 0.3
    speed = math.sqrt(2 * G * height)
    fall = speed / G
    data = rod(2.0, angle, height)
    ds = lienumba.run(data).isel(run=0)
    _, rate, impulse = rod_hits(1.0, LENGTH, angle, speed, 0.0)
    impacts = scenarios.kinds(ds, "impact")
    assert ds.change_time.values[impacts][0] == pytest.approx(fall, abs=1e-11)
    assert ds.change_impulse.values[impacts][0] == pytest.approx(impulse, abs=1e-11)
    later, _ = rod_lies_down(1.0, LENGTH, angle, -rate)
    assert ds.change_time.values[impacts][1] == pytest.approx(fall + later, abs=1e-10)
    assert abs(ds.energy_residual).max() < 1e-11
    assert float(ds.energy_lost) == pytest.approx(G * (height + 0.5 * LENGTH * math.sin(angle)), abs=1e-9)
    assert abs(ds.velocity.values[-1]).max() < 1e-12


def test_painleves_rod_ends_with_a_status() -> None:
    """A rod that slides on its end: below the known friction it goes on, above it has no answer."""
    angle = math.atan(2.0)
    assert painleve(angle) == pytest.approx(4 / 3)
    data = rod(0.02, angle, 0.0, friction=0.5)
    data["model"]["bodies"][0]["velocity"] = [1.0, 0, 0]
    columns = {f"contacts.{name}.friction": np.array([1.2, 1.5]) for name in ("low", "high")}
    ds = lienumba.run(data | {"sweep": scenarios.table(columns)})
    assert scenarios.statuses(ds) == ["success", "friction_paradox"]


def test_newtons_cradle_by_newtons_rule() -> None:
    """Three balls that touch, one comes: all contacts at the same time, so the first comes back, and two go."""
    radius, v = 0.1, 1.0
    bodies, contacts = [], []
    for i, x in enumerate((-0.3, 0.0, 0.2)):
        bodies.append(parts.resting(f"b{i}", 1, 0.004, [x, 0, 0]) | ({"velocity": [v, 0, 0]} if i == 0 else {}))
        if i:
            contacts.append({
                "name": f"c{i}", "type": "sphere_sphere", "bodies": [f"b{i}", f"b{i - 1}"], "radii": [radius, radius],
                "restitution": 1.0,
            })  # fmt: skip
    data = scenarios.scenario("A cradle", {"gravity": [0, 0, 0], "bodies": bodies, "contacts": contacts}, 0.3)
    ds = lienumba.run(data).isel(run=0, time=-1)
    np.testing.assert_allclose(ds.velocity.values[:, 0], cradle(v, 3), rtol=0, atol=1e-13)
    assert abs(float(ds.energy_residual)) < 1e-13


def test_a_rocking_block_changes_its_edge_as_housner_says() -> None:
    b, h, start = 0.1, 0.4, 0.1
    lean, radius = math.atan2(b, h), math.hypot(b, h)
    J = (4 * b * b + 4 * h * h) / 12
    place = [radius * math.sin(lean - start), 0, radius * math.cos(lean - start)]
    corners = [
        parts.foot(n, "block", [x, 0, -h], friction=5.0, rest_speed=0.0) for n, x in (("left", -b), ("right", b))
    ]
    block = parts.resting("block", 1, J, place, rotation=turned(start))
    when, rate = block_rocks(b, h, start)
    model = {"gravity": [0, 0, -G], "bodies": [block], "contacts": corners}
    data = scenarios.scenario("A block that rocks", model, when + 1e-3)
    ds = lienumba.run(data).isel(run=0)
    impacts = scenarios.kinds(ds, "impact")
    assert ds.change_time.values[impacts][0] == pytest.approx(when, abs=1e-10)
    after = -housner(b, h) * rate
    # a thousandth of a second later: the new edge turns on under gravity
    gained = G * radius * math.sin(lean) / (4 / 3 * radius**2) * 1e-3
    assert float(ds.angular_velocity[-1, 0, 1]) == pytest.approx(after + gained, abs=1e-3 * rate)
    assert float(ds.energy_lost) == pytest.approx(
        0.5 * 4 / 3 * radius**2 * rate**2 * (1 - housner(b, h) ** 2), rel=1e-9
    )


def test_an_impact_elsewhere_reverses_sliding_in_steps_of_given_length() -> None:
    """A table slides on its front feet when its back feet strike, and then slides back: friction opposes the new
    direction. With a tolerance the same runs succeed; 3 of 24 ended as `friction_energy_gain` in steps of 1 ms."""
    settings = {"integrator": {"method": "rk4", "step": 1e-3, "end_time": 0.3}, "output": {"every": 0.05}}
    found = lienumba.run(SCENARIOS / "table.toml", overrides=settings, runs=[1, 9, 19])
    assert found.status.values.tolist() == [0, 0, 0]
    settings["integrator"] = {"method": "dop853", "tolerance": 1e-10, "end_time": 0.3}
    exact = lienumba.run(SCENARIOS / "table.toml", overrides=settings, runs=[1, 9, 19])
    np.testing.assert_allclose(found.energy_lost, exact.energy_lost, rtol=1e-4)
