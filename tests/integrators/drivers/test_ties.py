"""Series, where both sides of a comparison are equal as a step begins, or where one is nearly passed already."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs import parts

SLIDER: dict[str, Any] = {
    "bodies": [parts.body("b", 1, 1, position=[0, 0, 0])],
    "joints": [parts.joint("j", "prismatic", "b", at=[0, 0, 0], axis=[1, 0, 0])],
}


def slide(force: str, end: float, **more: Any) -> Any:
    model = SLIDER | {"forces": [{"name": "f", "type": "actuator", "joint": "j", "value": force}]}
    integrator = {"method": "taylor", "tolerance": 1e-10, "end_time": end}
    seen = [{"name": "p", "type": "joint", "joint": "j"}]
    scenario = {"model": model, "quantities": seen, "integrator": integrator, "output": {"every": end}} | more
    return lienumba.run(scenario)


AT_ONCE = {  # from rest at 0: forces that compare what is 0 there, and where they lead in a second
    "1 + min(-p.speed, 0)": lambda t, x, v: 1 + min(-v, 0),
    "1 - where(p.speed > 0, 2*p.speed, 0)": lambda t, x, v: 1 - (2 * v if v > 0 else 0),
    "where(p.displacement > 0, 2, 1)": lambda t, x, v: 2.0,
    "where(p.displacement < 0, 2, 1) - 0.5": lambda t, x, v: 0.5,
    "min(sin(t), 0) + max(0, sin(3*t))": lambda t, x, v: min(np.sin(t), 0) + max(0, np.sin(3 * t)),
    "abs(sin(7*t)) - 0.2": lambda t, x, v: abs(np.sin(7 * t)) - 0.2,
}


@pytest.mark.parametrize("force", AT_ONCE)
def test_both_sides_are_equal_at_the_start(force: str) -> None:
    found = slide(force, 1.0)
    assert found.status.item() == 0
    assert found.steps.item() < 40
    exact = solve_ivp(lambda t, y: [y[1], AT_ONCE[force](t, *y)], (0, 1), [0, 0], rtol=1e-10, atol=1e-12, max_step=1e-3)
    assert found["p.displacement"].values[0, -1] == pytest.approx(exact.y[0, -1], abs=2e-7)


@pytest.mark.parametrize("rate", ["3*sin(7*t)", "0.1 + 3*sin(7*t)", "3*cos(7*t)", "-3*sin(7*t)"])
def test_a_state_stays_at_its_limits(rate: str) -> None:
    """It stops there, and goes on when its rate turns, in a few steps each."""
    found = slide("inputs.I", 3.0, inputs={"I": {"rate": rate, "limits": [-0.2, 0.4]}})
    assert found.status.item() == 0
    assert found.steps.item() < 100
    h, state = 1e-4, 0.0
    middles = h * (np.arange(30_000) + 0.5)
    for slope in eval(rate, {"sin": np.sin, "cos": np.cos, "t": middles}).tolist():
        state = min(max(state + h * slope, -0.2), 0.4)
    assert found["inputs.I"].values[0, -1] == pytest.approx(state, abs=1e-6)


@pytest.mark.parametrize("end", [0.208, 0.2081, 0.2085])
def test_a_kink_directly_before_the_end(end: float) -> None:
    """A step that is to end at it is not stretched to the end of the run again."""
    found = slide("clip(t - 0.2078, 0, 1) + where(p.displacement > 0.5*0.2075**2, 0, 1)", end)
    assert found.status.item() == 0
    assert found.rejected_steps.item() < 40


def test_friction_that_sticks_beside_gears_and_stops() -> None:
    """Friction has rows of its own, also where it is asked what an elimination compares without forces."""
    wheels = [parts.body(n, 1, [0.1, 0.1, i], position=[x, 0, 0]) for n, i, x in (("a", 0.02, 0.0), ("b", 0.15, 0.4))]
    hinges = [parts.hinge(n.upper(), n, [x, 0, 0], parts.Z, angle=0) for n, x in (("a", 0.0), ("b", 0.4))]
    gear = {"name": "G", "type": "gear", "joints": ["A", "B"], "ratio": -0.25}
    rubs = {"type": "friction", "name": "rubs", "joint": "B", "coulomb": 0.5, "static": 0.8}
    motor = {"type": "actuator", "name": "motor", "joint": "A", "value": "0.5*t"}
    model = {"gravity": [0, 0, 0], "bodies": wheels, "joints": [*hinges, gear], "forces": [rubs, motor]}
    model["limits"] = [{"name": "stop", "joint": "B", "low": -0.6, "restitution": 0.5}]
    seen = [{"name": "A", "type": "joint", "joint": "A"}]
    ends = []
    for method in ("taylor", "dop853"):
        integrator = {"method": method, "tolerance": 1e-10, "end_time": 1.4, "max_step": 0.05}
        found = lienumba.run({"model": model, "quantities": seen, "integrator": integrator, "output": {"every": 0.7}})
        assert found.status.item() == 0
        ends.append(found["A.angle"].values[0])
    np.testing.assert_allclose(*ends, atol=1e-8)
    assert ends[0][-1] > 0.1
