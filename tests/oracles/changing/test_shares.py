"""A box that slides and spins on its four lower corners: they share its weight as corners of equal small compliance
would, linearly in their places, whatever friction tilts. Against SciPy in three coordinates."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

SCENARIOS = Path(__file__).parents[3] / "scenarios"
G, HALF, HEIGHT, MU, END = 9.81, 0.1, 0.1, 0.3, 0.4
CORNERS = np.array([(x, y) for x in (-HALF, HALF) for y in (-HALF, HALF)])
J = 2 / 3 * HALF**2
START = [0.0, 0.0, 0.0, 1.5, 0.0, 6.0]


def sliding(t: float, y: Any) -> Any:
    """The rates of x, y, the angle, and theirs, for a mass of 1 kg."""
    turn = np.array([[np.cos(y[2]), -np.sin(y[2])], [np.sin(y[2]), np.cos(y[2])]])
    arms = CORNERS @ turn.T
    speeds = y[3:5] + y[5] * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
    along = -MU * speeds / np.linalg.norm(speeds, axis=1)[:, None]
    shape = np.column_stack([np.ones(4), arms])  # forces are this times three numbers
    balance = np.array([np.ones(4), arms[:, 0] + HEIGHT * along[:, 0], arms[:, 1] + HEIGHT * along[:, 1]])
    pressed = shape @ np.linalg.solve(balance @ shape, [G, 0, 0])
    force = pressed[:, None] * along
    torque = arms[:, 0] @ force[:, 1] - arms[:, 1] @ force[:, 0]
    return [*y[3:], *force.sum(axis=0), torque / J]


def test_corners_that_slide_share_the_weight() -> None:
    contacts = parts.feet("box", [[*p, -HEIGHT] for p in CORNERS], "c", friction=MU)
    body = parts.resting("box", 1, J, [0, 0, HEIGHT], velocity=[START[3], 0, 0], angular_velocity=[0, 0, START[5]])
    data = scenarios.scenario("A box", {"gravity": [0, 0, -G], "bodies": [body], "contacts": contacts}, END)
    ds = lienumba.run(data).isel(run=0, body=0)
    found = solve_ivp(sliding, (0, END), START, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert int(ds.status) == 0
    last = ds.isel(time=-1)
    np.testing.assert_allclose(last.position, [found[0], found[1], HEIGHT], rtol=0, atol=1e-10)
    np.testing.assert_allclose(last.velocity, [found[3], found[4], 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(last.angular_velocity, [0, 0, found[5]], rtol=0, atol=1e-8)
    turned = np.arctan2(float(last.rotation[1, 0]), float(last.rotation[0, 0]))
    assert abs(turned - found[2]) < 1e-9
    assert abs(ds.energy_residual).max() < 1e-9


def test_what_slides_is_noticed_to_turn_before_friction_changes_its_sign() -> None:
    """On a table that tilts between two feet friction turned round would turn the sliding back: no step would end
    behind a right angle, and steps would creep along it."""
    legs = [(x, y, -0.64) for x in (0.52, -0.68) for y in (0.3, -0.4)]
    contacts = parts.feet("table", legs, "c", friction=0.5, restitution=0.3, rest_speed=0.05)
    tilt = {"axis": [0.6, 0.8, 0], "angle": 0.017708425042926194}
    body = parts.body("table", 24, [2.6, 3.9, 5.3, 0.1, 0.1, -0.4], rotation=tilt, position=[0.08, 0.05, 0.76])
    model = {"gravity": [0, 0, -G], "bodies": [body], "contacts": contacts}
    data = scenarios.scenario("A table", model, 0.3, 1e-9)
    ds = lienumba.run(data).isel(run=0)
    assert int(ds.status) == 0
    assert int(ds.steps) < 1000


def test_feet_that_stop_beside_others_that_slide_stick() -> None:
    """Of the tables of the gallery those that crept: a foot slid on at 1e-10 m/s, 17,000 to 570,000 steps long."""
    ds = lienumba.run(SCENARIOS / "table.toml", runs=[6, 16, 23])
    assert (ds.status == 0).all()
    assert (ds.steps < 5000).all()
    assert abs(ds.energy_residual).max() < 1e-6
    still = abs(ds.velocity.isel(time=-1)).max("axis")
    assert (still < 2e-9).all()
