"""The layout of the dataset of a study: errors, costs and times at every point of its grid, for every run."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from lienumba.store import layout
from lienumba.store.layout import RUN, Variable

if TYPE_CHECKING:
    import xarray as xr

CASE = "case"  # the dimension of several grids
ERRORS = {
    "position": ("m", "position error"),
    "rotation": ("rad", "rotation error (angle between the rotations)"),
    "velocity": ("m s-1", "velocity error"),
    "angular_velocity": ("rad s-1", "angular velocity error"),
}
OF_POINTS = (
    "max_position_violation", "max_velocity_violation", "max_energy_drift", "status", "end_time", "steps",
    "rejected_steps",
)  # fmt: skip  # of each run at each point, as in the dataset of runs
TIMES = {
    "time_per_run": Variable((), "s", "time of one core per run, median of the repetitions"),
    "time_per_run_spread": Variable((), "s", "largest minus smallest time of one core per run of the repetitions"),
}


def _count(text: str) -> Variable:
    return Variable(RUN, "1", text, dtype="int32", count=True)


# The dimensions of the grid follow those given here.
VARIABLES: dict[str, Variable] = {
    **{f"{n}_error": Variable(RUN, u, f"largest {text} at the stored times") for n, (u, text) in ERRORS.items()},
    **{f"final_{n}_error": Variable(RUN, u, f"{text} at the last stored time") for n, (u, text) in ERRORS.items()},
    **{f"reference_{n}_error": Variable(RUN, u, f"{text} of the reference itself") for n, (u, text) in ERRORS.items()},
    **{name: layout.VARIABLES[name] for name in OF_POINTS},
    "max_position_iterations": _count("most iterations of the position projection"),
    "max_velocity_iterations": _count("most iterations of the velocity projection"),
    "evaluations": Variable(RUN, "1", "evaluations of the accelerations: stages times attempted steps"),
    **TIMES,
}  # fmt: skip
COSTS = ("end_time", "steps", "evaluations", *TIMES)  # over which errors stand
TAKEN = {*VARIABLES, *layout.COORDINATES, CASE}  # what no coordinate of a grid may be called
TRUSTED = 100.0  # an error below this many times that of the reference is doubtful


@dataclass(frozen=True)
class Coordinate:
    """The values of one path of a grid along `dim`, which is its own or that of the cases."""

    name: str
    dim: str
    values: Sequence[str] | Sequence[float]
    units: str
    path: str


def dataset(
    arrays: Mapping[str, np.ndarray],
    runs: Sequence[int],
    grid: Sequence[Coordinate],
    inputs: Mapping[str, np.ndarray],
    input_units: Mapping[str, str],
    attributes: Mapping[str, str | int | float],
    measures: Mapping[str, Variable] = MappingProxyType({}),
) -> xr.Dataset:
    """The labelled dataset of arrays (runs, points of each dimension of the grid); times have no runs; measures: what
    there is of each run beside `VARIABLES`."""
    import xarray as xr

    dims = tuple(dict.fromkeys(coordinate.dim for coordinate in grid))
    data, known = {}, VARIABLES | _with_errors(measures)
    for name, array in arrays.items():
        spec = known[name]
        data[name] = layout.variable(name, replace(spec, dims=(*spec.dims, *dims)), array, len(runs))
    labels = np.asarray(runs, dtype=np.int32)
    run = xr.Variable("run", labels, layout.texts(*layout.COORDINATES["run"]), layout.bare(labels))
    coordinates: dict[str, xr.Variable] = {"run": run}
    if CASE in dims:
        numbers = np.arange(len(grid[0].values), dtype=np.int32)
        texts = layout.texts("1", "number of the point")
        coordinates[CASE] = xr.Variable(CASE, numbers, texts, layout.bare(numbers))
    for entry in grid:
        values = np.asarray(entry.values, dtype=str if isinstance(entry.values[0], str) else np.float64)
        texts = layout.texts(entry.units, entry.path) | {"role": "grid", "path": entry.path}
        coordinates[entry.name] = xr.Variable(entry.dim, values, texts, layout.bare(values))
    return xr.Dataset(data, coordinates | layout.input_coordinates(inputs, input_units, len(runs)), dict(attributes))


def _with_errors(measures: Mapping[str, Variable]) -> dict[str, Variable]:
    found = dict(measures)
    for name, spec in measures.items():
        found[f"{name}_error"] = Variable(RUN, spec.units, f"error of {name}")
        found[f"reference_{name}_error"] = Variable(RUN, spec.units, f"error of {name} of the reference itself")
    return found


def errors_of(ds: xr.Dataset) -> dict[str, tuple[str, str]]:
    """Of what a study has errors, with their units and what they are: states, and numbers of whole runs."""
    measures = [str(name) for name, x in ds.data_vars.items() if "measure" in x.attrs]
    every = ERRORS | {name: (str(ds[name].attrs.get("units", "1")), f"{name} error") for name in measures}
    return {name: said for name, said in every.items() if f"{name}_error" in ds}


def is_study(ds: xr.Dataset) -> bool:
    """Whether a dataset is that of a study."""
    return bool(grid_of(ds))


def grid_of(ds: xr.Dataset) -> dict[str, str]:
    """The coordinates of the grid of a study, with their paths."""
    return {str(name): str(x.attrs["path"]) for name, x in ds.coords.items() if x.attrs.get("role") == "grid"}


def typical(ds: xr.Dataset, name: str) -> xr.DataArray:
    """The median of a variable over the runs that succeeded, at every point; NaN where none did."""
    good = np.where(ds["status"].values == 0, ds[name].values, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # points without a good run
        median = np.nanmedian(good, axis=0)
    return ds[name].isel(run=0, drop=True).copy(data=median)
