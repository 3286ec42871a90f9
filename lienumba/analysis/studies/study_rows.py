"""A study as rows of texts and lines of points, which a terminal, a page and a figure draw."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.analysis.studies.orders import orders
from lienumba.analysis.studies.study import TIMES, Curve, curves, labels_of, steps_of, text, work_precision
from lienumba.analysis.text_table import NONE, TextTable, number_text, short_text
from lienumba.batch.statuses import GOOD, STATUSES, Status
from lienumba.store.study_layout import TRUSTED, errors_of, grid_of, typical
from lienumba.words import plural

STEP, EVALUATIONS, TIME = "step", "evaluations", "time_per_run"
COSTS = {  # words and unit
    STEP: ("mean step", "s"),
    EVALUATIONS: ("evaluations per run", ""),
    TIME: ("time of one core per run", "s"),
}
NONE_SEEN = "none seen"
DOUBTFUL = f"below {TRUSTED:g} times the error of the reference"  # what is shaded
LIMITS = (1e-3, 1e-6, 1e-9, 1e-12)  # of errors, for which it is told what costs least
SHORT_TIMES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


@dataclass(frozen=True)
class Failure:
    """The runs that failed in one way; where: the first point at which some did, and how many others."""

    count: int
    status: Status
    where: str


@dataclass(frozen=True)
class StudyLine:
    """The points of a curve that have a place on the axes, from small steps to large ones."""

    name: str
    x: np.ndarray
    y: np.ndarray


def headline(ds: xr.Dataset) -> str:
    """How many points there are, and runs at each."""
    points, runs = ds["time_per_run"].size, ds.sizes["run"]
    return f"{plural(points, 'point', 'points')}, each with {plural(runs, 'run', 'runs')}"


def failures(ds: xr.Dataset) -> Iterator[Failure]:
    """How runs failed."""
    status, labels = ds["status"].values.reshape(ds.sizes["run"], -1), labels_of(ds)
    for kind in STATUSES:
        failed = status == kind.code
        points = failed.any(axis=0).nonzero()[0]
        if kind.code in GOOD or not len(points):
            continue
        first = {name: text(values[points[0]]) for name, values in labels.items()}
        where = ", ".join(f"{name} = {label}" for name, label in first.items() if label)
        more = f" and {plural(len(points) - 1, 'other point', 'other points')}" if len(points) > 1 else ""
        yield Failure(int(failed.sum()), kind, where + more)


def refines(ds: xr.Dataset) -> bool:
    """Whether any curve has points enough to show an order."""
    return any(len(curve.points) > 1 for curve in curves(ds))


def order_table(ds: xr.Dataset) -> TextTable:
    """The observed orders of each curve."""
    lines, found = curves(ds), orders(ds)
    flat = {str(key): x.values.reshape(found.sizes["error"], -1) for key, x in found.data_vars.items()}
    rows = []
    for n, line in enumerate(lines):
        fits = zip(*(flat[key][:, n] for key in ("order", "low", "high")), strict=True)
        points, finest, coarsest = (flat[key][0, n] for key in ("points", "finest", "coarsest"))
        steps = f"{finest:.3g} to {coarsest:.3g} s" if points > 1 else ""
        rows.append([*map(text, line.labels.values()), *(order_text(*fit) for fit in fits), str(points), steps])
    errors = [_in_words(str(name)) for name in found["error"].values]
    return TextTable.of([*lines[0].labels], [*errors, "points", "mean steps"], rows)


def remarks(ds: xr.Dataset) -> Iterator[str]:
    """What the tables leave to say: why no order is seen, and what costs least."""
    if refines(ds) and any(NONE_SEEN in row for row in order_table(ds).rows):
        yield f"{NONE_SEEN}: points lie so far from a line that the interval is wider than the order; try finer ones"
    for name, (units, _) in [*errors_of(ds).items()][:1]:
        for limit, point in _cheapest(ds, name).items():
            where = ", ".join(f"{key} = {text(values[point])}" for key, values in labels_of(ds).items())
            costs = _time_of(ds, point)
            yield f"least time for {_in_words(name)} errors up to {limit:g} {unit_label(units)}: {where} ({costs})"


def _cheapest(ds: xr.Dataset, error: str) -> dict[float, int]:
    """The point that costs least time of those with errors up to a limit, where the reference can tell; no point twice,
    but for its smallest limit."""
    found, times = work_precision(ds), ds[TIME].values.ravel()
    errors, failed = (found[name].values.ravel() for name in (f"{error}_error", "failed"))
    best: dict[int, float] = {}
    for limit in LIMITS:
        good = np.flatnonzero((errors <= limit) & (failed == 0))
        if len(good) and limit >= doubtful(ds, error):
            best[int(good[np.argmin(times[good])])] = limit
    return {limit: point for point, limit in best.items()} if len(times) > 1 else {}


def point_table(ds: xr.Dataset, most: int) -> TextTable:
    """Errors and costs of the first so many points."""
    found, labels = work_precision(ds), labels_of(ds)
    flat = {str(name): x.values.ravel() for name, x in found.data_vars.items()}
    said = errors_of(ds)
    counts = [x for x in ("steps", "rejected_steps", "evaluations", "failed") if x in flat]
    counts = [name for name in counts if name in ("steps", "evaluations") or np.nansum(flat[name])]
    rows = [
        [
            *(text(values[n]) for values in labels.values()),
            *(number_text(flat[f"{name}_error"][n], ".1e") for name in said),
            *(number_text(flat[name][n], ",.0f") for name in counts),
            _time_of(ds, n),
        ]
        for n in range(min(ds[TIME].size, most))
    ]
    headings = [_heading(name, unit) for name, (unit, _) in said.items()]
    return TextTable.of([*grid_of(ds)], [*headings, *map(_in_words, counts), "time per run"], rows)


def _heading(name: str, unit: str) -> str:
    label = unit_label(unit)
    return f"{_in_words(name)} ({label})" if label else _in_words(name)


def lines(ds: xr.Dataset, name: str, cost: str, logarithmic: bool = True) -> list[StudyLine]:
    """A variable over the step or another cost, curve by curve; over a cost other than the step, every point that is of
    no curve for itself."""
    steps, y = steps_of(ds), typical(ds, name).values.ravel()
    x = steps if cost == STEP else (ds[TIME] if cost == TIME else typical(ds, cost)).values.ravel()
    has_place = ((y > 0.0) if logarithmic else abs(y) < float("inf")) & (x > 0.0)
    every, found = curves(ds), []
    for curve in every if cost == STEP else [*every, *_alone(ds, every)]:
        points = sorted((point for point in curve.points if has_place[point]), key=lambda point: steps[point])
        found.append(StudyLine(curve.name, x[points], y[points]))
    return found


def doubtful(ds: xr.Dataset, error: str) -> float:
    """The error below which the reference says little; 0 if there is none."""
    floor = typical(ds, f"reference_{error}_error").values
    return TRUSTED * float(floor[np.isfinite(floor)].max(initial=0.0))


def order_text(order: float, low: float, high: float) -> str:
    """An observed order with its 95 % interval."""
    if order != order:
        return NONE
    if high - low > order:
        return NONE_SEEN
    return f"{order:.2f}" + (f" ± {0.5 * (high - low):.1g}" if low == low else "")


def time_text(seconds: float, spread: float = 0.0) -> str:
    """A short time with three digits, and half of the spread of its repetitions where there is some."""
    size, unit = next((x for x in SHORT_TIMES if seconds >= x[0]), SHORT_TIMES[-1])
    more = f" ± {short_text(0.5 * spread / size, 2)}" if spread > 0.0 else ""
    return f"{short_text(seconds / size, 3)}{more} {unit}"


def _time_of(ds: xr.Dataset, point: int) -> str:
    return time_text(*(float(ds[name].values.ravel()[point]) for name in TIMES if name in ds))


def _alone(ds: xr.Dataset, others: list[Curve]) -> Iterator[Curve]:
    """Every point for itself, but for those of these curves."""
    labels, taken = labels_of(ds), {point for curve in others for point in curve.points}
    for point in range(ds[TIME].size):
        if point not in taken:
            yield Curve({name: values[point] for name, values in labels.items()}, "", [point])


def _in_words(name: str) -> str:
    return name.replace("_", " ")
