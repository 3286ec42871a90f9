"""Laws that are sampled: what they do is held in between, and steps land on the samples, so the order stays."""

from itertools import pairwise
from math import floor
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lienumba.engine.runner import operation_counts
from lienumba.integrators.tracing import step_kernels
from tests.facade import resolve
from tests.laws.rigs import close, exact, missed, order, own, pair, pendulum, run
from tests.rigs.scenarios import chain
from tests.rigs.sweeps import assert_same

STEPS = (0.01, 0.005, 0.0025)
GAINS = {"kp": 30, "kd": 2, "target": 1.0}
PD = own("pd", joints=["hinge"], parameters=GAINS)
PID = own("held_pid", joints=["hinge"], parameters=GAINS | {"ki": 5}, states={"integral": 0.1})


def pd(t: float, y: Any, z: list[float]) -> tuple[float, list[float]]:
    return 30 * (1 - y[0]) - 2 * y[1], []


def pid(t: float, y: Any, z: list[float]) -> tuple[float, list[float]]:
    return 30 * (1 - y[0]) - 2 * y[1] + 5 * z[0], [z[0] + 1 - y[0]]


def restarted(
    *laws: tuple[Any, float, list[float]], end: float = 1.0, jumps: Any = None
) -> tuple[Any, list[list[float]]]:
    """The pendulum, integrated anew from every sample: law(t, y, states) -> torque, new states; its interval, its
    first states. jumps: times and values of one more torque that is held."""
    y, states = np.array([0.5, 1.0]), [list(law[2]) for law in laws]
    torques = [0.0] * len(laws)
    samples = [{k * every for k in range(floor(end / every + 1e-9) + 1)} for _, every, _ in laws]
    times, values = jumps or ((), ())
    marks = sorted({0.0, end}.union(*samples, [t for t in times if t < end]))
    for begin, until in zip(marks, [*marks[1:], end], strict=True):
        for n, (law, _, _) in enumerate(laws):
            if begin in samples[n]:
                torques[n], states[n] = law(begin, y, states[n])
        more = values[np.searchsorted(times, begin, "right") - 1] if jumps else 0.0
        total = sum(torques) + more
        y = exact(lambda t, y, total=total: total, until, y, begin) if until > begin else y
    return y, states


@pytest.mark.parametrize("every", [0.1, 0.25, 0.037, 1 / 3])
@pytest.mark.parametrize("name", ["pd", "pid"])
def test_a_sampled_controller_keeps_the_order(name, every):
    """Whether its interval is a multiple of the step or not."""
    force, law, start = {"pd": (PD, pd, []), "pid": (PID, pid, [0.1])}[name]
    y, states = restarted((law, every, start))
    errors = []
    for h in STEPS:
        ds = run(pendulum(force | {"every": every}, step=h))
        errors.append(missed(ds, y))
        if states[0]:
            assert float(ds["own.integral"][0, -1]) == pytest.approx(states[0][0], abs=1e-4)
    assert errors[-1] < 1e-6, errors
    np.testing.assert_allclose(order(errors), 4, atol=0.35, err_msg=str(errors))


@pytest.mark.parametrize("every", [0.0123, 0.004, 0.003])
def test_an_interval_shorter_than_the_step(every):
    """Several samples in a step: it is the interval that decides how long the parts are."""
    y, _ = restarted((pd, every, []))
    coarse, fine = (run(pendulum(PD | {"every": every}, step=h)) for h in (0.05, 0.02))
    assert missed(coarse, y) < 1e-7
    assert missed(fine, y) < 1e-7
    _, states = restarted((pid, every, [0.1]), end=0.2)
    ds = run(pendulum(PID | {"every": every}, step=0.02, end=0.2))
    assert float(ds["own.integral"][0, -1]) == pytest.approx(states[0][0], abs=1e-6)


def test_an_interval_longer_than_the_run_holds_the_first_sample():
    """t = 0 is the first sample; what it gave is held."""
    ds = run(pendulum(PD | {"every": 5.0}))
    torque = 30 * (1 - 0.5) - 2 * 1.0
    same = run(pendulum({"name": "own", "type": "actuator", "joint": "hinge", "value": torque}))
    close(ds, same, "position", "angular_velocity", "work", "joint_force", atol=1e-12)


@pytest.mark.parametrize(
    ("every", "end"), [(0.1, 1.0), (0.1, 0.95), (0.07, 0.7), (0.037, 1.0), (1 / 3, 1.0), (0.004, 0.5)]
)
def test_it_is_asked_at_every_sample_and_at_no_other_time(every, end):
    law = own("counter", joints=["hinge"], states={"count": 0, "last": -1}, every=every)
    ds = run(pendulum(law, end=end, output={"every": 0.05}))
    times = ds.time.values
    samples = np.floor(times / every * (1 + 1e-9))
    np.testing.assert_array_equal(ds["own.count"][0], samples + 1)
    np.testing.assert_allclose(ds["own.last"][0], samples * every, rtol=1e-15, atol=0)
    np.testing.assert_allclose(ds.position, run(pendulum(end=end, output={"every": 0.05})).position, rtol=0, atol=1e-7)


def test_two_controllers_at_their_own_intervals_and_a_table_that_jumps():
    laws = [PD | {"name": "slow", "every": 0.1}, PID | {"name": "fast", "every": 0.037}]
    table = {"times": [0, 0.123, 0.55, 2], "values": [3.0, -6.0, 1.5, 0.0], "interpolation": "hold"}
    push = {"name": "push", "type": "actuator", "joint": "hinge", "value": "push(t)"}
    y, states = restarted((pd, 0.1, []), (pid, 0.037, [0.1]), jumps=(table["times"], table["values"]))
    errors = []
    for h in STEPS:
        ds = run(pendulum(*laws, push, step=h, tables={"push": table}))
        errors.append(missed(ds, y))
    np.testing.assert_allclose(order(errors), 4, atol=0.35, err_msg=str(errors))
    assert float(ds["fast.integral"][0, -1]) == pytest.approx(states[1][0], abs=1e-7)


def test_one_that_flows_beside_one_that_is_sampled():
    """The integral of the one goes on while the torque of the other is held."""
    flowing = own("pid", "flow", joints=["hinge"], parameters=GAINS | {"ki": 25, "kd": 1}, states={"integral": 0.2})
    y, z, held = np.array([0.5, 1.0]), 0.2, 0.0
    for k in range(10):
        held = pd(0, y, [])[0]
        *y, z = exact(lambda t, y, u=held: u + 30 * (1 - y[0]) - y[1] + 25 * y[2], (k + 1) / 10, (*y, z), k / 10,
                      more=lambda t, y: [1 - y[0]])  # fmt: skip
    errors = []
    for h in STEPS:
        ds = run(pendulum(flowing, PD | {"every": 0.1}, step=h))
        errors.append(max(missed(ds, y), abs(float(ds["flow.integral"][0, -1]) - z)))
    np.testing.assert_allclose(order(errors), 4, atol=0.35, err_msg=str(errors))


# ---------------------------------------------------------------- what is held
def spinning(step: float, every: float | None, end: float = 0.6) -> dict[str, Any]:
    law = own("puff", bodies=["ball"], parameters={"thrust": 0.7}) | ({"every": every} if every else {})
    data = pair(law, step=step, end=end)
    model = data["model"]
    model["joints"], model["bodies"] = [], [body for body in model["bodies"] if body["name"] == "ball"]
    return data


def free_flight(every: float, end: float) -> np.ndarray:
    """r, R, v, w at the end, with loads held along the body's or the global axes as they were returned."""
    inertia = np.array([[0.02, 0.001, 0], [0.001, 0.03, 0.002], [0, 0.002, 0.025]])
    body = run(spinning(0.01, every, end)).isel(run=0, time=0)
    parts = (body.position, body.rotation, body.velocity, body.angular_velocity)
    y = np.concatenate([np.ravel(x) for x in parts])
    marks = [*np.arange(0.0, end - 1e-9, every), end]
    for begin, until in pairwise(marks):
        w = y[15:].copy()
        along, at, torque = np.array([0, 0.7 * w[0], 1]), np.array([0.2, 0.1 * w[1], 0]), [0.3, -0.2 * w[2], 0.1]
        globally = np.array([0.1, 0.2, 0.7 * w[1]])

        def slope(t, y, along=along, at=at, torque=torque, globally=globally):
            R, w = y[3:12].reshape(3, 3), y[15:]
            hat = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
            a = np.array([0.5, -0.3, -9.81]) + (R @ along + globally) / 0.7
            moment = np.cross(at, along) + torque - np.cross(w, inertia @ w)
            return [*y[12:15], *(R @ hat).ravel(), *a, *np.linalg.solve(inertia, moment)]

        y = solve_ivp(slope, (begin, until), y, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return y


@pytest.mark.parametrize("every", [0.15, 0.11])
def test_a_load_along_a_spinning_body_turns_with_it(every):
    truth = free_flight(every, 0.6)
    errors = []
    for h in (0.01, 0.005):
        last = run(spinning(h, every)).isel(run=0, time=-1)
        found = np.concatenate([np.ravel(last[n]) for n in ("position", "rotation", "velocity", "angular_velocity")])
        errors.append(np.abs(found - truth).max())
    assert order(errors) > 3.7, errors
    assert errors[-1] < 1e-5
    assert np.abs(run(spinning(0.005, None)).angular_velocity[0, -1, 0] - truth[15:]).max() > 0.01


def test_what_held_loads_work_is_accounted_for():
    residuals = [float(np.abs(run(spinning(h, 0.11)).energy_residual).max()) for h in (0.01, 0.005)]
    assert order(residuals) > 3.7, residuals


def test_a_decision_that_is_sampled_lasts():
    """A relay chatters when it is asked at every time, and not when it is sampled: the torque has one of two sizes."""
    ds = run(pendulum(own("bang", joints=["hinge"], parameters={"size": 2}, every=0.1), step=0.01))
    y = np.array([0.5, 1.0])
    for k in range(10):
        torque = -2.0 if y[0] > 0 else 2.0
        y = exact(lambda t, y, u=torque: u, (k + 1) / 10, y, k / 10)
    assert missed(ds, y) < 1e-6


# ---------------------------------------------------------------- large mechanisms, sweeps
def test_stage_by_stage_is_the_same(monkeypatch):
    data = pendulum(PID | {"every": 0.037}, PD | {"name": "slow", "every": 0.1}, output={"every": 0.1})
    whole = run(data)
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    assert "step" not in operation_counts(resolve(data))
    close(run(data), whole, "position", "angular_velocity", "work", "own.integral", atol=1e-12)


def test_a_chain_of_six_links():
    def links(step: float, every: float | None) -> Any:
        law = own("puff", bodies=["link5"], parameters={"thrust": 0.3}) | ({"every": every} if every else {})
        return run({
            "model": chain(6)["model"] | {"forces": [law]},
            "integrator": {"step": step, "end_time": 0.032},
            "output": {"times": [0.0, 0.032]},
        })  # fmt: skip

    found = [links(h, 0.007) for h in (1e-3, 5e-4, 2.5e-4)]
    for name in ("angular_velocity", "work"):
        a, b, c = (ds[name].values[0, -1] for ds in found)
        assert order([np.abs(a - b).max(), np.abs(b - c).max()]) == pytest.approx([4], abs=0.35), name
    assert order([abs(float(ds.energy_residual[0, -1])) for ds in found[:2]]) > 3.5
    assert np.abs(links(1e-3, None).angular_velocity - found[0].angular_velocity).max() > 1e-4


def test_the_same_bits_alone_in_a_sweep_and_with_any_workers():
    vary = {
        "forces.own.parameters.kp": {"distribution": "uniform", "low": 10, "high": 50},
        "bodies.rod.mass": {"distribution": "normal", "std": 0.1},
    }
    data = pendulum(PID | {"every": 0.037}, end=0.3, sweep={"runs": 21, "seed": 4, "vary": vary})
    whole = run(data)
    assert_same(run(data, workers=3), whole)
    for name in ("position", "own.integral", "work"):
        np.testing.assert_array_equal(run(data, runs=[17])[name], whole[name].sel(run=[17]), err_msg=name)
    assert len(np.unique(whole["own.integral"][:, -1])) == 21
