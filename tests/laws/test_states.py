"""Laws with states of their own: filters, motors, integrals. They move with the bodies, at the order of the method."""

from typing import Any

import numpy as np
import pytest

from tests.facade import METHODS
from tests.laws.rigs import angle, exact, order, own, pendulum, rate, run

STEPS = (0.02, 0.01, 0.005)
GAINS = {"kp": 30, "kd": 2, "target": 1.0}
PD = own("pd", joints=["hinge"], parameters=GAINS)
PID = own("pid", joints=["hinge"], parameters=GAINS | {"ki": 25}, states={"integral": 0.1})
MOTOR = own("motor", joints=["hinge"], parameters={"volts": 9, "lag": 0.15}, states={"torque": -0.4})
LOW_PASS = own("low_pass", joints=["hinge"], parameters={"lag": 0.1, "gain": 12}, states=dict.fromkeys("abcd", 0.2))


def low_pass(t: float, z: Any, x: float) -> list[float]:
    return [(a - b) / 0.1 for a, b in zip((x, *z[:3]), z, strict=True)]


# the law, the torque that it is, the rates of its states
KNOWN = {
    "pd": (PD, lambda t, y: 30 * (1 - y[0]) - 2 * y[1], lambda t, y: []),
    "pid": (PID, lambda t, y: 30 * (1 - y[0]) - 2 * y[1] + 25 * y[2], lambda t, y: [1 - y[0]]),
    "motor": (MOTOR, lambda t, y: y[2], lambda t, y: [(9 * np.sin(3 * t) - 0.2 * y[1] - y[2]) / 0.15]),
    "low_pass": (LOW_PASS, lambda t, y: -12 * y[5], lambda t, y: low_pass(t, y[2:], y[0])),
}


def seen(dataset: Any, force: dict[str, Any]) -> np.ndarray:
    """Angle, rate and states of the pendulum at the end."""
    states = [float(dataset[f"{force['name']}.{name}"][0, -1]) for name in force.get("states", {})]
    return np.array([angle(dataset)[0, -1], rate(dataset)[0, -1], *states])


@pytest.mark.parametrize("projection", [("none", "none"), ("local", "mass")], ids="+".join)
@pytest.mark.parametrize("name", KNOWN)
def test_it_moves_as_scipy_has_it(name, projection):
    force, torque, more = KNOWN[name]
    truth = exact(torque, 1.0, (0.5, 1.0, *force.get("states", {}).values()), more=more)
    keys = {"projection": dict(zip(("position", "velocity"), projection, strict=True))}
    errors = [np.abs(seen(run(pendulum(force, step=h, **keys)), force) - truth).max() for h in STEPS]
    np.testing.assert_allclose(order(errors), 4, atol=0.2, err_msg=str(errors))
    assert errors[-1] < 1e-5


@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_its_order(method):
    _, torque, more = KNOWN["pid"]
    truth = exact(torque, 1.0, (0.5, 1.0, 0.1), more=more)
    given = {"order": 4} if METHODS[method].series else {}
    expected = given.get("order", METHODS[method].order)
    fine = {1: 1e-3, 2: 4e-3, 8: 0.1, 9: 0.25}.get(expected, 1e-2)
    errors = []
    for h in (fine, fine / 2):
        data = pendulum(PID)
        data["integrator"] = {"method": method, "step": h, "end_time": 1.0, **given}
        errors.append(np.abs(seen(run(data), PID) - truth).max())
    np.testing.assert_allclose(order(errors), expected, atol=0.2 if expected < 5 else 0.4, err_msg=str(errors))


# ---------------------------------------------------------------- many
def many() -> list[dict[str, Any]]:
    """Three laws with one, six and four states, eleven together."""
    six = own("two_filters", "second", joints=["hinge"], parameters={"gain": 4, "lag": 0.2},
              states={f"s{i}": 0.1 * i for i in range(6)})  # fmt: skip
    return [PID | {"name": "first"}, six, LOW_PASS | {"name": "third"}]


def test_more_states_than_an_element_holds():
    """Nine numbers travel together; eleven of three laws are all where they belong."""

    def six(z: Any, x: float) -> list[float]:
        return [(x - z[0]) / 0.2, *((z[i] - z[i + 1]) / 0.2 for i in range(5))]

    def torque(t, y):
        return 30 * (1 - y[0]) - 2 * y[1] + 25 * y[2] - 4 * (y[5] + y[8]) - 12 * y[12]

    def more(t, y):
        return [1 - y[0], *six(y[3:9], y[0]), *low_pass(t, y[9:], y[0])]

    forces = many()
    start = [x for force in forces for x in force["states"].values()]
    truth = exact(torque, 1.0, (0.5, 1.0, *start), more=more)
    errors = []
    for h in (0.005, 0.0025, 0.00125):
        ds = run(pendulum(*forces, step=h))
        names = [f"{force['name']}.{state}" for force in forces for state in force["states"]]
        found = [angle(ds)[0, -1], rate(ds)[0, -1], *(float(ds[name][0, -1]) for name in names)]
        errors.append(np.abs(found - truth).max())
    np.testing.assert_allclose(order(errors), 4, atol=0.2, err_msg=str(errors))
    assert [float(ds[name][0, 0]) for name in names] == start


def test_they_are_stored_as_variables():
    ds = run(pendulum(*many(), output={"every": 0.1}))
    assert ds["first.integral"].dims == ("run", "time")
    assert ds["first.integral"].shape == (1, 11)
    assert {"second.s0", "second.s5", "third.a", "third.d"} <= set(ds.data_vars)
    some = run(pendulum(*many(), output={"every": 0.1, "variables": ["position", "third"]}))
    assert {name for name in some.data_vars if "." in name} == {"third.a", "third.b", "third.c", "third.d"}
    np.testing.assert_array_equal(some["third.d"], ds["third.d"])
    none = run(pendulum(*many(), output={"every": 0.1, "variables": ["position"]}))
    assert not [name for name in none.data_vars if "." in name]
    np.testing.assert_array_equal(none.position, ds.position)


def test_their_start_can_be_swept():
    vary = {"forces.own.states.integral": {"distribution": "uniform", "low": -2, "high": 2}}
    ds = run(pendulum(PID, sweep={"runs": 4, "seed": 1, "vary": vary}))
    _, torque, more = KNOWN["pid"]
    starts = ds["forces.own.states.integral"].values
    np.testing.assert_array_equal(ds["own.integral"].values[:, 0], starts)
    assert len(set(starts)) == 4
    for n, start in enumerate(starts):
        q, dq, z = exact(torque, 1.0, (0.5, 1.0, start), more=more)
        found = (angle(ds)[n, -1], rate(ds)[n, -1], float(ds["own.integral"][n, -1]))
        np.testing.assert_allclose(found, (q, dq, z), rtol=0, atol=1e-5)


def test_their_start_can_be_a_formula_of_parameters():
    data = pendulum(PID | {"states": {"integral": "wind/4"}}, parameters={"wind": 0.4}, end=0.2)
    np.testing.assert_array_equal(run(data).position, run(pendulum(PID, end=0.2)).position)


def test_a_law_without_feedback_integrates():
    """What a filter of nothing but itself does is known in closed form, and leaves the motion as it is."""
    force = own("decay", joints=["hinge"], parameters={"lag": 0.3}, states={"x": 2.0})
    ds, free = run(pendulum(force)), run(pendulum())
    assert float(ds["own.x"][0, -1]) == pytest.approx(2 * np.exp(-1 / 0.3), abs=1e-7)
    np.testing.assert_allclose(ds.position, free.position, rtol=0, atol=1e-14)
