"""Outputs of a sweep: one number per run each, by names such as `position.top.z`, `pointing.angle`, `event_time.far`.

A variable of the dataset has an output for each of its labels; of a series in time, the value at one stored time
counts. The pseudo-output `failed` is 1 for a run that failed and 0 for a good one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.store.layout import FAILED, FULL, MET, VARIABLES
from lienumba.store.names import (
    COURSE,
    DERIVATIVE,
    INPUT,
    LAST,
    OUTCOME,
    OVER_TIME,
    SOME,
    STATUS,
    Name,
    Names,
    by_variable,
    dims_of,
    find,
    known,
)

MOST = 6  # outputs that are chosen where none is asked for
NEAR = 1e-9  # relative: a time nearer than this to a stored one is that


@dataclass(frozen=True)
class Output:
    """values (runs,): NaN where a run has none; time (s): of a series; scale: the largest value of its variable; of:
    which number of the dataset it is."""

    name: str
    units: str
    long_name: str
    values: np.ndarray
    time: float = nan
    scale: float = 1.0
    of: Name | None = None


def read(ds: xr.Dataset, names: Sequence[str], time: float | None, sampled: np.ndarray) -> Iterator[Output]:
    """The outputs of these names, or those that say most, over the sampled runs; time (s): a stored one, or the last.

    sampled: bool (runs,).
    """
    every = known(ds)
    good = ds[STATUS].isin(GOOD).values & sampled
    asked = [found for name in names for found in _find(name, every)]
    if not names:
        asked = _default_outputs(every, time)[:MOST]
        failed = every.every[FAILED]
        asked += [failed] if time is None and good.any() and not good[sampled].all() and failed.kind == OUTCOME else []
    for variable, wanted in by_variable(asked).items():
        if variable == STATUS:
            if time is not None:
                raise _timeless(FAILED, time)
            yield Output(FAILED, "1", "whether the run failed", np.where(sampled, (~good).astype(float), nan))
        else:
            kept = sampled if variable == MET else good  # failed runs may fail requirements
            yield from _of_variable(ds, wanted, time, kept)


def of_every_run(ds: xr.Dataset, names: Sequence[str], time: float | None) -> Iterator[Output]:
    """The outputs of these names, or all that a run has once, of all runs, however they ended; time (s): a stored one,
    or the last, of series."""
    every = known(ds)
    once = [x for x in every.every.values() if x.kind not in (*OVER_TIME, INPUT, OUTCOME, DERIVATIVE)]
    everywhere = np.ones(ds.sizes["run"], bool)
    for variable, wanted in by_variable([found for name in names for found in _find(name, every)] or once).items():
        if variable == STATUS:
            failed = (~ds[STATUS].isin(GOOD).values).astype(float)
            yield Output(FAILED, "1", "whether the run failed", failed)
        else:
            yield from _of_variable(ds, wanted, time if wanted[0].kind in OVER_TIME else None, everywhere)


def _timeless(name: str, time: float) -> ScenarioError:
    return ScenarioError(f"time = {time:g}: has no meaning for {name}, which each run has once; leave it out")


def default_outputs(ds: xr.Dataset) -> list[str]:
    """The names of the outputs that say most, those that say it first."""
    return [x.name for x in _default_outputs(known(ds), None)]


def _find(asked: str, every: Names) -> list[Name]:
    """The outputs of this name."""
    if asked == STATUS:
        raise ScenarioError(f'the output "{STATUS}" is a code, not a number; ask for "{FAILED}"')
    return find(asked, every)


def _default_outputs(every: Names, time: float | None) -> list[Name]:
    """The scenario's own outputs, those that each run has once first; else where the last body ended."""
    names = [x for x in every.but(INPUT, OUTCOME, SOME, DERIVATIVE).every.values() if time is None or x.kind == COURSE]
    own = [x for x in names if x.variable.removeprefix(LAST) not in VARIABLES or x.variable == "event_time"]
    own.sort(key=lambda x: (x.kind == COURSE, x.variable in VARIABLES))
    if not own:
        there = {x.variable for x in names}
        where = [name for name in (f"{LAST}position", "position") if name in there]
        own = [x for x in names if x.variable == (where or [names[0].variable])[0]][-3:] if names else []
    if not own:
        raise ScenarioError("the dataset has no variable of runs to analyse; store one, such as a quantity")
    return own


def _stored(variable: xr.DataArray, time: float | None) -> int:
    """The index of a stored time."""
    times = variable["time"].values
    if time is None:
        return len(times) - 1
    index = int(abs(times - time).argmin())
    if abs(times[index] - time) <= NEAR * max(abs(time), 1.0):
        return index
    if times[0] < time < times[-1]:
        raise ScenarioError(f"time = {time:g}: is not stored; the nearest stored time is {times[index]:g} s")
    raise ScenarioError(
        f"time = {time:g}: lies outside the stored times; give one from {times[0]:g} to {times[-1]:g} s"
    )


def _of_variable(ds: xr.Dataset, wanted: Sequence[Name], time: float | None, kept: np.ndarray) -> Iterator[Output]:
    """These numbers of one variable, NaN of runs that are not kept and of those whose course is not stored; only what
    they need of it is read."""
    variable = ds[wanted[0].variable]
    in_time = "time" in variable.dims
    if time is not None and not in_time:
        raise _timeless(str(variable.name), time)
    at = _stored(variable, time) if in_time else 0
    when = float(variable["time"].values[at]) if in_time else nan
    here, dims = variable.isel(time=at) if in_time else variable, dims_of(variable)
    needed = [sorted({x.place[k] for x in wanted}) for k in range(len(dims))]
    part = here.isel({dim: slice(x[0], x[-1] + 1) for dim, x in zip(dims, needed, strict=True)})
    values = part.transpose(FULL if FULL in part.dims else "run", ...).values
    if FULL in part.dims:
        _, own, there = np.intersect1d(ds["run"].values, ds[FULL].values, return_indices=True)
        some, values = values, np.full((len(kept), *values.shape[1:]), nan)
        values[own] = some[there]
    if not kept.all():
        values = np.where(kept.reshape(-1, *(1 for _ in needed)), values, nan)
    scale = float(np.nanmax(abs(values), initial=0.0))
    long_name = str(variable.attrs.get("long_name", ""))
    for one in wanted:
        place: tuple[Any, ...] = (..., *(n - x[0] for n, x in zip(one.place, needed, strict=True)))
        yield Output(one.name, one.units, long_name, values[place], when, scale, one)
