"""`Prepared.value_and_gradient`: an output with its derivatives by the numbers that are given, for optimisers."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import lienumba
from lienumba.compiler import native
from tests.facade import ScenarioError
from tests.rigs.flights import FLOOR, GRAVITY, fall, flight, height

SPEED, DOWN = "bodies.b.velocity[2]", "gravity[2]"
START = {SPEED: 8.0, DOWN: GRAVITY}


@pytest.fixture(scope="module")
def ready() -> Any:
    return lienumba.prepare(flight())


def test_the_value_is_that_of_a_run_and_the_gradient_has_the_order_of_the_paths(ready: Any) -> None:
    t, times = fall(), np.arange(0.0, 2.1, 0.5)
    rate = 8.0 + GRAVITY * t
    value, gradient = ready.value_and_gradient(START, "event_time.fallen")
    assert value == ready.run(START)["event_time"].item()
    np.testing.assert_allclose(value, t, rtol=1e-12)
    np.testing.assert_allclose(gradient, [-t / rate, -0.5 * t**2 / rate], rtol=1e-9)
    turned = ready.value_and_gradient({DOWN: GRAVITY, SPEED: 8.0}, "event_time.fallen")
    np.testing.assert_array_equal(turned[1], gradient[::-1])
    value, gradient = ready.value_and_gradient(START, "p.z")
    np.testing.assert_allclose(value, height(times), atol=1e-12)
    np.testing.assert_allclose(gradient, np.stack([times, 0.5 * times**2], axis=1), atol=1e-10)
    value, gradient = ready.value_and_gradient({SPEED: 7.0}, "last_position.b.z")
    np.testing.assert_allclose([value, *gradient], [height(2.0, 7.0), 2.0], rtol=1e-10)


def test_nothing_is_compiled_again(ready: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    ready.value_and_gradient(START, "top")
    monkeypatch.setattr(native, "compile_text", None)
    tops = [ready.value_and_gradient({SPEED: speed, DOWN: GRAVITY}, "top")[0] for speed in (7.0, 7.5, 9.0)]
    np.testing.assert_allclose(tops, [-(speed**2) / (2.0 * GRAVITY) for speed in (7.0, 7.5, 9.0)], rtol=1e-8)


def test_an_optimiser_finds_the_throw_that_falls_at_a_given_time(ready: Any) -> None:
    def miss(x: np.ndarray) -> tuple[float, np.ndarray]:
        time, slopes = ready.value_and_gradient({SPEED: float(x[0])}, "event_time.fallen")
        return (time - 1.0) ** 2, 2.0 * (time - 1.0) * slopes

    found = minimize(miss, [8.0], jac=True, method="BFGS", options={"gtol": 1e-9})
    assert found.x[0] == pytest.approx(FLOOR - 0.5 * GRAVITY, rel=1e-8)
    assert found.nfev < 30


def test_the_sweep_counts_for_nothing() -> None:
    vary = {SPEED: {"distribution": "uniform", "low": 5.0, "high": 6.0}}
    ready = lienumba.prepare(flight(**vary), overrides={"sweep.runs": 1})
    value, gradient = ready.value_and_gradient({SPEED: 7.0}, "last_position.b.z")
    np.testing.assert_allclose([value, *gradient], [height(2.0, 7.0), 2.0], rtol=1e-10)


@pytest.mark.parametrize(
    ("parameters", "of", "told"),
    [
        ({}, "top", "parameters: are empty"),
        ({"bodies.b.velocity": [0, 0, 1]}, "top", r"must be one number; give its components, such as .*velocity\[0\]"),
        ({"bodies.c.mass": 1.0}, "top", "bodies.c"),
        ({"integrator.step": 1.0}, "top", "is no number of the model"),
        (START, "tip", "tip.*the dataset does not have"),
        (START, "status", "has no derivative"),
    ],
)
def test_what_cannot_be_differentiated(ready: Any, parameters: dict[str, Any], of: str, told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        ready.value_and_gradient(parameters, of)
