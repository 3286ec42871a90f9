"""One ball on one plane: bounces, slips and rolls, all in closed form. One program, and each a run."""

import math
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.closed_forms import bouncing, rolls_down, slides_then_rolls

G, RADIUS, J = 9.81, 0.1, 0.004  # a ball of 1 kg with 2/5 m r^2
END = 4.2
STEEP, FLAT = 0.5, 0.2  # rad, of inclines
HEIGHT, E, FRICTION = 1.0, 0.8, 0.1


@pytest.fixture(scope="module")
def dataset() -> Any:
    """Dropped; rolling down; slipping down; sent off sliding; dropped on its spin."""
    slopes = [0.0, FLAT, STEEP, 0.0, 0.0]
    columns = {
        "gravity[0]": [G * math.sin(a) for a in slopes],
        "gravity[2]": [-G * math.cos(a) for a in slopes],
        "bodies.ball.position[2]": [RADIUS + HEIGHT, RADIUS, RADIUS, RADIUS, RADIUS + 0.2],
        "bodies.ball.velocity[0]": [0, 0, 0, 2.0, 0],
        "bodies.ball.angular_velocity[1]": [0, 0, 0, 0, 10.0],
        "contacts.floor.restitution": [E, 0, 0, 0, 0],
        "contacts.floor.friction": [FRICTION] * 5,
    }
    data = scenarios.ball(RADIUS, J, END)
    data["output"] = {"times": [0, 0.25, END], "max_changes": 32}
    return lienumba.run(data | {"sweep": scenarios.table(columns)})


def test_a_dropped_ball_bounces_when_and_as_high_as_it_should(dataset: Any) -> None:
    run, known = dataset.isel(run=0), bouncing(HEIGHT, E, 0.05)
    n = min(len(known.times), 32)
    impacts = scenarios.kinds(run, "impact")
    assert n > 10
    np.testing.assert_allclose(run.change_time.values[impacts][:10], known.times[:10], rtol=0, atol=1e-11)
    np.testing.assert_allclose(run.change_energy.values[impacts][:10], known.losses[:10], rtol=0, atol=1e-11)
    assert float(run.energy_lost) == pytest.approx(G * HEIGHT, abs=1e-10)
    assert run.position.values[-1, 0, 2] == pytest.approx(RADIUS, abs=1e-12)


@pytest.mark.parametrize(("run", "angle"), [(1, FLAT), (2, STEEP)])
def test_a_ball_on_an_incline_rolls_or_slips(dataset: Any, run: int, angle: float) -> None:
    a, spin = rolls_down(angle, FRICTION, 0.4)
    assert (spin < 0.999 * a) == (run == 2)
    last = dataset.isel(run=run, time=-1, body=0)
    assert float(last.position[0]) == pytest.approx(0.5 * a * END**2, abs=1e-10)
    assert float(last.angular_velocity[1]) * RADIUS == pytest.approx(spin * END, abs=1e-10)


def test_a_ball_sent_off_without_spin_slides_and_then_rolls(dataset: Any) -> None:
    when, speed = slides_then_rolls(2.0, FRICTION, 0.4)
    run = dataset.isel(run=3, body=0)
    stuck = scenarios.kinds(run, "stuck")
    assert run.change_time.values[stuck][0] == pytest.approx(when, abs=1e-11)
    assert run.velocity.values[-1, 0] == pytest.approx(speed, abs=1e-11)
    assert run.angular_velocity.values[-1, 1] * RADIUS == pytest.approx(speed, abs=1e-11)


def test_an_impact_on_spin_pushes_the_ball_off_by_friction(dataset: Any) -> None:
    fall = math.sqrt(2 * G * 0.2)
    impulse = FRICTION * fall  # it slides all through the impact: w R = 1 m/s is more than friction can stop
    assert impulse * 3.5 < 10 * RADIUS
    run = dataset.isel(run=4, body=0, time=1)
    t = 0.25 - fall / G
    assert float(run.velocity[0]) == pytest.approx(impulse + FRICTION * G * t, abs=1e-10)


def test_the_energy_is_accounted_for(dataset: Any) -> None:
    assert abs(dataset.energy_residual).max() < 1e-11
