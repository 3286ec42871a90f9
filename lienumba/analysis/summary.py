"""A sweep in a few numbers: how the runs ended, where they ended, and how well the constraints held."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import xarray as xr

from lienumba.analysis.changed import Changed, changed, tells, told
from lienumba.analysis.outcomes import Outcome, of_sweep, outcomes
from lienumba.analysis.weights import kept_of, weights_of, weights_told
from lienumba.batch.statuses import GOOD, SUCCESS
from lienumba.errors import ScenarioError
from lienumba.integrators.codes import UNSTABLE
from lienumba.mechanics.system.joint_coordinates import UNITS
from lienumba.store.form import SHORT_STEPS
from lienumba.store.layout import RELATIVE_DRIFT, RUN, VARIABLES, warnings_in
from lienumba.store.names import BY, FLAGS, RATE, SHOW
from lienumba.store.study_layout import is_study
from lienumba.sweep.weighted import quantiles
from lienumba.words import listed, plural

QUANTILES = (0.05, 0.5, 0.95)
FINAL = ("position", "velocity", "angular_velocity", "energy")
AXES = ("axis", "body_axis")
LAW_STATE = "state of the law"  # how the long names of states of laws begin
FEW, TIMES = 64, 100  # runs and stored times that tell of which size a variable is on the way


@dataclass(frozen=True)
class Quantiles:
    """5, 50 and 95 % quantiles of one number of each run; body: to what it belongs, "" for the system; scale: the
    largest magnitude of the variable in all its components, at the start, too; kind: the dimension along which what it
    belongs to lies."""

    quantity: str
    body: str
    axis: str
    units: str
    low: float
    median: float
    high: float
    scale: float = 0.0
    kind: str = "body"


@dataclass(frozen=True)
class Happened:
    """Quantiles of the time (s) at which something first happened in a run, over the runs in which it did, which are so
    many."""

    name: str
    runs: int
    low: float
    median: float
    high: float


@dataclass(frozen=True, repr=False)
class Summary:
    """`good` runs are those that reached the end or were stopped by an event; maxima are over these, None where the
    dataset has none or nothing was measured; `final`: quantiles at the final time over those that reached the end,
    `finished` runs; `ended`: those of the last states of the good ones that did not; `kept`: those of summaries, over
    the good ones, which are `spread` runs; `events`, `changes`: when each first happened, and what changed, in these.
    The nominal run is no part of quantiles, unless it is the only one.

    unknown: of which summaries runs have no number; stopped: what made the sweep end before all its runs were done;
    short_steps: why a tolerance may have made steps short; unstable: that runs start in equilibria that they leave;
    warnings: good runs that are not accurate; shown: whether the scenario chose what is shown; weights: what those of
    the runs mean; not_unique: the joints and drivers whose reactions are not. The relative energy drift of a run is its
    largest energy residual over the energy that was exchanged, the range of its kinetic energy.
    """

    title: str
    runs: int
    good: int
    spread: int
    finished: int
    final_time: float
    outcomes: tuple[Outcome, ...]
    final: tuple[Quantiles, ...]
    kept: tuple[Quantiles, ...]
    max_position_violation: float | None
    max_velocity_violation: float | None
    max_energy_drift: float | None
    max_relative_energy_drift: float | None
    not_unique: str = ""
    unknown: str = ""
    stopped: str = ""
    short_steps: str = ""
    unstable: str = ""
    warnings: tuple[str, ...] = ()
    shown: bool = False
    weights: str = ""
    ended: tuple[Quantiles, ...] = ()
    events: tuple[Happened, ...] = ()
    changes: tuple[Changed, ...] = ()
    changes_told: str = ""

    def __repr__(self) -> str:
        from lienumba.analysis.summary_text import text

        return text(self)


def summarise(ds: xr.Dataset) -> Summary:
    """Summarise a dataset, or a selection of its runs; it may be larger than the memory.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned of a sweep.

    Returns
    -------
    Summary
        How the runs ended, where, and how well the constraints held. Printed, or at the end of a cell, it shows itself.

    Raises
    ------
    ScenarioError
        Where the dataset has no runs, or is of a study.
    """
    if is_study(ds):
        raise ScenarioError("the dataset is of a study, which lienumba.analysis.orders sums up; give one of a sweep")

    status = ds["status"].values
    good, finished = np.isin(status, GOOD), status == SUCCESS
    sampled, weights, kept_runs = of_sweep(ds), weights_of(ds), kept_of(ds)
    as_varied = sampled if kept_runs is None else sampled & kept_runs
    final, time = _final_variables(ds, finished)
    kept = [x for x in ds.data_vars.values() if x.dims[:1] == RUN and x.name not in VARIABLES and "time" not in x.dims]
    kept = [x for x in kept if BY not in x.dims and x.name not in (RATE, FLAGS)]
    shown = shown_in(ds)
    if shown:
        kept = [x for x in kept if owner_in(str(x.name), shown) or owner_in(str(x.name).rpartition("_")[0], shown)]
    return Summary(
        title=str(ds.attrs.get("title", "")),
        weights="" if weights is None else weights_told(weights[sampled]),
        unknown=_unknown(kept, good & sampled),
        stopped=str(ds.attrs.get("stopped", "")),
        short_steps=" ".join(str(ds.attrs[name]) for name in SHORT_STEPS if name in ds.attrs),
        unstable=_unstable(ds),
        warnings=tuple(warnings_in(ds)),
        shown=bool(shown),
        runs=len(status),
        good=int(good.sum()),
        spread=int((good & sampled).sum()),
        finished=int((finished & sampled).sum()),
        final_time=time,
        outcomes=outcomes(ds),
        final=tuple(
            row
            for name, x in final
            for row in _quantiles(name, x, finished & sampled, weights, _on_the_way(ds, name, finished & sampled))
        ),
        kept=tuple(row for x in kept for row in _quantiles(str(x.name), x, good & sampled, weights)),
        ended=tuple(_ended(ds, good & ~finished & sampled)),
        events=tuple(_happened(ds, good & sampled)),
        changes=tuple(changed(ds, good & as_varied)) if tells(ds) else (),
        changes_told=told(ds, good & as_varied) if tells(ds) else "",
        max_position_violation=_maximum(ds, "max_position_violation", good),
        max_velocity_violation=_maximum(ds, "max_velocity_violation", good),
        max_energy_drift=_maximum(ds, "max_energy_drift", good),
        max_relative_energy_drift=_maximum(ds, RELATIVE_DRIFT, good),
        not_unique=next((str(x.attrs["not_unique"]) for x in ds.data_vars.values() if "not_unique" in x.attrs), ""),
    )


def shown_in(ds: xr.Dataset) -> list[str]:
    """The names of `output.show`; none where all is shown."""
    return [name for name in str(ds.attrs.get(SHOW, "")).split(", ") if name]


def owner_in(name: str, shown: Collection[str]) -> str:
    """The name that is shown of which a variable is, or is a part ("tip" of "tip.z"); empty if there is none."""
    return next((x for x in shown if name == x or name.startswith(f"{x}.")), "")


def _unstable(ds: xr.Dataset) -> str:
    """That runs start where they rest, but not for long; empty where none does."""
    if "start_equilibrium" not in ds:
        return ""
    count, runs = int((ds["start_equilibrium"].values == UNSTABLE).sum()), ds.sizes["run"]
    if not count:
        return ""
    who = "the run starts" if runs == 1 else f"{count:,} of {runs:,} runs start"
    return f"{who} in an equilibrium that is unstable: what disturbs it least, be it rounding, grows"


def _unknown(kept: Sequence[xr.DataArray], which: np.ndarray) -> str:
    """In how many of these runs variables have no number; empty where all have."""
    runs = int(which.sum())
    missing = {
        str(x.name): np.isnan(x.values[which]).any(axis=tuple(range(1, x.ndim))).sum()
        for x in kept
        if x.dtype.kind == "f"
    }
    told = [f"{name} in {count:,}" for name, count in missing.items() if count]
    if not told:
        return ""
    return f"without a number, of {plural(runs, 'run', 'runs')}: {listed(told)} (undefined, or it never came to that)"


def _final_variables(ds: xr.Dataset, finished: np.ndarray) -> tuple[list[tuple[str, xr.DataArray]], float]:
    """The variables whose final values are told, the scenario's own first, by name, and at what time (s). Last states,
    which each run has one of, say it where runs that finished ended at that time, and where courses are not stored."""
    ends = ds["end_time"].values[finished] if "end_time" in ds else ()
    timed = [str(name) for name, x in ds.data_vars.items() if x.dims[:1] == RUN and "time" in x.dims]
    time = float(ds["time"].values[-1]) if timed else float(max(ends, default=0.0))
    shown = shown_in(ds)
    own = [name for name in timed if name not in VARIABLES]
    own.sort(key=lambda name: str(ds[name].attrs.get("long_name", "")).startswith(LAW_STATE))  # those of laws are last
    asked = [name for name in shown or FINAL if name in timed or not timed]
    last = {name: f"last_{name}" for name in asked if f"last_{name}" in ds and all(end == time for end in ends)}
    names = [name for name in dict.fromkeys((*own, *asked)) if name in last or name in timed]
    if shown:
        places = {name: n for n, name in enumerate(shown)}
        names = sorted((x for x in names if owner_in(x, places)), key=lambda x: places[owner_in(x, places)])
    return [(name, ds[last[name]] if name in last else ds[name].isel(time=-1)) for name in names], time


def _ended(ds: xr.Dataset, which: np.ndarray) -> Iterator[Quantiles]:
    """Of the last states of these runs, and of when they ended."""
    if which.any():
        weights = weights_of(ds)
        yield from _quantiles("end_time", ds["end_time"], which, weights)
        for name in (name for name in FINAL if f"last_{name}" in ds):
            yield from _quantiles(name, ds[f"last_{name}"], which, weights)


def _happened(ds: xr.Dataset, which: np.ndarray) -> Iterator[Happened]:
    """When each event first happened in these runs, if it did in any."""
    weights = weights_of(ds)
    for name, times in zip(ds["event"].values, ds["event_time"].values.T, strict=True) if "event_time" in ds else ():
        did = which & ~np.isnan(times)
        if did.any():
            yield Happened(str(name), int(did.sum()), *_of(times[did], None if weights is None else weights[did]))


def _on_the_way(ds: xr.Dataset, name: str, which: np.ndarray) -> float:
    """The largest number of a variable at some stored times, of the first of these runs."""
    if name not in ds or "time" not in ds[name].dims or ds[name].dims[:1] != RUN:
        return 0.0
    apart = -(-ds.sizes["time"] // TIMES)
    return _size(ds[name].isel(run=np.flatnonzero(which)[:FEW], time=slice(0, None, apart)).values)


def _size(values: np.ndarray) -> float:
    """The largest magnitude; NaN counts for nothing."""
    return float(np.fmax.reduce(abs(values).ravel(), initial=0.0))


def _of(values: np.ndarray, weights: np.ndarray | None) -> list[float]:
    """The quantiles of values (n,)."""
    known = weights is not None and weights.any()
    return list(map(float, quantiles(values, weights if known else None, QUANTILES)))


def _quantiles(
    name: str, variable: xr.DataArray, which: np.ndarray, weights: np.ndarray | None, least: float = 0.0
) -> Iterator[Quantiles]:
    """Of each number that every run has of a variable (runs, ...), over these runs; NaN is left out. least: what the
    scale of the variable is at least."""
    if not which.any():
        return
    scale = max(_size(variable.values[which]), least)
    columns, dims = variable.values[which].reshape(which.sum(), -1).T, variable.dims[1:]
    places = product(*(map(str, variable[dim].values) for dim in dims))
    kind = " ".join(str(dim) for dim in dims if dim not in AXES)
    own = None if weights is None else weights[which]
    for column, place in zip(columns, places, strict=True):
        known = ~np.isnan(column)
        if known.any():
            body = " ".join(x for dim, x in zip(dims, place, strict=True) if dim not in AXES)
            axis = "".join(x for dim, x in zip(dims, place, strict=True) if dim in AXES)
            low, median, high = _of(column[known], None if own is None else own[known])
            yield Quantiles(name, body, axis, _units(variable, body), low, median, high, scale, kind)


def _units(variable: xr.DataArray, label: str) -> str:
    """The unit of a variable; of coordinates of joints each has its own."""
    if "coordinate_units" in variable.coords and variable.name in UNITS:
        own = variable["coordinate_units"].values[variable["coordinate"].values.tolist().index(label)]
        return UNITS[str(variable.name)][str(own)]
    return str(variable.attrs.get("units", ""))


def _maximum(ds: xr.Dataset, name: str, good: np.ndarray) -> float | None:
    """The largest of the good runs; None where it is 0 because these ended before anything was stored."""
    if name not in ds or not good.any():
        return None
    largest = float(ds[name].values[good].max())
    return largest if largest or _reached_a_stored_time(ds, good) else None


def _reached_a_stored_time(ds: xr.Dataset, which: np.ndarray) -> bool:
    """Whether any of these runs did, as far as the dataset has times."""
    if "time" not in ds or "end_time" not in ds or not ds["time"].size:
        return True
    return bool((ds["end_time"].values[which] >= ds["time"].values.min()).any())
