"""Outputs of a sweep: one number per run each, by names such as `position.top.z`, `pointing.angle`, `event_time.far`.

A variable of the dataset has an output for each of its labels; of a series in time, the value at one stored time
counts. The pseudo-output `failed` is 1 for a run that failed and 0 for a good one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.store.components import components, dims_of, matching, places, unit
from lienumba.store.layout import MET, VARIABLES

FAILED = "failed"
STATUS = "status"
LAST = "last_"  # of the name of a state that each run has once
MOST = 6  # outputs that are chosen where none is asked for
NEAR = 1e-9  # relative: a time nearer than this to a stored one is that


@dataclass(frozen=True)
class Output:
    """values (runs,): NaN where a run has none; time (s): of a series; scale: the largest value of its variable."""

    name: str
    units: str
    long_name: str
    values: np.ndarray
    time: float = nan
    scale: float = 1.0


def read(ds: xr.Dataset, names: Sequence[str], time: float | None, sampled: np.ndarray) -> Iterator[Output]:
    """The outputs of these names, or those that say most, over the sampled runs; time (s): a stored one, or the last.

    sampled: bool (runs,).
    """
    good = ds[STATUS].isin(GOOD).values & sampled
    by_variable = {FAILED: [FAILED]} | _by_variable(ds)
    asked = [output for name in names for output in _matching(name, by_variable)]
    if not names:
        asked = _default_outputs(ds, by_variable, time)
        asked += [FAILED] if time is None and good.any() and not good[sampled].all() and FAILED not in ds else []
    for name, wanted in _asked(asked, by_variable):
        if name in ds:
            kept = sampled if name == MET else good  # failed runs may fail requirements
            yield from _of_variable(ds, name, by_variable[name], wanted, time, kept)
        elif time is None:
            values = np.where(sampled, (~good).astype(float), nan)
            yield Output(FAILED, "1", "whether the run failed", values)
        else:
            raise _timeless(name, time)


def of_every_run(ds: xr.Dataset, names: Sequence[str], time: float | None) -> Iterator[Output]:
    """The outputs of these names, or all that a run has once, of all runs, however they ended; time (s): a stored one,
    or the last, of series."""
    by_variable = _by_variable(ds)
    once = [output for name, each in by_variable.items() if "time" not in ds[name].dims for output in each]
    asked = [output for name in names for output in _matching(name, by_variable)] or once
    for name, wanted in _asked(asked, by_variable):
        at = time if "time" in ds[name].dims else None
        yield from _of_variable(ds, name, by_variable[name], wanted, at, np.ones(ds.sizes["run"], bool))


def _by_variable(ds: xr.Dataset) -> dict[str, list[str]]:
    return {str(name): components(x) for name, x in ds.data_vars.items() if _is_output(x)}


def _asked(outputs: Iterable[str], by_variable: dict[str, list[str]]) -> Iterator[tuple[str, list[str]]]:
    """Outputs by their variables, in the order of the first of each."""
    found: dict[str, list[str]] = {}
    for output in dict.fromkeys(outputs):
        found.setdefault(_variable_of(output, by_variable), []).append(output)
    yield from found.items()


def _of_variable(
    ds: xr.Dataset, name: str, names: list[str], wanted: Iterable[str], time: float | None, kept: np.ndarray
) -> Iterator[Output]:
    """Outputs of a variable, NaN of runs that are not kept."""
    in_time = "time" in ds[name].dims
    if time is not None and not in_time:
        raise _timeless(name, time)
    yield from _read(ds[name], names, wanted, _stored(ds, time) if in_time else 0, kept)


def _timeless(name: str, time: float) -> ScenarioError:
    return ScenarioError(f"time = {time:g}: has no meaning for {name}, which each run has once; leave it out")


def default_outputs(ds: xr.Dataset) -> list[str]:
    """The names of the outputs that say most."""
    return _default_outputs(ds, _by_variable(ds), None)


def _is_output(variable: xr.DataArray) -> bool:
    return variable.name != STATUS and "run" in variable.dims and variable.dtype.kind in "biuf"


def _variable_of(output: str, by_variable: dict[str, list[str]]) -> str:
    return next(name for name, components in by_variable.items() if output in components)


def _matching(asked: str, by_variable: dict[str, list[str]]) -> list[str]:
    """The outputs of this name."""
    if asked == STATUS:
        raise ScenarioError(f'the output "{STATUS}" is a code, not a number; ask for "{FAILED}"')
    return matching(asked, by_variable, "output")


def _default_outputs(ds: xr.Dataset, by_variable: dict[str, list[str]], time: float | None) -> list[str]:
    """The scenario's own outputs, those that each run has once first; else where the last body ended."""
    names = [name for name in by_variable if name in ds and (time is None or "time" in ds[name].dims)]
    own = [name for name in names if name.removeprefix(LAST) not in VARIABLES or name == "event_time"]
    own.sort(key=lambda name: ("time" in ds[name].dims, name in VARIABLES))
    outputs = [output for name in own for output in by_variable[name]]
    if not outputs:
        where = [name for name in (f"{LAST}position", "position") if name in names] or names
        outputs = by_variable[where[0]][-3:] if where else []
    if not outputs:
        raise ScenarioError("the dataset has no variable of runs to analyse; store one, such as a quantity")
    return outputs[:MOST]


def _stored(ds: xr.Dataset, time: float | None) -> int:
    """The index of a stored time."""
    times = ds["time"].values
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


def _read(
    variable: xr.DataArray, names: list[str], wanted: Iterable[str], at: int, good: np.ndarray
) -> Iterator[Output]:
    """These components of a variable; only what they need of it is read."""
    time = float(variable["time"].values[at]) if "time" in variable.dims else nan
    here = variable.isel(time=at) if "time" in variable.dims else variable
    at_place = dict(zip(names, places(variable), strict=True))
    needed = [sorted({at_place[name][k] for name in wanted}) for k in range(len(dims_of(variable)))]
    part = here.isel({dim: slice(x[0], x[-1] + 1) for dim, x in zip(dims_of(variable), needed, strict=True)})
    values = part.transpose("run", ...).values
    if not good.all():
        values = np.where(good.reshape(-1, *(1 for _ in needed)), values, nan)
    scale = float(np.nanmax(abs(values), initial=0.0))
    long_name = str(variable.attrs.get("long_name", ""))
    for name in wanted:
        place: tuple[Any, ...] = (..., *(n - x[0] for n, x in zip(at_place[name], needed, strict=True)))
        yield Output(name, unit(variable, at_place[name]), long_name, values[place], time, scale)
