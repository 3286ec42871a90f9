"""The paper's two mechanisms as the gallery has them, with the steps and tolerances of its figures."""

import json
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import lienumba

ROOT = Path(__file__).resolve().parents[2]
END = {"heavy_top": 2.0, "satellite": 10.0}  # s; the paper gives no time for the satellite
REFERENCES = {
    "heavy_top": ROOT / "tests" / "oracles" / "paper" / "references" / "heavy_top.json",
    "satellite": ROOT / "tests" / "oracles" / "paper" / "references" / "satellite.json",
}
PARTS = {"r": "position", "R": "rotation", "v": "velocity", "omega": "angular_velocity"}
POINTS = 2000  # stored in a run, at least where it has as many steps


@cache
def simulated(
    name: str, step: float, position: str = "none", velocity: str = "none", tolerance: float = 1e-11, every: float = 0.0
) -> Any:
    """One run of a mechanism, its outputs `every` seconds, by default at most POINTS of them."""
    every = every or max(step, END[name] / POINTS)
    return _run(name, step, position, velocity, tolerance, {"every": every})


@cache
def error(name: str, step: float, position: str, velocity: str) -> float:
    """The largest difference of any number of the state from the references, at their times (m, 1, m/s, rad/s)."""
    states = json.loads(REFERENCES[name].read_text(encoding="utf-8"))["states"]
    run = _run(name, step, position, velocity, 1e-11, {"times": [0.0, *(state["t"] for state in states)]})
    worst = 0.0
    for part, variable in PARTS.items():
        exact = np.array([[body[part] for body in state.get("bodies", [state])] for state in states])
        worst = max(worst, float(np.abs(run[variable].values[1:] - exact).max()))
    return worst


def _run(name: str, step: float, position: str, velocity: str, tolerance: float, output: Any) -> Any:
    overrides = {
        "integrator.step": step,
        "integrator.end_time": END[name],
        "projection.position": position,
        "projection.velocity": velocity,
        "projection.tolerance": tolerance,
        "output": output,
    }
    with warnings.catch_warnings():  # the slider has an inertia that no rigid body has, as printed
        warnings.simplefilter("ignore")
        run = lienumba.run(ROOT / "scenarios" / f"{name}.toml", overrides=overrides, workers=1).isel(run=0)
    if int(run["status"]) != 0:
        raise RuntimeError(f"{name} with {overrides} ended with status {int(run['status'])}")
    return run
