"""Which run of a dataset is looked at closely: one that is named, or that in which something is largest."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isnan, nan
from typing import Any

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.store.components import components, dims_of, matching
from lienumba.store.layout import FULL, RUN, remedy
from lienumba.store.windows import windows
from lienumba.words import plural, show

PEAKS = ("_max", "_min")


@dataclass(frozen=True)
class SelectedRun:
    """A run, and the sentence that says why it is this one, if it was not named."""

    run: int
    sentence: str = ""


@dataclass(frozen=True)
class Peak:
    """The largest absolute value of a variable, and the labels of its place."""

    size: float
    place: dict[str, Any]
    variable: str


def select_run(ds: "xr.Dataset", where: str, run: int | None, name: str | None) -> SelectedRun:
    """The run that is asked for: by its label, or as the worst in a variable."""
    if run is not None and name is not None:
        raise ScenarioError("--run names a run, and --worst chooses one; give one of them")
    if run is not None:
        check_run(ds, where, run)
        return SelectedRun(run)
    labels = ds["run"].values
    if name is not None:
        check_run(ds, where, int(labels[0]))
        return worst(ds, name)
    failed = labels[~ds["status"].isin(GOOD).values.reshape(len(labels), -1).all(axis=1)]
    first = f"{len(failed):,} of {len(labels):,} failed, the first is --run {failed[0]}" if len(failed) else ""
    raise ScenarioError(
        f"{where}: which run? Give --run N, or --worst NAME, such as --worst max_energy_drift"
        + (f"; {first}" if first else "")
    )


def check_run(ds: "xr.Dataset", where: str, run: int) -> None:
    """A ScenarioError if there is no such run, or none that could be replayed."""
    from lienumba.store.study_layout import is_study

    if isinstance(run, bool) or not hasattr(run, "__index__"):
        raise ScenarioError(f"run = {run!r}: is not a label; give a whole number such as 17")
    if "scenario" not in ds.attrs or "run" not in ds.dims:
        raise ScenarioError(f"{where}: has no runs of lienumba with their scenario; give what lienumba run wrote")
    if is_study(ds):
        raise ScenarioError(
            f"{where}: is of a study, which has many settings for each run; run the scenario with those of the point "
            "(--set) and without [study], and replay a run of that"
        )
    labels = ds["run"].values
    if run not in labels:
        raise ScenarioError(
            f"{where}: has no run {run}, but {len(labels):,} with labels from {labels.min()} to {labels.max()}; give "
            "one of them"
        )


def worst(ds: "xr.Dataset", name: str) -> SelectedRun:
    """The run in which the largest absolute value of a variable occurs, of all that have one, failed ones too."""
    names = _variables(ds, name)
    peak = max((_peak(ds, variable) for variable in names), key=lambda found: found.size)
    if peak.size < 0.0:
        raise ScenarioError(f"--worst {name}: no run has a value of it; choose another variable, or a run with --run")
    dim = str(ds[_whole(ds, names[0])].dims[0])
    time = _time(ds, name, peak)
    rest = [str(label) for key, label in peak.place.items() if key not in (dim, "time")]
    unit = str(ds[peak.variable].attrs.get("units", "1"))
    value = f"{peak.size:.6g}" + ("" if unit == "1" else f" {unit}")
    number = plural(ds.sizes[dim], "run", "runs") + (" whose course is stored" if dim == FULL else "")
    run = int(peak.place[dim])
    return SelectedRun(
        run,
        f"run {run} has the largest |{name}| of {number}: {value}"
        + (f" ({', '.join(rest)})" if rest else "")
        + ("" if isnan(time) else f", at t = {time:g} s"),
    )


def _variables(ds: "xr.Dataset", name: str) -> list[str]:
    """The variables in which the largest value of `name` is: its course in every run, its extremes, or its course in
    some runs."""
    peaks = [name + end for end in PEAKS if name + end in ds]
    names = [str(x) for x in ds.variables if x not in ds.dims and ds[x].dims[:1] in (RUN, (FULL,))]
    if name == "status":
        raise ScenarioError("--worst status: says how a run ended, not how large something is; choose with --run")
    if name in names and not (peaks and ds[name].dims[0] == FULL):
        return [name]
    if not peaks and any(name.startswith(f"{x}.") for x in names):
        return [name]  # a component, or several
    if not peaks:
        stems = [x.removesuffix(end) for x in names for end in PEAKS if x.endswith(end)]
        raise ScenarioError(f"--worst {show(name)}: the dataset has no such variable; {remedy(name, [*names, *stems])}")
    return peaks


def _peak(ds: "xr.Dataset", variable: str) -> Peak:
    """Where a variable is largest; of equals the first."""
    return max(_peaks(ds, variable), key=lambda found: found.size)


def _whole(ds: "xr.Dataset", name: str) -> str:
    """The variable of this name, or of which this is a component."""
    return name if name in ds else max((str(x) for x in ds if name.startswith(f"{x}.")), key=len)


def _peaks(ds: "xr.Dataset", name: str) -> Iterator[Peak]:
    """That of each window of runs; below 0 where all are NaN. name: of a variable, or of components of one."""
    variable = _whole(ds, name)
    dims, every = [str(dim) for dim in ds[variable].dims], components(ds[variable])
    wanted = [*every] if name == variable else matching(name, {variable: every}, "variable")
    others = [n for n, component in enumerate(every) if component not in wanted]
    first = len(dims) - len(dims_of(ds[variable]))
    for window in windows(ds, [variable], dims[0]):
        sizes = abs(window[variable].values.astype(float))
        sizes[np.isnan(sizes)] = -1.0
        sizes.reshape(*sizes.shape[:first], -1)[..., others] = -1.0
        place = np.unravel_index(int(sizes.argmax()), sizes.shape)
        labels = {dim: window[dim].values[n] for dim, n in zip(dims, place, strict=True)}
        yield Peak(float(sizes[place]), labels, variable)


def _time(ds: "xr.Dataset", name: str, peak: Peak) -> float:
    """When it was (s); NaN if that is not known."""
    if "time" in peak.place:
        return float(peak.place["time"])
    times = f"{name}_time_of_max"
    if peak.variable != f"{name}_max" or times not in ds:
        return nan
    return float(ds[times].sel(peak.place))
