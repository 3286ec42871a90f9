"""A box on its four lower corners, on an incline: it stays, slides, or tips over its lower edge; and it lands flat. The
corners share what holds them in no unique way, and the motion is that of closed forms all the same."""

import math
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

G, HALF, HEIGHT, END = 9.81, 0.2, 0.5, 0.2  # the middle is at HEIGHT above the corners
SLOPE, STEEP = 0.3, 0.45  # rad: tan = 0.31, and 0.48, more than HALF / HEIGHT = 0.4
CORNERS = [[x, y, -HEIGHT] for x in (-HALF, HALF) for y in (-HALF, HALF)]
STAYS, SLIDES, TIPS, LANDS = range(4)


@pytest.fixture(scope="module")
def dataset() -> Any:
    J = (HALF**2 + HEIGHT**2) / 3
    corners = parts.feet("box", CORNERS, "c", rest_speed=0.01, friction=1.0)
    body = parts.resting("box", 1, J, [0, 0, HEIGHT])
    slopes, friction = [SLOPE, SLOPE, STEEP, 0.0], [0.35, 0.25, 2.0, 0.5]
    columns = {
        "gravity[0]": [G * math.sin(a) for a in slopes],
        "gravity[2]": [-G * math.cos(a) for a in slopes],
        "bodies.box.position[2]": [HEIGHT, HEIGHT, HEIGHT, HEIGHT + 0.05],
    } | {f"contacts.c{n}.friction": friction for n in range(4)}
    data = scenarios.scenario("A box", {"gravity": [0, 0, -G], "bodies": [body], "contacts": corners}, END)
    return lienumba.run(data | {"sweep": scenarios.table(columns)}).isel(body=0)


def test_runs_to_the_end_with_all_energy_accounted_for(dataset: Any) -> None:
    assert np.all(dataset.status == 0)
    assert abs(dataset.energy_residual).max() < 1e-11


def test_a_box_on_a_slope_stays(dataset: Any) -> None:
    last = dataset.isel(run=STAYS, time=-1)
    np.testing.assert_allclose(last.position, [0, 0, HEIGHT], rtol=0, atol=1e-13)
    np.testing.assert_allclose(last.velocity, 0.0, rtol=0, atol=1e-13)


def test_a_box_on_less_friction_slides(dataset: Any) -> None:
    last, a = dataset.isel(run=SLIDES, time=-1), G * (math.sin(SLOPE) - 0.25 * math.cos(SLOPE))
    np.testing.assert_allclose(last.position, [0.5 * a * END**2, 0, HEIGHT], rtol=0, atol=1e-11)
    np.testing.assert_allclose(last.angular_velocity, 0.0, rtol=0, atol=1e-11)


def test_a_box_on_a_steeper_slope_tips_over_its_lower_edge(dataset: Any) -> None:
    """Energy about the edge says how fast it turns where it is."""
    last = dataset.isel(run=TIPS, time=-1)
    radius, lean = math.hypot(HALF, HEIGHT), math.atan2(HALF, HEIGHT)
    turned = math.atan2(float(last.rotation[0, 2]), float(last.rotation[2, 2]))
    assert turned > 0.01
    fallen = radius * (math.cos(lean - STEEP) - math.cos(turned + STEEP - lean))
    rate = math.sqrt(2 * G * fallen / (4 / 3 * radius**2))
    assert float(last.angular_velocity[1]) == pytest.approx(rate, rel=1e-9)


def test_a_box_lands_flat_on_four_corners_at_once(dataset: Any) -> None:
    run = dataset.isel(run=LANDS)
    when = math.sqrt(2 * 0.05 / G)
    assert run.change_time.values[0] == pytest.approx(when, abs=1e-11)
    assert float(run.energy_lost) == pytest.approx(G * 0.05, abs=1e-11)
    np.testing.assert_allclose(run.position.values[-1], [0, 0, HEIGHT], rtol=0, atol=1e-11)
    np.testing.assert_allclose(run.velocity.values[-1], 0.0, rtol=0, atol=1e-12)


def test_modes_at_the_end_are_the_last_that_are_stored(dataset: Any) -> None:
    last = dataset.last_mode.transpose("run", "switch").values
    assert last.tolist() == [[1] * 4, [2] * 4, [0, 0, 1, 1], [1] * 4]
    np.testing.assert_array_equal(dataset["mode"].isel(time=-1).transpose("run", "switch").values, last)


def test_friction_at_two_of_four_corners_takes_what_presses_there() -> None:
    """Down is along x: the upper corners have friction, the lower ones none; moments share the weight."""
    J, mu = (HALF**2 + HEIGHT**2) / 3, 0.25
    corners = parts.feet("box", CORNERS, "c", rest_speed=0.01)
    for corner in corners[:2]:
        corner["friction"] = mu
    body = parts.resting("box", 1, J, [0, 0, HEIGHT])
    down = [G * math.sin(SLOPE), 0, -G * math.cos(SLOPE)]
    data = scenarios.scenario("A box", {"gravity": down, "bodies": [body], "contacts": corners}, END)
    run = lienumba.run(data).isel(run=0, body=0)
    pressed = G * math.cos(SLOPE) / (2 + mu * HEIGHT / HALF)
    a = G * math.sin(SLOPE) - mu * pressed
    np.testing.assert_allclose(run.position[-1], [0.5 * a * END**2, 0, HEIGHT], rtol=0, atol=1e-11)
    np.testing.assert_allclose(run.angular_velocity[-1], 0.0, rtol=0, atol=1e-11)
    assert run.last_mode.values.tolist() == [2] * 4
    assert float(abs(run.energy_residual).max()) < 1e-11
