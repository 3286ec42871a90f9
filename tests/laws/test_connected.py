"""Laws that read each other's states, know their interval, and switch at times."""

import numpy as np
import pytest

from tests.laws.rigs import exact, missed, order, own, pendulum, run
from tests.laws.test_sampled import restarted

CONTROLLER = own("commands", "controller", joints=["hinge"], parameters={"kp": 20, "target": 0.8})
CONTROLLER |= {"states": {"command": 0.3}}
MOTOR = own("follows", "motor", joints=["hinge"], parameters={"tau": 0.1}, states={"torque": 0})
BRAKE = {"name": "brake", "type": "actuator", "joint": "hinge", "value": "-0.1*motor.torque"}
FELT = {"name": "felt", "type": "expression", "value": "0.9*motor.torque", "units": "N m"}
STEPS = (0.01, 0.005, 0.0025)


def test_a_motor_follows_a_sampled_controller():
    """Against SciPy with a state more, restarted at each sample; the states are read by law and formula."""
    errors, every = [], 0.0371
    y = np.array([0.5, 1.0, 0.0])
    for k in range(int(1.0 / every) + 1):
        u, until = 20 * (0.8 - y[0]), min((k + 1) * every, 1.0)
        y = exact(lambda t, y: 0.9 * y[2], until, y, k * every, lambda t, y, u=u: [(u - y[2]) / 0.1])
    for h in STEPS:
        ds = run(pendulum({**CONTROLLER, "every": every}, MOTOR, BRAKE, step=h, quantities=[FELT]))
        errors.append(missed(ds, y[:2]))
        assert float(ds["felt"][0, -1]) == pytest.approx(0.9 * float(ds["motor.torque"][0, -1]), abs=1e-14)
        assert float(ds["motor.torque"][0, -1]) == pytest.approx(y[2], abs=30 * h**4 / 1e-3)
    assert order(errors) == pytest.approx(4, abs=0.2), errors


@pytest.mark.parametrize(
    "value", ["where(t < 0.3172, 3, -1)", "where(t < late, 3, -1)", "where(2*late - t > late, 3, -1)"]
)
def test_a_switch_at_a_time_keeps_the_order(value):
    """Written into a formula, with or without parameters; the steps do not meet it."""
    y, _ = restarted((lambda t, y, z: (3.0 if t == 0.0 else -1.0, []), 0.3172, []))
    push = {"name": "push", "type": "actuator", "joint": "hinge", "value": value}
    parameters = {"late": 0.3172} if "late" in value else {}
    errors = [missed(run(pendulum(push, step=h, parameters=parameters)), y) for h in STEPS]
    assert order(errors) == pytest.approx(4, abs=0.2), errors


def test_a_switch_that_differs_from_run_to_run():
    """Each run lands on its own."""
    push = {"name": "push", "type": "actuator", "joint": "hinge", "value": "where(t < late, 3, -1)"}
    sweep = {"runs": 9, "seed": 3, "vary": {"parameters.late": {"distribution": "uniform", "low": 0.1, "high": 0.9}}}
    ds = run(pendulum(push, step=2.5e-3, parameters={"late": 0.5}, sweep=sweep))
    for i, late in enumerate(ds["parameters.late"].values):
        y = exact(lambda t, y: 3.0, late, np.array([0.5, 1.0]), 0.0)
        y = exact(lambda t, y: -1.0, 1.0, y, late)
        assert missed(ds.isel(run=[i]), y) < 2e-9


def test_a_sampled_law_knows_its_interval():
    """By its name."""
    given = own("adds_up", joints=["hinge"], states={"elapsed": 0}, every=0.0625)
    ds = run(pendulum(given, step=0.01))
    assert float(ds["own.elapsed"][0, -1]) == 17 * 0.0625
