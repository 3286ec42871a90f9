"""What time, turns and tables have to do with laws of the user's own."""

from typing import Any

import numpy as np
import pytest

from tests.laws.rigs import FUNCTIONS, close, exact, missed, order, own, pair, pendulum, run

MOTION = ("position", "rotation", "velocity", "angular_velocity", "energy", "work", "energy_residual")


@pytest.mark.parametrize("level", ["position", "velocity"])
def test_a_joint_that_time_moves_is_a_driver(level):
    """Of a position or of a speed; what it takes is accounted for as work."""
    number = {"position": {"value": "0.2*sin(3*t)"}, "velocity": {"rate": "0.6*cos(3*t)"}}[level]
    function = {"position": "moved", "velocity": "sped"}[level]
    data = pair()
    rail = data["model"]["joints"][1]
    del rail["speed"]
    rail |= {"points": [[1, 1, 0], [0, 0, 0]], "axes": [[1, 0, 0], [1, 0, 0]]}
    del rail["at"], rail["axis"]
    extra = {"name": "own", "type": "python", "function": f"{FUNCTIONS}:{function}", "bodies": ["block"],
             "level": level, "parameters": {"size": 0.2}}  # fmt: skip
    a = run(data | {"model": data["model"] | {"drivers": [{"name": "own", "joint": "rail", **number}]}})
    b = run(data | {"model": data["model"] | {"joints": [*data["model"]["joints"], extra]}})
    close(b, a, *MOTION, atol=1e-10)
    assert np.abs(a.work).max() > 0.01
    push = b.joint_force[0, :, 3]
    np.testing.assert_allclose(push[:, 0], a.driver_effort[0, :, 0], rtol=0, atol=1e-9)


def test_a_sampled_law_counts_turns():
    """The angle that it reads goes on beyond half a turn."""
    law = own("coil", joints=["hinge"], parameters={"stiffness": 2}, every=0.05)
    y = np.array([0.5, 25.0])
    for k in range(20):
        torque = -2.0 * y[0]
        y = exact(lambda t, y, u=torque: u, (k + 1) / 20, y, k / 20)
    errors = [missed(run(pendulum(law, rate=25.0, step=h)), y) for h in (0.005, 0.0025)]
    assert errors[1] < 1e-4, errors
    assert order(errors) > 3.6, errors
    assert abs(y[0]) > 2 * np.pi


def test_tables_that_differ_from_run_to_run_disturb_no_sample():
    """Every run lands on times of its own; the samples come at the same ones."""
    table = {"times": [0, 0.1, 0.4, 9], "values": [3.0, -6.0, 1.5, 0.0], "interpolation": "hold"}
    push = {"name": "push", "type": "actuator", "joint": "hinge", "value": "push(speed*t)"}
    laws = [
        own("held_pid", joints=["hinge"], parameters={"kp": 30, "kd": 2, "target": 1.0, "ki": 5}, every=0.037,
            states={"integral": 0.1}),
        own("counter", "asked", joints=["hinge"], states={"count": 0, "last": -1}, every=0.037),
    ]  # fmt: skip

    def data(speed: float, **sections: Any) -> dict[str, Any]:
        return pendulum(*laws, push, end=0.5, parameters={"speed": speed}, tables={"push": table}, **sections)

    vary = {"parameters.speed": {"distribution": "uniform", "low": 0.5, "high": 3}}
    ds = run(data(1.0, sweep={"runs": 9, "seed": 2, "vary": vary}))
    np.testing.assert_array_equal(ds["asked.count"][:, -1], np.full(9, 1 + 13))
    np.testing.assert_allclose(ds["asked.last"][:, -1], 13 * 0.037, rtol=1e-15)
    for n in range(9):
        alone = run(data(float(ds["parameters.speed"][n])))
        for name in ("position", "own.integral", "work"):
            np.testing.assert_array_equal(alone[name][0], ds[name][n], err_msg=name)
