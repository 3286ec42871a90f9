"""Work against precision of thousands of perturbed runs: steps and evaluations of each method for an error, and time.

Steps, and the tolerance of a pair, are scanned; between the two points on either side of the error they are
interpolated on logarithmic axes, and what is found is run again: its errors and costs are those of the tables.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import ceil, log
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from document import markdown, text
from lienumba.integrators import methods
from precision.cases import PAIRS, gallery, simulated, study

METHODS = ("heun", "kutta3", "rk4", "cf4", "dp54", "tsit54", "dop853")
EXACT = {"integrator.method": "dop853", "integrator.tolerance": 1e-13}
QUANTILE = 0.9
MOST = 50_000  # steps of a run
AT_ONCE = 3  # points of a scan in one study
ROUNDS = 5  # of timing


@dataclass(frozen=True)
class Case:
    """end: s; coarsest: steps at which the scan begins; levels: of the error in m; tolerances: between which that of
    pairs is looked for."""

    scenario: dict[str, Any]
    end: float
    coarsest: int
    levels: tuple[float, ...]
    tolerances: tuple[float, float]


LEVELS = (1e-3, 1e-6, 1e-9)
CASES = {
    "heavy top": Case(gallery("heavy_top_monte_carlo"), 2.0, 100, LEVELS, (1e-1, 1e-13)),
    "satellite": Case(gallery("satellite_monte_carlo", sweep={"runs": 64}), 10.0, 10, LEVELS, (1e-1, 1e-12)),
}


def error_of(ds: Any) -> np.ndarray:
    """Of the positions in the end (points,): 90 % of the runs are better."""
    return np.asarray(ds["final_position_error"].quantile(QUANTILE, "run", skipna=False).values).ravel()


@cache
def reference(name: str) -> TemporaryDirectory[str]:
    """A folder with the trusted motion of all runs."""
    folder = TemporaryDirectory()
    case = CASES[name]
    simulated(case.scenario, EXACT | _ends(case)).to_netcdf(Path(folder.name) / "exact.nc")
    return folder


def points(name: str, settings: Sequence[Mapping[str, Any]]) -> Any:
    """A study of settings of the integrator, in their order."""
    grid = [{f"integrator.{key}": [value] for key, value in setting.items()} for setting in settings]
    exact = {"file": str(Path(reference(name).name) / "exact.nc")}
    return study(CASES[name].scenario, exact, grid, _ends(CASES[name]))


def _ends(case: Case) -> dict[str, Any]:
    return {"integrator.end_time": case.end, "output": {"times": [0.0, case.end]}}


@cache
def scan(name: str, method: str, adaptive: bool) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of steps, or reciprocal tolerances, and their errors, until the smallest level is met, or there are too
    many steps."""
    case = CASES[name]
    first, last = (1.0 / x for x in case.tolerances) if adaptive else (float(case.coarsest), MOST)
    factor = 10.0**0.5 if adaptive else 2.0**0.5
    wanted = [first * factor**n for n in range(1 + int(log(last / first, factor) + 1e-9))]
    tried: list[float] = []
    errors: list[float] = []
    for some in (wanted[n : n + AT_ONCE] for n in range(0, len(wanted), AT_ONCE)):
        ds = points(name, [setting(case, method, x, adaptive) for x in some])
        tried += some
        errors += error_of(ds).tolist()
        if errors[-1] < case.levels[-1] or float(ds["steps"].max()) > MOST:
            break
    return np.array(tried), np.array(errors)


def setting(case: Case, method: str, x: float, adaptive: bool) -> dict[str, Any]:
    """So many steps, or a reciprocal tolerance."""
    return {"method": method} | ({"tolerance": 1.0 / x} if adaptive else {"step": case.end / ceil(x)})


@cache
def needed(name: str, method: str, level: float, adaptive: bool = False) -> float | None:
    """The steps, or the reciprocal tolerance, at which the error falls below a level; None if it does not."""
    tried, errors = scan(name, method, adaptive)
    e = np.where(np.isfinite(errors), errors, np.inf)
    above = np.flatnonzero(e > level)
    n = above[-1] + 1 if len(above) else 0
    if n == len(e):
        return None
    if n == 0 or not np.isfinite(e[n - 1]):
        return float(tried[n])
    part = np.log(e[n - 1] / level) / np.log(e[n - 1] / e[n])
    return float(tried[n - 1] * (tried[n] / tried[n - 1]) ** part)


def steps_row(name: str, method: str) -> list[str]:
    """Of fixed steps: how many for each level, and evaluations for the smallest that is reached."""
    stages = len(methods.METHODS[method].b)
    found = [needed(name, method, level) for level in CASES[name].levels]
    counts = [f"> {MOST:,}" if x is None else f"{ceil(x):,}" for x in found]
    evaluations = ["" if x is None else f"{stages * ceil(x):,}" for x in found]
    return [method, *counts, *evaluations]


def steps_table(name: str) -> str:
    levels = [text(level) for level in CASES[name].levels]
    head = ["", *(f"steps to {x} m" for x in levels), *(f"evaluations to {x} m" for x in levels)]
    return markdown(head, [steps_row(name, method) for method in METHODS])


def both(name: str, method: str, level: float) -> list[dict[str, Any]] | None:
    """The cheapest fixed step and the tolerance that meet a level; None where either does not, or the coarsest does."""
    fixed, free = (needed(name, method, level, adaptive) for adaptive in (False, True))
    case = CASES[name]
    if fixed is None or free is None or fixed == case.coarsest:
        return None
    return [setting(case, method, fixed, False), setting(case, method, free, True)]


def adaptive_rows(name: str, method: str) -> list[list[str]]:
    """Tolerance against fixed step: what is found, and the ratio of mean evaluations."""
    rows = []
    for level in CASES[name].levels:
        pair = both(name, method, level)
        if pair is None:
            continue
        ds = points(name, pair)
        steps, work = (ds[x].mean("run").values.ravel() for x in ("steps", "evaluations"))
        counts = [f"{steps[0]:,.0f}", f"{steps[1]:,.0f}", f"{work[1] / work[0]:.2f}"]
        rows.append([method, text(level), text(pair[1]["tolerance"], digits=2), *counts])
    return rows


def adaptive_table(name: str) -> str:
    head = ["", "error, m", "tolerance", "fixed steps", "adaptive steps, mean", "evaluations, adaptive / fixed"]
    return markdown(head, [row for method in PAIRS for row in adaptive_rows(name, method)])


def seconds(name: str, settings: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Of one core by run (rounds, points); the points of a round follow one another."""
    return np.stack([points(name, settings)["time_per_run"].values.ravel() for _ in range(ROUNDS)])


def times_table(name: str) -> str:
    """Microseconds of one core per run."""
    case = CASES[name]
    wanted = [(method, level, needed(name, method, level)) for method in METHODS for level in case.levels]
    there = [(method, level, x) for method, level, x in wanted if x is not None]
    found = seconds(name, [setting(case, method, x, False) for method, _, x in there])
    cells = {
        (method, level): f"{_us(own.min())} ({_us(np.median(own))})"
        for (method, level, _), own in zip(there, found.T, strict=True)
    }
    lines = [[method, *(cells.get((method, level), "") for level in case.levels)] for method in METHODS]
    return markdown(["", *(f"{text(level)} m" for level in case.levels)], lines)


def _us(seconds: float) -> str:
    """In microseconds, three digits."""
    return text(1e6 * seconds, digits=3)
