"""Integrals, means and root mean squares over steps that are long beside what is integrated."""

from itertools import pairwise
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import lienumba

RATE, END = 3.0, 20.0
TURNING: dict[str, Any] = {
    "model": {
        "bodies": [{"name": "b", "mass": 2, "inertia": [1, 1, 1], "position": [0, 0, 0], "angular_velocity": [0, 0, 3]}]
    },
    "quantities": [{"name": "p", "type": "point", "body": "b", "point": [1, 0, 0]}],
    "output": {"every": END},
}
SWINGING: dict[str, Any] = {
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [{"name": "b", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [1, 0, 0]}],
        "joints": [{"name": "j", "type": "revolute", "bodies": ["ground", "b"], "at": [0, 0, 0], "axis": [0, 1, 0]}],
    },
    "quantities": [{"name": "angle", "type": "joint", "joint": "j"}, {"name": "p", "type": "point", "body": "b"}],
    "output": {"every": 10.0},
}
STEPS: list[dict[str, Any]] = [
    {"tolerance": 1e-9, "method": name} for name in ("dop853", "dp54", "tsit54", "bs32", "taylor", "radau5")
]
STEPS += [{"step": 0.01, "method": "rk4"}, {"step": 0.01, "method": "dp54"}]
FORMULAS = {
    "integral(p.x)": lambda t: cos(RATE * t),
    "integral(p.x**2)": lambda t: cos(RATE * t) ** 2,
    "integral(exp(p.x)*p.y**2)": lambda t: np.exp(cos(RATE * t)) * sin(RATE * t) ** 2,
    "integral(abs(p.y))": lambda t: abs(sin(RATE * t)),
    "integral(clip(p.x, -0.3, 0.5))": lambda t: min(max(cos(RATE * t), -0.3), 0.5),
    "integral(where(p.x > 0.2, p.y**2, 1))": lambda t: sin(RATE * t) ** 2 if cos(RATE * t) > 0.2 else 1.0,
    "integral(p.x, p.y > 0.3)": lambda t: cos(RATE * t) if sin(RATE * t) > 0.3 else 0.0,
}


def measured(scenario: dict[str, Any], texts: list[str]) -> list[float]:
    found = lienumba.run(scenario | {"measures": [{"name": f"m{n}", "value": x} for n, x in enumerate(texts)]})
    return [float(found[f"m{n}"][0]) for n in range(len(texts))]


def exact(f: Any) -> float:
    """Over as many parts as there are half turns and bends, each of which a rule can do."""
    bends = [np.arccos(0.5), np.arccos(-0.3), np.arcsin(0.3), np.arccos(0.2), pi / 2]
    every = {k * pi + side * x for k in range(25) for x in [*bends, 0.0] for side in (-1, 1)}
    ends = [0.0, *sorted(x / RATE for x in every if 0 < x / RATE < END), END]
    return sum(quad(f, a, b, epsabs=1e-14)[0] for a, b in pairwise(ends) if b - a > 1e-13)


@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_a_steady_rotation_in_a_few_steps(integrator: dict[str, Any]) -> None:
    found = measured(TURNING | {"integrator": integrator | {"end_time": END}}, list(FORMULAS))
    for (text, f), x in zip(FORMULAS.items(), found, strict=True):
        assert x == pytest.approx(exact(f), abs=5e-8), text


@pytest.mark.parametrize("method", ["dop853", "tsit54", "taylor", "radau5"])
def test_many_turns_in_one_step(method: str) -> None:
    """Of a body that turns 64 times in the run, of which some methods make a handful of steps."""
    end = 64 * 2 * pi / RATE + 0.1
    found = measured(
        TURNING | {"integrator": {"method": method, "tolerance": 1e-8, "end_time": end}, "output": {"every": end}},
        ["rms(p.x)", "mean(abs(p.y))"],
    )
    square = 0.5 + sin(2 * RATE * end) / (4 * RATE * end)
    assert found[0] == pytest.approx(sqrt(square), rel=2e-7)
    assert found[1] == pytest.approx((64 * 4 / RATE + (1 - cos(0.1 * RATE)) / RATE) / end, rel=2e-7)


@pytest.mark.parametrize("method", ["dop853", "dp54", "bs32"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_an_integral_is_about_as_exact_as_the_tolerance(method: str, tolerance: float) -> None:
    """Of a pendulum of large swings, beside a run whose steps are far shorter."""
    texts = ["integral(angle.angle**2)", "integral(exp(3*p.z))", "integral(abs(p.x))", "integral(p.z**2)"]
    reference = measured(SWINGING | {"integrator": {"method": "dop853", "tolerance": 1e-13, "end_time": 10.0}}, texts)
    integrator = {"method": method, "tolerance": tolerance, "end_time": 10.0}
    found = measured(SWINGING | {"integrator": integrator}, texts)
    assert found == pytest.approx(reference, rel=100 * tolerance)


def test_what_is_nothing_but_rounding_does_not_hold_a_run_up() -> None:
    """The energy of a pendulum beside what it was: the wall clock is the witness, by the limit of time of the suite."""
    integrator = {"method": "dop853", "tolerance": 1e-10, "end_time": 10.0}
    (found,) = measured(SWINGING | {"integrator": integrator}, ["rms((p.x**2 + p.z**2 - 1)*1e9)"])
    assert 0 <= found < 10


def test_no_run_feels_its_neighbours() -> None:
    """Runs that need many panels, beside others that need few, and alone."""
    rates = {"bodies.b.angular_velocity[2]": [0.1, 3.0, 50.0, 0.7, 11.0, 2.0, 0.01, 7.0, 1.0]}
    scenario = TURNING | {"integrator": {"method": "dop853", "tolerance": 1e-8, "end_time": END}}
    scenario |= {"sweep": {"sampler": "table", "table": {"columns": rates}}}
    texts = ["rms(p.x)", "mean(abs(p.y))", "integral(max(p.x, p.y, 0.2))", "max(min(p.x, p.y))"]
    texts += ["integral(mod(p.x, 0.3))", "integral(exp(-((20*p.x)**2)))", "integral(exp(-((9*p.y - 3)**2)))"]
    scenario |= {"measures": [{"name": f"m{n}", "value": text} for n, text in enumerate(texts)]}
    together = lienumba.run(scenario)
    for run in range(9):
        alone = lienumba.run(scenario, runs=[run])
        for n in range(len(texts)):
            assert alone[f"m{n}"].values[0] == together[f"m{n}"].values[run]
