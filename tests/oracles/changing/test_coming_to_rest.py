"""What slides in a plane and comes to rest, by steps of one length, beside which friction turns too fast for these."""

import functools
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts

G = 9.81
STEPS = [("rk4", 1e-2), ("rk4", 1e-3), ("dp54", 1e-2), ("dop853", 1e-2), ("heun", 1e-3)]


def ran(model: dict[str, Any], integrator: dict[str, Any], end: float) -> Any:
    found = lienumba.run({"model": model, "integrator": integrator | {"end_time": end}, "output": {"every": end}})
    assert found.status.item() == 0
    return found


@pytest.mark.parametrize(("method", "step"), STEPS)
@pytest.mark.parametrize("across", [0.03, -0.08])
def test_a_puck_across_a_slope_stops(method: str, step: float, across: float) -> None:
    """Friction of 0.45 on a slope of 0.4 rad, which it holds: against SciPy, within what a slip travels that is stopped
    in half a step."""
    slope, mu = 0.4, 0.45

    def moved(t: float, y: np.ndarray) -> list[float]:
        x, z = y[2:] / np.hypot(*y[2:])
        return [y[2], y[3], G * np.sin(slope) - mu * G * np.cos(slope) * x, -mu * G * np.cos(slope) * z]

    def stops(t: float, y: np.ndarray) -> float:
        return float(np.hypot(y[2], y[3])) - 1e-8

    stops.terminal = True  # type: ignore[attr-defined]
    exact = solve_ivp(moved, (0, 2), [0, 0, 0.1, across], events=stops, rtol=1e-11, atol=1e-13, method="DOP853")
    puck = parts.body("p", 2, position=[0, 0, 0], velocity=[0.1, across, 0])
    gravity = [G * np.sin(slope), 0, -G * np.cos(slope)]
    model = {"gravity": gravity, "bodies": [puck], "contacts": [parts.foot("c", "p", normal=[0, 0, 1], friction=mu)]}
    found = ran(model, {"method": method, "step": step}, 2.0)
    assert found["mode"].values[0, -1] == 1
    np.testing.assert_array_equal(found.last_velocity.values[0, 0], 0.0)
    np.testing.assert_allclose(found.last_position.values[0, 0, :2], exact.y[:2, -1], atol=20 * step**2 + 1e-6)


@pytest.mark.parametrize("slip", [(1e-3, 1e-4), (5e-3, -2e-2), (-5e-3, -2e-2)])
def test_a_ball_on_a_slope_rolls_when_it_has_slipped(slip: tuple[float, float]) -> None:
    """It starts with a little slip downhill and across, which friction takes."""
    normal, down = (np.array(x) / np.sqrt(3.25) for x in ([-1, 0, 1.5], [-1.5, 0, -1]))
    rolls = 0.5 * down + np.array([0, 0.1, 0])
    ball = parts.body(
        "b", 0.4, 0.0016, position=(0.1 * normal).tolist(), angular_velocity=(np.cross(normal, rolls) / 0.1).tolist(),
        velocity=(rolls + slip[0] * down + np.array([0, slip[1], 0])).tolist(),
    )  # fmt: skip
    contact = parts.sphere("c", "b", 0.1, normal=normal.tolist(), friction=0.3)
    model = {"gravity": [0, 0, -G], "bodies": [ball], "contacts": [contact]}
    exact, found = (ran(model, x, 0.4) for x in ({"tolerance": 1e-10}, {"method": "rk4", "step": 1e-3}))
    assert found["mode"].values[0, -1] == 1
    np.testing.assert_allclose(found.last_velocity.values, exact.last_velocity.values, atol=2e-6)


def test_what_slides_straight_on_stops_where_it_stops() -> None:
    """Nothing turns there, and no slip is taken for rest: to the order of the method."""
    block = parts.body("p", 2, position=[0, 0, 0], velocity=[0.7, 0, 0])
    floor = parts.foot("c", "p", normal=[0, 0, 1], friction=0.3)
    model = {"gravity": [0, 0, -G], "bodies": [block], "contacts": [floor]}
    found = ran(model, {"method": "rk4", "step": 1e-2}, 1.0)
    assert found.last_position.values[0, 0, 0] == pytest.approx(0.7**2 / (2 * 0.3 * G), abs=1e-10)


def feet(n: int, turn: Rotation, slope: float, friction: Any, spin: float) -> dict[str, Any]:
    """A puck on n feet, turned in space with all else, which slides across its plane."""
    places = [[0.2 * np.cos(a), 0.2 * np.sin(a), -0.1] for a in 2 * np.pi * (np.arange(n) + 0.3) / n]
    puck = parts.body("p", 2, [0.05, 0.05, 0.08], rotation=turn.as_matrix().tolist())
    puck |= {"position": turn.apply([0, 0, 0.1]).tolist(), "velocity": turn.apply([0.1, 0.05, 0]).tolist()}
    puck |= {"angular_velocity": turn.apply([0, 0, spin]).tolist()}
    normal, gravity = turn.apply([0, 0, 1]), turn.apply([G * np.sin(slope), 0, -G * np.cos(slope)])
    contacts = parts.feet("p", places, "c", normal=normal.tolist(), friction=friction)
    return {"gravity": gravity.tolist(), "bodies": [puck], "contacts": contacts}


@pytest.mark.parametrize(("method", "step"), [("rk4", 1e-3), ("heun", 1e-3), ("dop853", 2e-3)])
@pytest.mark.parametrize("n", [3, 4])
@pytest.mark.parametrize(("friction", "spin"), [(0.45, 0.0), ({"static": 0.6, "kinetic": 0.44}, -0.5)])
def test_feet_come_to_rest_together(n: int, friction: Any, spin: float, method: str, step: float) -> None:
    """On several feet it slid on for ever at some h times what friction brakes by, as a success."""
    model = feet(n, Rotation.random(random_state=n), 0.4, friction, spin)
    exact, found = (ran(model, x, 1.5) for x in ({"tolerance": 1e-10}, {"method": method, "step": step}))
    np.testing.assert_array_equal(exact["mode"].values[0, -1], 1)
    np.testing.assert_array_equal(found["mode"].values[0, -1], 1)
    assert abs(found.last_velocity.values).max() < 1e-12
    assert abs(found.last_angular_velocity.values).max() < 1e-12
    np.testing.assert_allclose(found.last_position.values, exact.last_position.values, rtol=0, atol=60 * step**2)


@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize(("method", "step"), [("rk4", 1e-3), ("heun", 1e-3), ("dop853", 1e-2)])
def test_feet_of_many_pucks_do_not_push(method: str, step: float) -> None:
    """One foot comes to rest before the others, and these turn back: of a hundred runs three to eleven pushed."""
    exact, found = many_pucks(tolerance=1e-10), many_pucks(method=method, step=step)
    np.testing.assert_array_equal(exact.status, 0)
    np.testing.assert_array_equal(found.status, 0)
    np.testing.assert_array_equal(found["mode"].values[:, -1], exact["mode"].values[:, -1])
    np.testing.assert_allclose(found.last_position.values, exact.last_position.values, rtol=0, atol=5 * step)


@functools.cache
def many_pucks(**integrator: Any) -> Any:
    """Pucks of random speeds and spins on three feet of random friction each, until they rest."""
    model = feet(3, Rotation.identity(), 0.06, 0.3, 0.0)
    vary = {f"bodies.p.velocity[{n}]": (-0.6, 0.6) for n in (0, 1)} | {"bodies.p.angular_velocity[2]": (-8.0, 8.0)}
    vary |= {f"contacts.c{n}.friction": (0.1, 0.5) for n in range(3)}
    scenario = {"model": model, "output": {"every": 2.0}, "sweep": parts.sweep(64, vary, seed=4)}
    return lienumba.run(scenario | {"integrator": integrator | {"end_time": 2.0}}, progress=False)


def test_a_body_at_rest_does_not_keep_another_sliding() -> None:
    """Two pucks, of which one stands on one foot, and one slides on over the other's plane."""
    one = feet(3, Rotation.identity(), 0.3, 0.5, 0.0)
    puck, foot = one["bodies"][0], one["contacts"][0]
    other = foot | {"bodies": ["q", "ground"], "name": "d", "points": [[0, 0, -0.1], [0, 0, 0]]}
    still = puck | {"name": "q", "velocity": [0, 0, 0]}
    model = one | {"bodies": [puck, still], "contacts": [*one["contacts"], other]}
    found = ran(model, {"method": "rk4", "step": 2e-3}, 1.0)
    np.testing.assert_array_equal(found["mode"].values[0, -1], 1)


@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("tolerance", [1e-9, 1e-11, 1e-13])
def test_series_that_begin_next_to_rest_have_steps_as_short(tolerance: float, coordinates: str) -> None:
    """Of w/|w| the coefficients of high orders have squares that no number holds, 1e-8 s before a point of one free
    body comes to rest on a plane of another: a third of 301 runs flew away, one of them as a success with 52 J."""
    series, steps = slid_on_a_table("taylor", tolerance, coordinates), slid_on_a_table("dop853", 1e-11, "lie")
    np.testing.assert_array_equal(series["status"], 0)
    np.testing.assert_allclose(series["position"], steps["position"], rtol=0, atol=max(20 * tolerance, 1e-9))
    assert abs(series["energy_residual"]).max() < 1e-7


@functools.cache
def slid_on_a_table(method: str, tolerance: float, coordinates: str) -> Any:
    """A free body that slides with one point on another one, from random velocities."""
    slider = parts.resting("a", 1.3, [0.02, 0.03, 0.045], [0, 0, 0.2])
    table = parts.resting("b", 4.0, [0.5, 0.6, 0.8])
    foot = parts.foot("c", "a", [0.05, 0.02, -0.2], to="b", friction=0.7, normal=[0, 0, 1])
    presses = [{"type": "force", "body": x, "value": [0, 0, f]} for x, f in (("a", -40), ("b", 40))]
    scenario = {
        "model": {"gravity": [0, 0, 0], "bodies": [slider, table], "contacts": [foot], "forces": presses},
        "integrator": {"end_time": 0.1, "method": method, "tolerance": tolerance, "coordinates": coordinates},
        "output": {"every": 0.005},
        "sweep": parts.sweep(16, {f"bodies.a.velocity[{n}]": (-0.5, 0.5) for n in (0, 1)}, seed=1),
    }  # fmt: skip
    return lienumba.run(scenario, progress=False)


@pytest.mark.parametrize("seed", [1, 2])
def test_balls_roll_by_steps_of_generalized_alpha(seed: int) -> None:
    """They slide in two directions until they roll: next to that stages have no solution that iterations find."""
    R = Rotation.random(random_state=seed)
    ball = parts.body(
        "b", 0.5, [0.002, 0.0022, 0.0025], position=R.apply([0, 0, 0.1]).tolist(), rotation=[1, 0, 0, 0],
        velocity=R.apply([1, 0.5, 0]).tolist(), angular_velocity=[3.0, -2, 1],
    )  # fmt: skip
    floor = parts.sphere("w", "b", 0.1, normal=R.apply([0, 0, 1]).tolist(), friction=0.2)
    spins = {f"bodies.b.angular_velocity[{i}]": (-10, 10) for i in range(3)}
    data = {
        "model": {"gravity": R.apply([1, 0, -9.81]).tolist(), "bodies": [ball], "contacts": [floor]},
        "output": {"every": 0.05},
        "sweep": parts.sweep(40, spins | {"contacts.w.friction": (0.05, 0.8)}, seed=seed),
    }
    exact = lienumba.run({**data, "integrator": {"method": "dop853", "tolerance": 1e-11, "end_time": 1.0}})
    errors = []
    for step in (5e-3, 2.5e-3, 1.25e-3):
        ds = lienumba.run({**data, "integrator": {"method": "generalized_alpha", "step": step, "end_time": 1.0}})
        assert (ds.status == 0).all()
        errors.append(float(abs(ds.position - exact.position).max(["time", "body", "axis"]).median()))
    assert errors[0] < 2e-4
    assert np.log2(errors[0] / errors[2]) / 2 > 1.7
