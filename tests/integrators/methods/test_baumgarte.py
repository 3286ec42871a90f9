"""Baumgarte's damping of violations: they follow the equation of an oscillator in critical damping, exactly; what a
method adds to them in every step remains, at its order."""

from typing import Any

import numpy as np
import pytest

from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import R3xSO3
from lienumba.mechanics.system import constraints, dynamics, kkt
from tests.facade import METHODS, Instant
from tests.integrators.methods.test_convergence import END, reference
from tests.integrators.tracing.test_work import CRANK, double_pendulum
from tests.rigs.in_charts import NONE, numbers, run_in
from tests.rigs.scenarios import LOOP, PENDULUM, scenario, start_of

RATE = 10.0  # 1/s
SPIN = {"name": "spin", "body": "lower", "motion": "angular_velocity", "value": [3, "1 + 2*t", "2 + t"]}


def damped(mechanism: dict[str, Any], step: float, end: float, rate: float | None = RATE, **keywords: Any) -> Any:
    keys: dict[str, Any] = {"projection": NONE} | ({} if rate is None else {"baumgarte": rate})
    return run_in({}, mechanism, step, end, **keys, **keywords)


@pytest.mark.parametrize("drivers", [[], [CRANK], [SPIN]], ids=["free", "driven", "turned"])
def test_a_violation_decays_as_it_should(drivers: list[dict[str, Any]]) -> None:
    """From a start that is off the joints: Phi(t) = (Phi + (Phi' + rate Phi) t) exp(-rate t), and of rows without
    position psi(t) = psi exp(-rate t)."""
    model, states = start_of(scenario(double_pendulum(drivers=drivers), 1e-3, 1e-3))
    states += 1e-3 * np.random.default_rng(1).standard_normal(states.shape)
    structure, chart, h, steps = kkt.Structure.of(model), R3xSO3(2), 5e-3, 40
    x: Any = tuple(tuple(body) for body in states.tolist())

    def violations(x: Any, t: float) -> tuple[np.ndarray, np.ndarray]:
        now = Instant(x, t)
        return np.array(constraints.residual(model, now)), np.array(constraints.rate_and_bias(model, now)[0])

    def stage(x: Any, u: Any, t: float) -> Any:
        def F(bodies: Any) -> Any:
            a = dynamics.accelerations(model, structure, Instant(bodies, t), baumgarte=RATE).x
            return tuple((*body[12:18], *a[6 * i : 6 * i + 6]) for i, body in enumerate(bodies))

        return munthe_kaas.slope(chart, x, u, F)

    phi, rate = violations(x, 0.0)
    for n in range(steps):
        x, *_ = munthe_kaas.step(chart, METHODS["rk4"], x, n * h, h, stage)
    t = steps * h
    decay = np.exp(-RATE * t)
    levels = [c.level for c in constraints.constraints_of(model) for _ in range(c.rows)]
    left = np.array([level == "position" for level in levels])
    found = violations(x, t)
    np.testing.assert_allclose(found[0][left], ((phi + (rate + RATE * phi) * t) * decay)[left], rtol=0, atol=3e-7)
    np.testing.assert_allclose(found[1][~left], (rate * decay)[~left], rtol=0, atol=3e-7)
    assert np.abs(phi).max() > 5e-4
    assert left.all() == (drivers != [SPIN])


@pytest.mark.parametrize("name", ["pendulum", "loop"])
def test_the_order_stays(name: str) -> None:
    mechanism, steps = {"pendulum": PENDULUM, "loop": LOOP}[name], (8e-3, 4e-3)
    errors = [np.abs(numbers(damped(mechanism, h, END[name])) - reference(name)).max() for h in steps]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.2), errors


def test_violations_stay_small_but_depend_on_the_step() -> None:
    """Over 4 s: without damping they grow, with a projection they are rounding."""
    keys: dict[str, Any] = {"output": {"every": 0.5}}
    loose, coarse, fine = (damped(PENDULUM, *at, **keys) for at in ((4e-3, 4.0, None), (4e-3, 4.0), (2e-3, 4.0)))
    projected = run_in({}, PENDULUM, 4e-3, 4.0, **keys)
    of_loose, of_coarse, of_fine, of_projected = (
        float(ds["position_violation"].max()) for ds in (loose, coarse, fine, projected)
    )
    assert of_coarse < 0.05 * of_loose
    assert np.log2(of_coarse / of_fine) == pytest.approx(4, abs=0.3)
    assert of_projected < 1e-15 < 1e-10 < of_fine
