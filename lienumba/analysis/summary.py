"""A sweep in a few numbers: how the runs ended, where they ended, and how well the constraints held."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lienumba.batch.statuses import GOOD, SUCCESS
from lienumba.store.layout import VARIABLES

if TYPE_CHECKING:
    import xarray as xr

QUANTILES = (0.05, 0.5, 0.95)
FINAL = ("position", "velocity", "angular_velocity", "energy")
LABELS_SHOWN = 5


@dataclass(frozen=True)
class Outcome:
    """The runs that ended in one way: how many, the first labels, and the times (s) that these reached."""

    status: str
    count: int
    labels: tuple[int, ...]
    end_times: tuple[float, ...]


@dataclass(frozen=True)
class Quantiles:
    """5, 50 and 95 % quantiles of one number at the final time, over the good runs; body "": the system."""

    quantity: str
    body: str
    axis: str
    units: str
    low: float
    median: float
    high: float


@dataclass(frozen=True)
class Summary:
    """`good` runs are those that reached the end or were stopped by an event; maxima are over these, None where the
    dataset has none; `final` quantiles over those that reached the end.

    not_unique: the joints and drivers whose reactions are not. The relative energy drift of a run is its largest
    energy residual over its largest kinetic energy.
    """

    title: str
    runs: int
    good: int
    final_time: float
    outcomes: tuple[Outcome, ...]
    final: tuple[Quantiles, ...]
    max_position_violation: float | None
    max_velocity_violation: float | None
    max_energy_drift: float | None
    max_relative_energy_drift: float | None
    not_unique: str = ""


def summarise(ds: xr.Dataset) -> Summary:
    """Summarise a dataset that `lienumba run` made, or a selection of its runs."""
    import numpy as np

    status = ds["status"].values
    good = ds.isel(run=np.isin(status, GOOD).nonzero()[0])
    finished = ds.isel(run=(status == SUCCESS).nonzero()[0])
    return Summary(
        title=str(ds.attrs.get("title", "")),
        runs=ds.sizes["run"],
        good=good.sizes["run"],
        final_time=float(ds["time"].values[-1]),
        outcomes=_outcomes(ds),
        final=tuple(row for name in _shown(ds) if finished.sizes["run"] for row in _final(finished[name])),
        max_position_violation=_maximum(good, "max_position_violation"),
        max_velocity_violation=_maximum(good, "max_velocity_violation"),
        max_energy_drift=_maximum(good, "max_energy_drift"),
        max_relative_energy_drift=_relative_drift(good),
        not_unique=str(ds["multiplier"].attrs.get("not_unique", "")) if "multiplier" in ds else "",
    )


def _shown(ds: xr.Dataset) -> list[str]:
    """The variables whose final values are told: the scenario's own first."""
    own = [str(name) for name in ds.data_vars if name not in VARIABLES and "time" in ds[name].dims]
    return own + [name for name in FINAL if name in ds]


def _outcomes(ds: xr.Dataset) -> tuple[Outcome, ...]:
    """One entry for each status that occurs, success first, then the most frequent failures."""
    status = ds["status"]
    names = dict(zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True))
    outcomes = []
    for code in {int(code) for code in status.values}:
        runs = (status.values == code).nonzero()[0]
        shown = runs[:LABELS_SHOWN]
        labels = tuple(int(label) for label in ds["run"].values[shown])
        end_times = tuple(float(time) for time in ds["end_time"].values[shown]) if "end_time" in ds else ()
        outcomes.append((code != 0, -len(runs), code, Outcome(names[code], len(runs), labels, end_times)))
    return tuple(outcome for *_, outcome in sorted(outcomes, key=lambda entry: entry[:3]))


def _final(variable: xr.DataArray) -> list[Quantiles]:
    import numpy as np

    last = variable.isel(time=-1)
    values = np.quantile(last.values, QUANTILES, axis=0)  # (3, body, axis), or (3,) for the whole system
    bodies = [str(name) for name in last["body"].values] if "body" in last.dims else [""]
    axes = [str(name) for name in last["axis"].values] if "axis" in last.dims else [""]
    rows = values.reshape(len(QUANTILES), -1).T
    places = [(body, axis) for body in bodies for axis in axes]
    units = str(variable.attrs.get("units", ""))
    return [
        Quantiles(str(variable.name), body, axis, units, *(float(value) for value in row))
        for (body, axis), row in zip(places, rows, strict=True)
    ]


def _maximum(good: xr.Dataset, name: str) -> float | None:
    if name not in good or not good.sizes["run"]:
        return None
    return float(good[name].values.max())


def _relative_drift(good: xr.Dataset) -> float | None:
    import numpy as np

    if "energy_residual" not in good or "kinetic_energy" not in good or not good.sizes["run"]:
        return None
    residual, kinetic = (good[name].values for name in ("energy_residual", "kinetic_energy"))
    residual, kinetic = np.nanmax(abs(residual), axis=1), np.nanmax(kinetic, axis=1)  # NaN behind an event
    drifts = [r / k if k > 0.0 else math.nan if r > 0.0 else 0.0 for r, k in zip(residual, kinetic, strict=True)]
    return float(max(drifts))
