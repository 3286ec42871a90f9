"""The work done on a system is integrated with it: energy minus work stays, up to an error of the method's order."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson

import lienumba
from lienumba.integrators.tracing import program, step_kernels
from lienumba.scenario.start.prepare import prepare
from tests.facade import METHODS, resolve
from tests.rigs.scenarios import LINK, scenario, simulate

END = 0.4
STEPS = {1: 5e-4, 2: 4e-3, 3: 8e-3, 4: 1e-2}  # the coarsest, in the asymptotic range


def double_pendulum(**more: Any) -> dict[str, Any]:
    """A hinge askew and a spherical joint below it; `more`: forces, drivers, gravity."""
    links = [
        {"name": "upper", **LINK, "position": [0, 0, -0.3], "rotation": [1, 0, 0, 0]},
        {"name": "lower", **LINK, "position": [0.2, 0, -0.8], "rotation": [1, 0, 0, 0], "angular_velocity": [3, 1, 2]},
    ]
    joints = [
        {"name": "hinge", "type": "revolute", "bodies": ["ground", "upper"], "at": [0, 0, 0], "axis": [0.2, 1, 0.1]},
        {"name": "elbow", "type": "spherical", "bodies": ["upper", "lower"], "at": [0, 0, -0.6]},
    ]
    return {"model": {"bodies": links, "joints": joints, **more}}


def rope(**numbers: Any) -> dict[str, Any]:
    ends = {"bodies": ["ground", "lower"], "points": [[0.5, 0.2, -0.4], [0.1, 0, -0.2]]}
    return {"type": "spring_damper", **ends, "free_length": 0.3, **numbers}


CRANK = {"name": "crank", "joint": "hinge", "value": "2*sin(3*t) + t**2"}
HAND = {"name": "hand", "body": "lower", "motion": "point", "point": [0, 0, -0.2],
        "value": ["0.2 - 0.4*t + 0.5*t**2", "1.6*t - 2*t*t", "-1 - 0.2*t + 4*t**2"]}  # fmt: skip
SERVO = {"type": "actuator", "joint": "hinge", "stiffness": 30, "damping": 2, "target": "sin(2*t)"}
DRAG = {"type": "drag", "body": "lower", "linear": 0.5, "quadratic": 2}
JET = {"type": "force", "body": "lower", "point": [0.1, 0, 0], "frame": "body", "value": [1, 2, "3*t"]}
CASES: dict[str, dict[str, Any]] = {
    "spring": {"forces": [rope(stiffness=40)]},
    "driven": {"drivers": [CRANK]},
    "driven at a rate": {"drivers": [{"name": "crank", "joint": "hinge", "rate": "3*cos(2*t)"}]},
    "driven point": {"drivers": [HAND]},
    "damped": {"forces": [rope(stiffness=40, damping=3), DRAG]},
    "rubbing": {"forces": [{"type": "friction", "joint": "hinge", "viscous": 0.3, "coulomb": 0.5, "velocity": 1.0}]},
    "actuated": {"forces": [{"type": "actuator", "joint": "hinge", "value": "6*cos(4*t)"}, JET]},
    "controlled": {"forces": [SERVO]},
    "what varies": {"forces": [rope(stiffness="40 + 20*sin(6*t)")], "gravity": ["3*sin(5*t)", 0, -9.81]},
    "driven and damped": {"drivers": [CRANK], "forces": [rope(damping=4)]},
}
AT_REST = {"spring"}  # nobody works


def residuals(case: str, method: str, projection: tuple[str, str] = ("local", "mass")) -> list[float]:
    """The largest energy residual with the coarsest step and with two halved ones."""
    mechanism, found = double_pendulum(**CASES[case]), []
    for halvings in range(3):
        step = STEPS[METHODS[method].order] / 2**halvings
        here = simulate(mechanism, step, END, method=method, projection=projection, output={"every": 0.04})
        found.append(float(np.abs(here["energy_residual"]).max()))
        assert (np.abs(here["work"]).max() < 1e-300) == (case in AT_REST)
    return found


@pytest.mark.parametrize(
    ("case", "method"),
    [*((case, "rk4") for case in CASES)]  # the highest order sees the least error of a power
    + [("driven and damped", method) for method in ("euler", "heun", "kutta3")],
)
def test_the_residual_falls_with_the_order(case: str, method: str) -> None:
    found = residuals(case, method)
    order = METHODS[method].order
    slopes = np.log2(np.divide(found[:-1], found[1:]))
    assert slopes[-1] > order - 0.25, found
    assert found[0] > 1e-10  # above rounding, where slopes mean something


@pytest.mark.parametrize("method", ["midpoint", "rk38"])
def test_without_projection_too(method: str) -> None:
    for case in ("driven and damped", "actuated"):
        found = residuals(case, method, ("none", "none"))
        assert np.log2(found[1] / found[2]) > METHODS[method].order - 0.25, found


def test_work_is_the_time_integral_of_the_drivers_power() -> None:
    """What the driver's effort does along its prescribed rate, by Simpson's rule."""
    here = simulate(double_pendulum(**CASES["driven"]), 1e-3, END, output={"every": 1e-3})
    t, effort = here["time"].values, here["driver_effort"].sel(effort="crank").values
    power = effort * (6 * np.cos(3 * t) + 2 * t)
    assert np.abs(here["work"]).max() > 1.0
    assert float(here["work"][-1]) == pytest.approx(simpson(power, x=t), abs=1e-8)


def test_work_is_what_dampers_take() -> None:
    """The rope's damper, from the positions and velocities that are stored."""
    here = simulate(double_pendulum(forces=[rope(damping=3)]), 1e-3, END, output={"every": 1e-3})
    lower = here.sel(body="lower")
    R, arm = lower["rotation"].values, np.array([0.1, 0, -0.2])
    end = lower["position"].values + R @ arm - [0.5, 0.2, -0.4]
    speed = lower["velocity"].values + (R @ np.cross(lower["angular_velocity"].values, arm)[..., None])[..., 0]
    along = (end * speed).sum(1) / np.linalg.norm(end, axis=1)
    assert float(here["work"][-1]) == pytest.approx(simpson(-3 * along**2, x=here["time"].values), abs=1e-9)
    assert (np.diff(here["work"]) <= 0).all()


@pytest.mark.parametrize("case", ["driven and damped", "controlled"])
def test_a_step_stage_by_stage_does_the_same_work(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = double_pendulum(**CASES[case])
    whole = simulate(mechanism, 1e-3, 0.1, output={"every": 0.01})
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    staged = simulate(mechanism, 1e-3, 0.1, output={"every": 0.01})
    for name in ("position", "angular_velocity", "work", "energy_residual"):
        np.testing.assert_allclose(staged[name], whole[name], rtol=0, atol=1e-11)


@pytest.mark.parametrize("case", CASES)
def test_work_is_held_only_where_somebody_may_work(case: str) -> None:
    prepared = prepare(resolve(scenario(double_pendulum(**CASES[case]), 1e-3, 1e-3)), [0])
    held = program.build(prepared.model, program.Method("euler", "local", "mass")).augmented
    assert held.work == (case not in AT_REST)


def test_work_counts_from_the_start_of_the_run_whatever_is_stored() -> None:
    mechanism = double_pendulum(**CASES["driven"])
    every = simulate(mechanism, 1e-3, 0.1, output={"every": 0.01})
    end = simulate(mechanism, 1e-3, 0.1, output={"times": [0.1]})
    assert float(every["work"][0]) == 0
    assert float(end["work"][-1]) == float(every["work"][-1]) != 0


@pytest.mark.parametrize(("coordinates", "method"), [("lie", "dop853"), ("joint", "dop853"), ("joint", "dp54")])
def test_a_tolerance_holds_for_the_work_where_laws_have_kinks(coordinates: str, method: str) -> None:
    """A crank that is driven against a stop moves as prescribed, stop or not: its power alone shows the kink."""
    stop = {"type": "end_stop", "joint": "hinge", "lower": -0.3, "upper": 0.4, "stiffness": 2000, "damping": 5}
    crank = {"name": "crank", "joint": "hinge", "value": "0.8*sin(9*t)"}
    body = {"name": "arm", **LINK, "position": [0, 0, -0.3], "rotation": [1, 0, 0, 0]}
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "arm"], "at": [0, 0, 0], "axis": [0.2, 1, 0.1]}
    data: dict[str, Any] = {
        "model": {"bodies": [body], "joints": [hinge], "drivers": [crank], "forces": [stop]},
        "integrator": {"method": method, "end_time": 1.0, "coordinates": coordinates},
        "output": {"every": 0.05},
    }
    for tolerance in (1e-6, 1e-9):
        ds = lienumba.run(data, overrides={"integrator.tolerance": tolerance}, workers=1)
        assert int(ds["status"][0]) == 0
        moved = float(np.abs(ds["work"]).max())
        assert moved > 10.0
        assert float(np.abs(ds["energy_residual"]).max()) < 20 * tolerance * moved
