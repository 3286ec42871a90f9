"""Which run of a dataset is looked at closely: one that is named, or that in which something is worst."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isnan, nan
from typing import Any

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.store.layout import FULL, MARGIN, MET
from lienumba.store.names import OUTCOME, SOME, SUMMARY, Name, Names, by_variable, dims_of, hint, known, match, names_of
from lienumba.store.windows import windows
from lienumba.words import Written, listed, option, plural, settings, show

PEAKS, WHEN = ("_max", "_min"), "_time_of_max"
FEW = 4  # names that are told


@dataclass(frozen=True)
class SelectedRun:
    """A run, and the sentence that says why it is this one, if it was not named; why: the same in a few words."""

    run: int
    sentence: str = ""
    why: str = ""


@dataclass(frozen=True)
class Peak:
    """The largest absolute value of a number, and the labels of its place."""

    size: float
    place: dict[str, Any]
    variable: str
    units: str


def select_run(ds: "xr.Dataset", where: str, run: int | None, name: str | None) -> SelectedRun:
    """The run that is asked for: by its label, or as the worst in a variable."""
    if run is not None and name is not None:
        raise ScenarioError(f"{_label()} names a run, and {_name()} chooses one; give one of them")
    if run is not None:
        check_run(ds, where, run)
        return SelectedRun(run)
    labels = ds["run"].values
    if name is not None:
        check_run(ds, where, int(labels[0]))
        return worst(ds, name)
    failed = labels[~ds["status"].isin(GOOD).values.reshape(len(labels), -1).all(axis=1)]
    first = f"{len(failed):,} of {len(labels):,} failed, the first is {option('run', failed[0])}" if len(failed) else ""
    raise ScenarioError(
        f"{where}: which run? Give {_label()}, or {_name()}, such as {option('worst', 'max_energy_drift')}"
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
            f"({settings()}) and without [study], and replay a run of that"
        )
    labels = ds["run"].values
    if run not in labels:
        raise ScenarioError(
            f"{where}: has no run {run}, but {len(labels):,} with labels from {labels.min()} to {labels.max()}; give "
            "one of them"
        )


def _label() -> str:
    return option("run", Written("N"))


def _name() -> str:
    return option("worst", Written("NAME"))


def worst(ds: "xr.Dataset", name: str) -> SelectedRun:
    """The run in which the largest absolute value of a number occurs, of all that have one, failed ones too; but what
    requirements judge is worst where it misses one of them by most, or comes nearest to that."""
    every = known(ds)
    found = match(name, every)
    if judges := _judges(name, found, every):
        return _missing(ds, judges, name)
    names = _where(name, found, every)
    peak = max((found for own in by_variable(names).values() for found in _peaks(ds, own)), key=lambda x: x.size)
    if peak.size < 0.0:
        raise ScenarioError(
            f"{option('worst', name)}: no run has a value of it; choose another variable, or a run with {_label()}"
        )
    dim = str(ds[names[0].variable].dims[0])
    time = _time(ds, peak)
    rest = [str(label) for key, label in peak.place.items() if key not in (dim, "time")]
    number = plural(ds.sizes[dim], "run", "runs") + (" whose course is stored" if dim == FULL else "")
    run = int(peak.place[dim])
    return SelectedRun(
        run,
        f"run {run} has the largest |{name}| of {number}: {_amount(peak.size, peak.units)}"
        + (f" ({', '.join(rest)})" if rest else "")
        + ("" if isnan(time) else f", at t = {time:g} s"),
        f"largest |{name}|",
    )


def _judges(asked: str, found: list[Name], every: Names) -> list[int]:
    """The places of the requirements that say of what is asked for what is bad: that of which it is the name, the
    margin or the verdict, or all those whose value it is."""
    if asked in every.requirements:
        return [every.requirements.index(asked)]
    if found and found[0].variable in (MARGIN, MET):
        if len(found) > 1:
            remedy = f"give one, such as {found[0].name}"
            raise ScenarioError(f"{option('worst', asked)}: is of {len(found)} requirements; {remedy}")
        return [*found[0].place]
    if len(found) != 1:
        return []
    return [n for n, x in enumerate(every.requirements) if match(every.value_of(x), every) == found]


def _missing(ds: "xr.Dataset", judges: list[int], name: str) -> SelectedRun:
    """The run with the least margin of these requirements, which are about the same number."""
    margins = ds[MARGIN].isel(requirement=judges).values.astype(float)
    if np.isnan(margins).all():
        raise ScenarioError(f"{option('worst', name)}: no run has a margin of it; choose a run with {_label()}")
    row, column = np.unravel_index(int(np.nanargmin(margins)), margins.shape)
    least, run, which = float(margins[row, column]), int(ds["run"].values[row]), judges[int(column)]
    (units,) = (x.units for x in names_of(ds[MARGIN]) if x.place == (which,))
    asked, number = show(str(ds["requirement"].values[which])), plural(len(margins), "run", "runs")
    if least > 0.0:
        why = f"comes nearest to missing {asked}"
        return SelectedRun(run, f"run {run} of {number} {why}: its margin is {_amount(least, units)}", why)
    why = f"misses {asked} by most"
    return SelectedRun(run, f"run {run} of {number} {why}: by {_amount(-least, units)}", why)


def _amount(x: float, units: str) -> str:
    return f"{x:.6g}" + ("" if units == "1" else f" {units}")


def _where(asked: str, found: list[Name], every: Names) -> list[Name]:
    """Where the largest value of what is asked for is: its course in every run, its extremes, or its course in some
    runs."""
    if found and found[0].kind == OUTCOME:
        raise ScenarioError(
            f"{option('worst', asked)}: says how a run ended, not how large something is; choose with {_label()}"
        )
    extremes = {end: match(asked, _extremes(every, end)) for end in PEAKS if not found or found[0].kind == SOME}
    names = [x for own in extremes.values() for x in own] or found
    if not names:
        raise ScenarioError(f"{option('worst', asked)}: {every.whose} has no such variable; {hint(asked, every)}")
    of = {x.variable.removesuffix(end) for end, own in extremes.items() for x in own} or {x.variable for x in found}
    if len(of) > 1:
        told = listed((show(x) for x in sorted(of)[:FEW]), "or")
        raise ScenarioError(f"{option('worst', asked)}: is of {len(of)} things that cannot be compared; give {told}")
    return names


def _extremes(every: Names, end: str) -> Names:
    """Largest or smallest values by the names of what they are of."""
    found = {}
    for x in every.every.values():
        if x.kind == SUMMARY and x.variable.endswith(end) and not x.variable.endswith(WHEN):
            found[x.variable.removesuffix(end) + x.name.removeprefix(x.variable)] = x
    return Names(found)


def _peaks(ds: "xr.Dataset", names: list[Name]) -> Iterator[Peak]:
    """That of each window of runs; below 0 where all are NaN. names: of one variable; of equals the first."""
    variable, by_place = names[0].variable, {x.place: x for x in names}
    dims = [str(dim) for dim in ds[variable].dims]
    own = dims_of(ds[variable])
    first = len(dims) - len(own)
    wanted = np.zeros([ds.sizes[dim] for dim in own], bool)
    wanted[tuple(np.transpose([x.place for x in names]))] = True
    for window in windows(ds, [variable], dims[0]):
        sizes = abs(window[variable].values.astype(float))
        sizes[np.isnan(sizes)] = -1.0
        sizes = np.where(wanted, sizes, -1.0)
        place = np.unravel_index(int(sizes.argmax()), sizes.shape)
        labels = {dim: window[dim].values[n] if dim in window.coords else n for dim, n in zip(dims, place, strict=True)}
        units = by_place.get(tuple(map(int, place[first:])), names[0]).units
        yield Peak(float(sizes[place]), labels, variable, units)


def _time(ds: "xr.Dataset", peak: Peak) -> float:
    """When it was (s); NaN if that is not known."""
    if "time" in peak.place:
        return float(peak.place["time"])
    times = peak.variable.removesuffix(PEAKS[0]) + WHEN
    return float(ds[times].sel(peak.place)) if times in ds else nan
