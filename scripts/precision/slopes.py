"""Observed orders of convergence on four mechanisms, with and without projection."""

from dataclasses import dataclass
from functools import cache
from math import ceil, isfinite
from typing import Any

import numpy as np

from document import markdown
from lienumba.analysis import orders
from lienumba.store.study_layout import TRUSTED, typical
from precision.cases import FREE, PROJECTED, gallery, study

OUTPUTS = 5  # when errors are measured; every number of steps is a multiple of it
POINTS = 8  # step sizes of a method
RUNS = 8  # perturbed, whose median error counts: that of a single one may cross zero between two steps
PARTS = ("position", "rotation")


@dataclass(frozen=True)
class Case:
    """scenario and what varies in it; end: s; fine: steps of the reference; steps: fewest and most of each method."""

    scenario: dict[str, Any]
    vary: dict[str, float]
    end: float
    fine: int
    steps: dict[str, tuple[int, int]]


def _steps(euler: int, heun: int, kutta3: int, four: int, **more: tuple[int, int]) -> dict[str, tuple[int, int]]:
    """From so many steps to eight times as many; of pairs from and to."""
    fewest = {"euler": euler, "heun": heun, "kutta3": kutta3, "rk4": four, "cf4": four}
    return {method: (least, 8 * least) for method, least in fewest.items()} | more


WILD = [40, 10, -30]  # rad/s
BOB = {
    "bodies": [{"name": "bob", "mass": 0.3, "inertia": [2e-4, 1e-4, 2e-4], "angular_velocity": WILD}],
    "joints": [
        {"name": "hook", "type": "spherical", "bodies": ["piston", "bob"], "points": [[0, 0, 0], [-0.03, 0.06, 0.02]]}
    ],
}
CASES = {
    "heavy top": Case(
        gallery("heavy_top"), {"bodies.top.angular_velocity[1]": 3.0}, 0.2, 800,
        _steps(1600, 640, 320, 160, dp54=(160, 1280), dop853=(20, 120)),
    ),
    "satellite": Case(
        gallery("satellite"), {f"forces.shoulder_on_base_rod.value[{i}]": 0.05 for i in range(3)}, 45.0, 1800,
        _steps(1800, 900, 450, 225, dp54=(180, 900), dop853=(75, 160)),
    ),
    "four-bar linkage": Case(
        gallery("four_bar"), {"joints.crank_bearing.rate": 1.0}, 2.0, 2000,
        _steps(9600, 1600, 1600, 800, dp54=(480, 2400), dop853=(240, 440)),
    ),
    "driven slider-crank with a bob": Case(
        gallery("slider_crank", model=BOB), {f"bodies.bob.angular_velocity[{i}]": 10.0 for i in range(3)}, 0.2, 1000,
        _steps(3200, 800, 400, 160, dp54=(200, 1000), dop853=(50, 120)),
    ),
}  # fmt: skip


@cache
def measured(name: str, projected: bool) -> tuple[Any, Any]:
    """The study of all methods on a mechanism, and the orders that it shows."""
    case = CASES[name]
    grid = []
    for method, (fewest, most) in case.steps.items():
        exact = [fewest * (most / fewest) ** (k / (POINTS - 1)) for k in range(POINTS)]
        counts = sorted({OUTPUTS * round(n / OUTPUTS) for n in exact})
        grid.append({"integrator.method": [method], "integrator.step": [case.end / n for n in counts]})
    ds = study(
        case.scenario,
        {"method": "dop853", "step": case.end / case.fine},
        grid,
        {
            "integrator.end_time": case.end,
            "output": {"every": case.end / OUTPUTS},
            "sweep": {"runs": RUNS, "seed": 1, "vary": _normal(case.vary)},
            **(PROJECTED if projected else FREE),
        },
    )
    return ds, orders(ds)


def _normal(spreads: dict[str, float]) -> dict[str, Any]:
    return {path: {"distribution": "normal", "std": std} for path, std in spreads.items()}


def finest(ds: Any, method: str, part: str) -> float:
    """The slope between the two smallest steps whose errors the reference can tell."""
    own = ds.isel(case=np.flatnonzero(ds["method"].values == method))
    error, floor = (typical(own, f"{kind}{part}_error").values for kind in ("", "reference_"))
    told = np.flatnonzero(error > TRUSTED * floor)
    h, e = own["step"].values[told], error[told]
    last, before = np.argsort(h)[:2]
    return float(np.log(e[before] / e[last]) / np.log(h[before] / h[last]))


def table(name: str) -> str:
    columns = [(projected, part) for projected in (True, False) for part in PARTS]
    head = [f"{part}s {'with' if projected else 'without'}" for projected, part in columns]
    lines = []
    for n, method in enumerate(CASES[name].steps):
        cells = []
        for projected, part in columns:
            ds, found = measured(name, projected)
            fit = found.isel(curve=n).sel(error=part)
            cells.append(f"{_interval(fit)} ({finest(ds, method, part):.2f})")
        lines.append([method, *cells])
    return markdown(["", *head], lines)


def _interval(fit: Any) -> str:
    order, high = float(fit["order"]), float(fit["high"])
    return f"{order:.2f} ± {ceil(100.0 * (high - order)) / 100.0:.2f}" if isfinite(high) else "too few points"
