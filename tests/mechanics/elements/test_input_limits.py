"""States that stop at their limits: the wheel that they turn, by SciPy piece by piece, and where it rests."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from lienumba import System
from tests.rigs.inputs import INERTIA, at_hinge, wheel

Number = Callable[[float], float]
END = 2.0
RATE = "6*cos(4*t) - 2*hinge_at.angle"
FIXED = ([-0.5, "0.25 + 0.25"], lambda t: -0.5, lambda t: 0.5)
MOVING = (["-0.4", "0.5 + 0.2*sin(3*t)"], lambda t: -0.4, lambda t: 0.5 + 0.2 * np.sin(3 * t))
METHODS: list[dict[str, Any]] = [
    {"method": "dop853", "tolerance": 1e-11},
    {"method": "taylor", "tolerance": 1e-11},
    {"method": "radau5", "tolerance": 1e-10},
    {"method": "radau9", "tolerance": 1e-10},
    {"method": "rk4", "step": 2e-3},
    {"method": "dp54", "step": 0.01, "coordinates": "joint"},
]


def by_pieces(low: Number, high: Number, times: np.ndarray) -> tuple[np.ndarray, list[float]]:
    """The angle, its rate and the input at these times, and the times at which the input reaches a limit."""

    def slope(f: Number, t: float) -> float:
        return (f(t + 1e-5) - f(t - 1e-5)) / 2e-5

    def rate(t: float, y: Any) -> float:
        return 6 * np.cos(4 * t) - 2 * y[0]

    def held(at: float) -> Callable[[float, Any], float]:
        return lambda t, y: rate(t, y) if at == 0 else slope(high if at > 0 else low, t)

    reaches: Any = lambda t, y: max(y[2] - high(t), low(t) - y[2])  # noqa: E731
    reaches.terminal, reaches.direction = True, 1
    t, at, y, pieces, reached = 0.0, 0, np.zeros(3), [], []
    while t < END:
        leaves: Any = lambda t, y, at=at: (slope(high if at > 0 else low, t) - rate(t, y)) * at  # noqa: E731
        leaves.terminal, leaves.direction = True, 1
        how = held(at)
        found = solve_ivp(
            lambda t, y, how=how: [y[1], y[2] / INERTIA, how(t, y)], (t, END), y, "DOP853", rtol=1e-12, atol=1e-12,
            max_step=0.01, events=leaves if at else reaches, dense_output=True,
        )  # fmt: skip
        pieces.append((t, found.t[-1], found.sol))
        if found.status != 1:
            break
        t, y = found.t[-1], found.y[:, -1]
        if at == 0:
            at = 1 if y[2] - high(t) > low(t) - y[2] else -1
            y[2] = high(t) if at > 0 else low(t)
            reached.append(t)
        else:
            at, y[2] = 0, y[2] - 1e-13 * at
    return np.array([next(sol(x) for a, b, sol in pieces if a <= x <= b) for x in times]).T, reached


@pytest.mark.parametrize("settings", METHODS, ids=lambda x: x["method"])
@pytest.mark.parametrize("limits", [FIXED, MOVING], ids=["fixed", "moving"])
def test_states_stop_and_go_on(limits: Any, settings: dict[str, Any]) -> None:
    given, low, high = limits
    system = at_hinge("inputs.motor").input("motor", rate=RATE, limits=given)
    data = system.to_dict()
    data["integrator"] = {**settings, "end_time": END}
    ds = lienumba.run(data).isel(run=0)
    y, reached = by_pieces(low, high, ds.time.values)
    assert ds.status == 0
    np.testing.assert_allclose(ds["hinge_at.angle"], y[0], rtol=0, atol=2e-9)
    np.testing.assert_allclose(ds["inputs.motor"], y[2], rtol=0, atol=2e-9)
    assert ds.event_count.sel(event="inputs.motor.limited") == len(reached) > 1
    np.testing.assert_allclose(ds.event_time.sel(event="inputs.motor.limited"), reached[0], rtol=0, atol=1e-9)
    assert ds.steps < 4000


def test_orders_are_those_of_the_methods_across_limits() -> None:
    times, errors = np.array([END]), []
    y, _ = by_pieces(*FIXED[1:], times)
    for step in (0.025, 0.0125):
        system = wheel(step=step).force("motor", type="actuator", joint="hinge", value="inputs.motor")
        ds = lienumba.run(system.input("motor", rate=RATE, limits=FIXED[0]))
        errors.append(abs(float(ds["hinge_at.angle"][0, -1]) - y[0, -1]))
    assert 3.6 < np.log2(errors[0] / errors[1]) < 4.6


def test_what_starts_at_a_limit_stays_there_while_its_rate_leads_beyond() -> None:
    ds = lienumba.run(at_hinge("inputs.motor").input("motor", rate="t - 1", limits=[-0.3, 0.3], start=-0.3)).isel(run=0)
    t = ds.time.values
    expected = np.where(t < 1, -0.3, np.minimum(-0.3 + 0.5 * (t - 1) ** 2, 0.3))
    np.testing.assert_allclose(ds["inputs.motor"], expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("high", [1.0, 1e9, 1e30])
def test_a_limit_that_is_none_changes_nothing(high: float) -> None:
    ds = lienumba.run(at_hinge("inputs.motor").input("motor", rate="-cos(4*t)", limits=[0, high], start=0.1)).isel(
        run=0
    )
    t, reached, back = ds.time.values, np.arcsin(0.4) / 4, np.pi / 8
    expected = np.where(t < reached, 0.1 - np.sin(4 * t) / 4, np.where(t < back, 0.0, (1 - np.sin(4 * t)) / 4))
    np.testing.assert_allclose(ds["inputs.motor"], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("high", [1.0, 1e9])
def test_what_starts_outside_its_limits_starts_at_one(high: float) -> None:
    ds = lienumba.run(at_hinge("inputs.motor").input("motor", rate="0.4", limits=[0, high], start=-5)).isel(run=0)
    np.testing.assert_allclose(ds["inputs.motor"], 0.4 * ds.time, rtol=0, atol=1e-12)


def test_limits_that_are_equal_touch_or_cross() -> None:
    def moved(*limits: Any) -> Any:
        ds = lienumba.run(at_hinge("inputs.motor").input("motor", rate="cos(4*t)", limits=list(limits))).isel(run=0)
        return ds.time.values, ds["inputs.motor"].values

    assert (moved(0.3, 0.3)[1] == 0.3).all()
    t, x = moved("0.3*cos(3*t) - 0.3", 0.0)
    assert x.max() <= 0.0
    assert (x >= 0.3 * np.cos(3 * t) - 0.3 - 1e-12).all()
    t, x = moved("0.4*t - 0.3", 0.3)
    np.testing.assert_allclose(x[t > 1.5], 0.4 * t[t > 1.5] - 0.3, rtol=0, atol=1e-12)  # the lower one


def test_limits_that_an_event_sets_hold_from_then_on() -> None:
    system = at_hinge("inputs.motor").input("motor", rate="1", limits=[-1, "most"])
    system.parameter("most", 0.3).event("raised", "t > 0.8", action="set", parameters={"most": 0.7})
    ds = lienumba.run(system).isel(run=0)
    t = ds.time.values
    expected = np.where(t < 0.8, np.minimum(t, 0.3), np.minimum(0.3 + t - 0.8, 0.7))
    np.testing.assert_allclose(ds["inputs.motor"], expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("reads", "within"), [("angle", 1e-13), ("rate", 5e-3)])
def test_limits_that_read_the_motion(reads: str, within: float) -> None:
    """How fast a rate changes is not known."""
    ds = lienumba.run(at_hinge("inputs.motor").input("motor", rate="3", limits=[-1, f"0.5 + 0.01*hinge_at.{reads}"]))
    reached = ds.isel(run=0).sel(time=slice(0.5, None))
    limit = 0.5 + 0.01 * reached[f"hinge_at.{reads}"]
    np.testing.assert_allclose(reached["inputs.motor"], limit, rtol=0, atol=within)


def test_a_limit_that_jumps_takes_the_state_along_and_leaves_it_behind() -> None:
    """Down to 0.2 while it is held at 0.6, up to 0.5, and down to 0.1 while it is on its way down."""
    limit = "where(t < 0.4, 0.6, where(t < 0.8, 0.2, where(t < 1.3, 0.5, 0.1)))"
    rate = "where(t < 1.2, 2, -1)"
    ds = lienumba.run(at_hinge("inputs.motor").input("motor", rate=rate, limits=[-1, limit])).isel(run=0)
    t = ds.time.values
    before = np.where(t < 0.4, np.minimum(2 * t, 0.6), np.where(t < 0.8, 0.2, np.minimum(0.2 + 2 * (t - 0.8), 0.5)))
    behind = np.where(t < 1.3, 0.5 - (t - 1.2), 0.1 - (t - 1.3))
    jumps = np.isin(t.round(9), (0.4, 0.8, 1.3))
    expected = np.where(t < 1.2, before, behind)
    np.testing.assert_allclose(ds["inputs.motor"][~jumps], expected[~jumps], rtol=0, atol=1e-12)


def test_methods_without_events_stop_at_the_end_of_a_step() -> None:
    data = at_hinge("inputs.motor").input("motor", rate="1", limits=[-1, 0.7004]).to_dict()
    ds = lienumba.run(data, overrides={"integrator.method": "cf4"}).isel(run=0)
    assert "event_time" not in ds or not ds.sizes["event"]
    np.testing.assert_allclose(ds["inputs.motor"], np.minimum(ds.time, 0.7004), rtol=0, atol=1e-3)


def test_runs_do_not_depend_on_their_neighbours() -> None:
    system = at_hinge("inputs.motor").input("motor", rate=RATE, limits=[-0.5, "most"]).parameter("most", 0.5)
    system.sweep(runs=20).vary("parameters.most", distribution="uniform", low=0.1, high=1.2)
    data = system.to_dict()
    data["integrator"] = {"method": "radau5", "tolerance": 1e-8, "end_time": END}
    ds = lienumba.run(data)
    assert (ds.status == 0).all()
    assert len(np.unique(ds.event_count.sel(event="inputs.motor.limited"))) > 1
    alone = lienumba.run(data, runs=[13])
    for name in ("hinge_at.angle", "inputs.motor", "event_time"):
        np.testing.assert_array_equal(alone[name][0], ds[name].sel(run=13))


def servo(load: float) -> System:
    """A stiff PI servo against a load that turns with it, its integral within limits."""
    system = wheel().force("motor", type="actuator", joint="hinge", value="1e6*(0.2 - hinge_at.angle) + inputs.pull")
    system.force("brake", type="friction", joint="hinge", viscous=50.0)
    system.force("load", type="actuator", joint="hinge", value=f"{load}*cos(hinge_at.angle)")
    return system.input("pull", rate="4e3*(0.2 - hinge_at.angle)", limits=[-3.0, 2.0])


@pytest.mark.parametrize(("load", "integral"), [(1.0, None), (7.0, -3.0), (-5.0, 2.0)])
def test_servos_rest_at_the_limits_of_their_integrals(load: float, integral: float | None) -> None:
    system = servo(load)
    found = lienumba.equilibrium(system).isel(run=0)
    angle, at = float(found["hinge_at.angle"]), float(found["inputs.pull"])
    assert found.status == 0
    assert abs(1e6 * (0.2 - angle) + at + load * np.cos(angle)) < 1e-8
    stiffness = 1e6 + load * np.sin(angle)
    A = np.array([[0, 1, 0], [-stiffness / INERTIA, -50 / INERTIA, 1 / INERTIA], [-4e3, 0, 0]])
    if integral is None:
        assert abs(angle - 0.2) < 1e-14
    else:
        assert at == integral
        A = A[:2, :2]
    np.testing.assert_allclose(found.growth, np.linalg.eigvals(A).real.max(), rtol=1e-6)
    data = system.to_dict()
    data["model"]["start"] = {"from": "equilibrium"}
    data["integrator"] = {"method": "radau5", "tolerance": 1e-8, "end_time": 1.0}
    ds = lienumba.run(data).isel(run=0)
    assert ds.status == 0
    assert abs(ds["hinge_at.angle"] - angle).max() < 1e-12
    assert ds.steps < 100
