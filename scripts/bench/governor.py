"""The stiff governor of the gallery: what a run costs to an error of its arms, by implicit and by explicit methods."""

from statistics import median
from typing import Any, NamedTuple

import numpy as np

import lienumba
from bench.clock import Stopwatch

SCENARIO = "scenarios/flyball_governor.toml"
LEVEL = 1e-6  # m
ROUNDS = 5
FEW, JUDGED = 64, 8  # runs that tell what a sweep costs at all; runs whose errors are looked at
TOLERANCES = [10.0 ** (-n / 8) for n in range(24, 64)]
STEPS = [10.0 / n for n in (20000, 25000, 32000, 40000, 50000)]  # s
LADDERS: dict[str, tuple[str, list[float], int]] = {  # by method: what is set, to what, and the runs of a long sweep
    "radau9": ("tolerance", TOLERANCES, 4096),
    "radau5": ("tolerance", TOLERANCES, 4096),
    "bs32": ("tolerance", TOLERANCES[:1] + TOLERANCES[8::8], 1024),
    "dp54": ("tolerance", TOLERANCES[:1] + TOLERANCES[8::8], 1024),
    "dop853": ("tolerance", TOLERANCES[:1] + TOLERANCES[8::8], 1024),
    "kutta3": ("step", STEPS, 512),
    "rk4": ("step", STEPS, 512),
}


class Row(NamedTuple):
    """error: of the arms' mass centres (m); own: core seconds of a run."""

    method: str
    setting: str
    steps: float
    error: float
    own: float


def sweep(method: str, runs: int, every: float, **setting: Any) -> Any:
    """The dataset and core seconds of runs that differ a little in how fast they turn."""
    changes = {
        "integrator.method": method, "integrator.coordinates": "joint", "output.variables": ["position"],
        "output.every": every, "sweep.runs": runs, "sweep.nominal": False,
        "sweep.vary": {"joints.bearing.rate": {"distribution": "normal", "std": 0.02}},
        **{f"integrator.{key}": x for key, x in setting.items()},
    }  # fmt: skip
    if "step" in setting:
        changes["integrator.tolerance"] = None
    watch = Stopwatch()
    found = lienumba.run(SCENARIO, overrides=changes, workers=1)
    return found, watch.spent().core


def table() -> list[Row]:
    """Of each method the first setting of its ladder that keeps all arms within the error, all the time.

    What a run costs is what many runs take more than few: steps, its start, its outputs and its part of the dataset,
    without what a sweep costs whatever its length."""
    exact = sweep("radau9", JUDGED, 0.05, tolerance=1e-11)[0].position.values
    chosen: dict[str, tuple[dict[str, float], float, float, int]] = {}
    for method, (key, ladder, runs) in LADDERS.items():
        for x in ladder:
            found = sweep(method, JUDGED, 0.05, **{key: x})[0]
            error = float(np.abs(found.position.values - exact).max())
            if (found.status == 0).all() and error <= LEVEL:
                chosen[method] = {key: x}, float(found.steps.mean()), error, runs
                break
    spent: dict[str, list[float]] = {method: [] for method in chosen}
    for _ in range(ROUNDS):
        for method, (setting, _, _, runs) in chosen.items():
            few, many = (sweep(method, n, 0.5, **setting)[1] for n in (FEW, runs))
            spent[method].append((many - few) / (runs - FEW))
    return [
        Row(method, ", ".join(f"{key} {x:.3g}" for key, x in setting.items()), steps, error, median(spent[method]))
        for method, (setting, steps, error, _) in chosen.items()
    ]
