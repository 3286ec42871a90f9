"""Every form of an input at the torque of a wheel: its motion by SciPy, or by hand."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs.inputs import INERTIA, at_hinge, wheel

WAYS = ("lie", "joint")
LIMITS: list[tuple[dict[str, Any], float, float]] = [
    ({"limit": 0.5}, -0.5, 0.5),
    ({"limits": [-0.2, "0.4"]}, -0.2, 0.4),
]


def played(keys: dict[str, Any], way: str = "lie", **more: float) -> Any:
    system = at_hinge("inputs.motor", **more).input("motor", **keys)
    return lienumba.run(system, overrides={"integrator.coordinates": way}).isel(run=0)


def solved(rates: Any, times: np.ndarray, start: Any = (0.0, 0.0)) -> np.ndarray:
    return solve_ivp(rates, (0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-12, max_step=5e-3).y


@pytest.mark.parametrize("way", WAYS)
def test_pd_follows_the_rate_of_its_target(way: str) -> None:
    ds = played({"joint": "hinge", "kp": 9, "kd": "0.5 + 0.1*t", "target": "sin(t)", "feedforward": "0.2*t"}, way)

    def rates(t: float, y: Any) -> Any:
        torque = 0.2 * t + 9 * (np.sin(t) - y[0]) + (0.5 + 0.1 * t) * (np.cos(t) - y[1])
        return [y[1], torque / INERTIA]

    np.testing.assert_allclose(ds["hinge_at.angle"], solved(rates, ds.time.values)[0], rtol=0, atol=1e-10)
    assert ds["inputs.motor"].attrs["units"] == "N m"


def test_a_rate_that_is_given_takes_the_place_of_that_of_the_target() -> None:
    ds = played({"joint": "hinge", "kp": 9, "kd": 0.5, "target": "sin(t)", "rate": "0.3"})
    y = solved(lambda t, y: [y[1], (9 * (np.sin(t) - y[0]) + 0.5 * (0.3 - y[1])) / INERTIA], ds.time.values)
    np.testing.assert_allclose(ds["hinge_at.angle"], y[0], rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("limit", "low", "high"), [({"limit": 0.5}, -0.5, 0.5), ({"limits": [-0.2, "0.4"]}, -0.2, 0.4)]
)
def test_limits(limit: dict[str, Any], low: float, high: float) -> None:
    ds = played({"joint": "hinge", "kp": 9, "kd": 0.5, "target": 1.0, **limit})

    def rates(t: float, y: Any) -> Any:
        return [y[1], np.clip(9 * (1 - y[0]) - 0.5 * y[1], low, high) / INERTIA]

    np.testing.assert_allclose(ds["hinge_at.angle"], solved(rates, ds.time.values)[0], rtol=0, atol=1e-5)
    assert ds["inputs.motor"].min() == low
    assert ds["inputs.motor"].max() == high


@pytest.mark.parametrize("way", WAYS)
def test_a_filter_follows_with_the_first_order(way: str) -> None:
    ds = played({"value": "sin(3*t)", "filter": 0.2, "start": 0.4}, way)
    t, a, w = ds.time.values, 0.2, 3.0
    steady = (np.sin(w * t) - a * w * np.cos(w * t)) / (1 + (a * w) ** 2)
    expected = steady + (0.4 + a * w / (1 + (a * w) ** 2)) * np.exp(-t / a)
    np.testing.assert_allclose(ds["inputs.motor"], expected, rtol=0, atol=1e-11)


def test_a_filter_follows_a_recording() -> None:
    ds = played({"times": [0, 2], "values": [0, 2], "filter": 0.1})
    t = ds.time.values
    np.testing.assert_allclose(ds["inputs.motor"], t - 0.1 * (1 - np.exp(-t / 0.1)), rtol=0, atol=1e-10)


def test_a_filter_keeps_the_order_of_the_method() -> None:
    errors = []
    for step in (0.025, 0.0125):
        ds = played({"value": "exp(-t)", "filter": 0.1}, step=step)
        t = ds.time.values
        errors.append(abs(ds["inputs.motor"].values - (np.exp(-t) - np.exp(-10 * t)) / 0.9).max())
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.4


@pytest.mark.parametrize("way", WAYS)
def test_a_state_reads_itself_and_the_mechanism(way: str) -> None:
    ds = played({"rate": "(2 - inputs.motor)/0.1 - 3*hinge_at.angle", "start": 0.5}, way)

    def rates(t: float, y: Any) -> Any:
        return [y[1], y[2] / INERTIA, (2 - y[2]) / 0.1 - 3 * y[0]]

    y = solved(rates, ds.time.values, (0.0, 0.0, 0.5))
    np.testing.assert_allclose(ds["hinge_at.angle"], y[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(ds["inputs.motor"], y[2], rtol=0, atol=1e-9)


def test_a_state_stays_at_its_limits_and_comes_back_at_once() -> None:
    ds = played({"rate": "where(t < 1, 5, -5)", "limits": [-0.5, 1]})
    t = ds.time.values
    expected = np.where(t < 1, np.minimum(5 * t, 1), np.maximum(1 - 5 * (t - 1), -0.5))
    np.testing.assert_allclose(ds["inputs.motor"], expected, rtol=0, atol=5.1e-3)  # a step beyond, where it is met


@pytest.mark.parametrize("interpolation", ["hold", "linear"])
def test_a_recording_loses_no_order_at_its_points(interpolation: str) -> None:
    times, values = [0, 0.3333, 0.77, 2], [1.0, -2.0, 3.0, 0.5]
    ds = played({"times": times, "values": values, "interpolation": interpolation, "delay": 0.111}, step=0.05)
    t = np.linspace(0, 2, 20_001)
    value = np.interp(t - 0.111, times, values)
    if interpolation == "hold":
        value = np.array(values)[np.clip(np.searchsorted(times, t - 0.111, "right") - 1, 0, 3)]
    steps = np.diff(t)
    rate = np.concatenate([[0], np.cumsum(0.5 * (value[1:] + value[:-1]) * steps)]) / INERTIA
    angle = np.concatenate([[0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * steps)])
    np.testing.assert_allclose(
        ds["hinge_at.angle"], angle[::500], rtol=0, atol=2e-3 if interpolation == "hold" else 1e-6
    )
    exact = played({"times": times, "values": values, "interpolation": interpolation, "delay": 0.111}, step=1e-3)
    np.testing.assert_allclose(ds["hinge_at.angle"], exact["hinge_at.angle"], rtol=0, atol=1e-11)


def test_numbers_of_inputs_vary_from_run_to_run() -> None:
    keys = {"joint": "hinge", "kp": 9, "kd": 0.5, "target": 1.0, "filter": 0.05}
    system = at_hinge("inputs.motor").input("motor", **keys).sweep(runs=3)
    system.vary("inputs.motor.kp", distribution="uniform", low=5, high=9)
    system.vary("inputs.motor.filter", distribution="uniform", low=0.02, high=0.1)
    ds = lienumba.run(system)
    for run in ds.run.values:
        own = {key: float(ds[f"inputs.motor.{key}"][run]) for key in ("kp", "filter")}
        np.testing.assert_array_equal(ds["hinge_at.angle"][run], played(keys | own)["hinge_at.angle"])
    assert ds["inputs.motor.filter"].attrs["units"] == "s"


def test_a_filter_that_is_not_positive_makes_a_run_invalid() -> None:
    system = at_hinge("inputs.motor").input("motor", value="t", filter=0.05).sweep(runs=8)
    system.vary("inputs.motor.filter", distribution="normal", std=0.05)
    with pytest.warns(UserWarning, match="will draw a value of 0 or below"):
        ds = lienumba.run(system)
    wrong = ds["inputs.motor.filter"].values <= 0
    assert wrong.any()
    np.testing.assert_array_equal(ds.status.values != 0, wrong)


@pytest.mark.parametrize(("keys", "low", "high"), LIMITS)
def test_an_actuator_has_one_limit_or_two(keys: dict[str, Any], low: float, high: float) -> None:
    system = wheel().force("motor", type="actuator", joint="hinge", stiffness=9, damping=0.5, target=1.0, **keys)
    law = f"clip(9*(1 - hinge_at.angle) - 0.5*hinge_at.rate, {low}, {high})"
    same = wheel().force("motor", type="actuator", joint="hinge", value=law)
    one, other = (lienumba.run(x)["hinge_at.angle"] for x in (system, same))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)
