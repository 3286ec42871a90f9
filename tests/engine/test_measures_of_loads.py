"""Formulas of whole runs of what accelerations and multipliers say, by the stages of steps, and of speeds by their
rates: against closed forms, and against the same formulas where neither serves."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.integrators.tracing import step_kernels

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
STEPS = [
    {"step": 0.01},
    {"step": 0.04, "method": "dop853"},
    {"tolerance": 1e-10},
    {"tolerance": 1e-10, "coordinates": "joint"},
    {"tolerance": 1e-10, "method": "tsit54"},
    {"tolerance": 1e-10, "method": "taylor"},
    {"step": 0.02, "method": "radau5"},
]
J, A, RATE = 0.4, 0.3, 2.0
PIN = {"name": "pin", "type": "revolute", "bodies": ["ground", "wheel"], "at": [0, 0, 0], "axis": [0, 0, 1]}
WHEEL: dict[str, Any] = {
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [{"name": "wheel", "mass": 1.0, "inertia": [1, 1, J], "position": [0, 0, 0]}],
        "joints": [
            {"name": "pin", "type": "revolute", "bodies": ["ground", "wheel"], "at": [0, 0, 0], "axis": [0, 0, 1]}
        ],
        "drivers": [{"name": "motor", "joint": "pin", "value": f"{A}*sin({RATE}*t)"}],
    },
    "quantities": [
        {"name": "torque", "type": "driver_effort", "driver": "motor"},
        {"name": "w", "type": "angular_velocity", "body": "wheel"},
    ],
    "output": {"every": np.pi},
}
E, W = J * A * RATE**2, A * RATE
TURNS = {
    "rms(torque)": E / np.sqrt(2),
    "mean(torque)": 0.0,
    "integral(torque*w.z)": 0.0,
    "integral(torque*w.z, t < pi/4)": -J / 2 * W**2,
    "max(torque)": E,
    "min(torque)": -E,
    "time_of_max(torque)": 3 * np.pi / 4,
    "max(w.z)": W,
    "min(w.z)": -W,
    "time_of_min(w.z)": np.pi / 2,
    "count(w.z > 0.5*0.6)": 2.0,
    "last_time(w.z < 0.3)": 5 * np.pi / 6,
    "time_when(torque > 0.24)": np.pi / 3,
}


def measured(texts: list[str], scenario: dict[str, Any], integrator: dict[str, Any], end: float) -> xr.Dataset:
    measures = [{"name": f"m{n}", "value": text} for n, text in enumerate(texts)]
    return lienumba.run(scenario | {"measures": measures, "integrator": integrator | {"end_time": end}})


@pytest.mark.parametrize("inline", [step_kernels.INLINE, 0])
@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_a_driven_wheel_has_closed_forms(
    integrator: dict[str, Any], inline: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(step_kernels, "INLINE", inline)
    step = {key: np.pi / round(np.pi / x) for key, x in integrator.items() if key == "step"}
    ds = measured(list(TURNS), WHEEL, integrator | step, np.pi)
    for n, (text, value) in enumerate(TURNS.items()):
        np.testing.assert_allclose(ds[f"m{n}"].item(), value, rtol=2e-7, atol=2e-7, err_msg=text)


def rods(count: int) -> dict[str, Any]:
    """A chain of rods by hinges that are not parallel, whose mass and start differ from run to run."""
    bodies, joints = [], []
    for n in range(count):
        bodies.append({"name": f"b{n}", "mass": 1.0 + n, "inertia": [0.1, 0.02, 0.1], "position": [0, n + 0.5, 0]})
        ends, axis = [f"b{n - 1}" if n else "ground", f"b{n}"], [1, 0, 0] if n % 2 else [0.8, 0, 0.6]
        joints.append({"name": f"j{n}", "type": "revolute", "bodies": ends, "at": [0, n, 0], "axis": axis})
    return {
        "model": {"gravity": [0, 0, -9.81], "bodies": bodies, "joints": joints},
        "quantities": [
            {"name": "load", "type": "reaction", "joint": "j0"},
            {"name": "v", "type": "point", "body": f"b{count - 1}", "derivative": 1},
            {"name": "a", "type": "point", "body": f"b{count - 1}", "derivative": 2},
        ],
        "output": {"every": 0.5},
        "sweep": {"runs": 9, "vary": {"bodies.b0.mass": {"distribution": "uniform", "low": 0.5, "high": 3.0}}},
    }


def stopped() -> dict[str, Any]:
    """The same, whose second hinge hits a stop, and which is hit by another push every 0.1 s."""
    data = rods(2)
    model = data["model"] | {
        "limits": [{"joint": "j1", "low": "-20*deg", "high": "20*deg", "restitution": 0.6}],
        "forces": [{"name": "push", "type": "force", "body": "b1", "value": ["gust", 0, 0]}],
    }
    noise = {"name": "gust", "type": "white", "std": 20.0, "every": 0.1}
    return data | {"model": model, "noise": [noise]}


PLAIN = [  # smooth, and the same number with a kink in the formula, which has neither a rate nor stages
    ("max(v.z)", "max(abs(v.z + 100) - 100)"),
    ("min(v.x*v.z)", "min(abs(v.x*v.z + 1000) - 1000)"),
    ("max(0.5*(v.x**2 + v.z**2), t > 0.3)", "max(abs(0.5*(v.x**2 + v.z**2)), t > 0.3)"),
    ("last_time(v.z > 0.2)", "last_time(abs(v.z + 100) > 100.2)"),
    ("count(v.z > 0)", "count(abs(v.z + 100) > 100)"),
    ("mean(load.force.z)", "mean(abs(load.force.z + 1e5)) - 1e5"),
    ("rms(load.force.x)", "sqrt(mean(abs(load.force.x**2)))"),
    ("mean(a.z**2)", "mean(abs(a.z**2))"),
    ("integral(a.x)", "integral(abs(a.x + 1e4)) - 1.5e4"),
]


@pytest.mark.parametrize("scenario", [rods(2), rods(5), stopped()], ids=["short", "long", "stopped"])
@pytest.mark.parametrize(
    "integrator",
    [{"step": 2e-3}, {"step": 0.01, "method": "dop853"}, {"tolerance": 1e-10}, {"tolerance": 1e-9, "method": "tsit54"}],
    ids=str,
)
def test_rates_and_stages_say_what_is_found_without_them(scenario: dict[str, Any], integrator: dict[str, Any]) -> None:
    ds = measured([text for pair in PLAIN for text in pair], scenario, integrator, 1.5)
    for n, (text, _) in enumerate(PLAIN):
        one, other = ds[f"m{2 * n}"], ds[f"m{2 * n + 1}"]
        scale = max(1.0, float(abs(one).max()))
        np.testing.assert_allclose(one / scale, other / scale, rtol=0, atol=2e-7, err_msg=text)
