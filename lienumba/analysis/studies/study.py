"""A study read point by point: what each costs for which error, and the curves along which the step is refined."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from lienumba.errors import ScenarioError
from lienumba.store.study_layout import CASE, errors_of, grid_of, is_study, typical

REFINING = ("integrator.step", "integrator.tolerance")  # paths that make steps smaller, or begin so
COSTS = ("steps", "rejected_steps", "evaluations")
TIMES = ("time_per_run", "time_per_run_spread")


@dataclass(frozen=True)
class Curve:
    """The points that differ in the step alone. labels: the other coordinates; along: the coordinate that refines;
    points: indices of `labels_of`, as the grid has them."""

    labels: dict[str, str | float]
    along: str
    points: list[int]

    @property
    def name(self) -> str:
        """The labels in one line, with their names if there are several."""
        shown = {name: text(value) for name, value in self.labels.items() if text(value)}
        return ", ".join(shown.values() if len(shown) == 1 else [f"{name} = {label}" for name, label in shown.items()])


def work_precision(ds: xr.Dataset) -> xr.Dataset:
    """Errors and costs of every point of a study: medians over the runs that succeeded, and how many failed.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned of a scenario with [study].

    Returns
    -------
    xarray.Dataset
        On the dimensions of the grid. Times are those of one core per run; runs go eight at a time.
    """
    check_study(ds)
    names = [name for name in (*(f"{name}_error" for name in errors_of(ds)), *COSTS) if name in ds]
    found = ds[list(TIMES)].assign({name: typical(ds, name) for name in names})
    failed = (ds["status"] != 0).sum("run").assign_attrs(units="1", long_name="runs that failed")
    return found.assign(failed=failed)[[*names, *TIMES, "failed"]]


def steps_of(ds: xr.Dataset) -> np.ndarray:
    """The mean step (s) at every point, in one row."""
    steps: np.ndarray = (typical(ds, "end_time") / typical(ds, "steps")).values.ravel()
    return steps


def labels_of(ds: xr.Dataset) -> dict[str, np.ndarray]:
    """Every coordinate of the grid at every point, in one row."""
    whole = ds["time_per_run"]
    return {name: ds[name].broadcast_like(whole).transpose(*whole.dims).values.ravel() for name in grid_of(ds)}


def curves(ds: xr.Dataset) -> list[Curve]:
    """The curves of a study; none if its grid refines nothing."""
    labels = labels_of(ds)
    refining = [name for name, path in grid_of(ds).items() if path.startswith(REFINING)]
    found: dict[tuple[Any, ...], Curve] = {}
    for point in range(ds["time_per_run"].size):
        own = {name: values[point] for name, values in labels.items()}
        along = [name for name in refining if text(own[name])]
        if along:
            rest = {name: value for name, value in own.items() if name not in refining}
            key = (*along, *map(text, rest.values()))
            found.setdefault(key, Curve(rest, along[0], [])).points.append(point)
    return list(found.values())


def text(label: str | float) -> str:
    """A label for people; empty where the grid of a case does not have it."""
    if isinstance(label, str):
        return str(label)
    return "" if label != label else f"{float(label):g}"


def check_study(ds: xr.Dataset) -> None:
    """Refuse a dataset that is none of a study."""
    if not is_study(ds):
        raise ScenarioError("the dataset is not that of a study; give one of a scenario with [study]")


def other_dims(ds: xr.Dataset) -> tuple[str, ...]:
    """The dimensions of one value per curve."""
    dims = tuple(map(str, ds["time_per_run"].dims))
    refining = [name for name, path in grid_of(ds).items() if path.startswith(REFINING)]
    return ("curve",) if CASE in dims else tuple(dim for dim in dims if dim not in refining)
