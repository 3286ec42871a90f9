"""Whether the error that is achieved follows the tolerance."""

from functools import cache
from itertools import pairwise
from typing import Any

from document import markdown, text
from precision.cases import PAIRS, gallery, study

TOLERANCES = tuple(float(f"1e-{n}") for n in range(4, 13))
CASES = {"heavy top": ("heavy_top", 2.0, 1e-4), "satellite": ("satellite", 10.0, 5e-3)}  # s, and the reference's step
ROUNDING = 2e-13  # m and rad, below which nothing is left that a tolerance could improve
INTERVALS = 20  # between the times at which errors are measured


@cache
def achieved(name: str, method: str) -> list[float]:
    """The largest error of a position (m) or rotation (rad) at any stored time, by tolerance."""
    scenario, end, step = CASES[name]
    grid: list[dict[str, Any]] = [{"integrator.method": [method], "integrator.tolerance": list(TOLERANCES)}]
    overrides = {"integrator.end_time": end, "output": {"every": end / INTERVALS}}
    ds = study(gallery(scenario), {"method": "dop853", "step": step}, grid, overrides).isel(run=0)
    worst = [max(float(x), float(y)) for x, y in zip(ds["position_error"][0], ds["rotation_error"][0], strict=True)]
    return worst


def column(name: str, method: str) -> list[str]:
    """By tolerance, the error and how many times the tolerance it is; whether it falls with every tolerance."""
    found = achieved(name, method)
    cells = [f"{text(e, digits=2)} ({text(e / tol, digits=2)})" for e, tol in zip(found, TOLERANCES, strict=True)]
    falls = all(fine < coarse or coarse < ROUNDING for coarse, fine in pairwise(found))
    return [*cells, "yes" if falls else "no"]


def table(name: str) -> str:
    columns = [column(name, method) for method in PAIRS]
    first = [*map(text, TOLERANCES), "monotone"]
    return markdown(["tolerance", *PAIRS], [list(cells) for cells in zip(first, *columns, strict=True)])
