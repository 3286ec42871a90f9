"""The numbers of a panel: time series of runs with quantiles over them, and histograms of what each run has once.

Failed runs are part of what was sampled, and of nothing else; a run that an event ended is, up to there. The nominal
run is told apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.analysis.outcomes import of_sweep
from lienumba.analysis.panels import attitude, run_windows
from lienumba.analysis.panels.select_panels import FEW, Panel
from lienumba.batch.statuses import GOOD, STATUSES

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
MOST_PEAKS = 120  # times at which violations are shown
SAMPLES = 3  # runs that are kept beside the quantiles
THIN = 0.01  # half the width of the bar of a constant, relative
FEWEST_BINS, MOST_BINS = 5, 60
WIDE = 30.0  # the largest by the median of positive numbers that only a logarithmic axis shows
ROUNDING = 1e-12  # relative: numbers nearer than this are the same


@dataclass(frozen=True)
class TimeSeries:
    """One line of a panel over the time. quantiles (5, times): at LEVELS over the runs that have a value; largest
    (times,): of these; nominal (times,): the nominal run, None if there is none; each: series (times,) by label, of
    all runs where they are few, else of some; left: those of the runs that go on where few have a value."""

    label: str
    quantiles: np.ndarray
    largest: np.ndarray
    nominal: np.ndarray | None
    each: dict[int, np.ndarray]
    left: dict[int, np.ndarray]


@dataclass(frozen=True)
class PanelSeries:
    """times (s); runs: how many are shown; survivors (times,): how many of them have a value; lines: one for each line
    of the panel."""

    times: np.ndarray
    runs: int
    survivors: np.ndarray
    lines: list[TimeSeries]

    @property
    def few(self) -> bool:
        """Whether the runs are too few for quantiles, so that each stands for itself."""
        return self.runs <= FEW

    @property
    def enough(self) -> np.ndarray:
        """The times (times,) at which enough runs have a value for quantiles."""
        found: np.ndarray = self.survivors > FEW
        return found


@dataclass(frozen=True)
class Histogram:
    """One line of a panel without times. values: of the runs that have one; missing: how many have none; nominal: that
    of the nominal run, None if there is none; failed: those of the values that are of failed runs, None if none is."""

    label: str
    values: np.ndarray
    missing: int
    nominal: float | None
    failed: np.ndarray | None = None


def time_series(ds: xr.Dataset, panel: Panel) -> PanelSeries:
    """The time series of a panel."""
    which = run_windows.shown_runs(ds, panel)
    labels = ds[panel.dim].values
    starts = np.arange(0, ds.sizes["time"], _together(ds, panel))
    every = [_largest(x, starts) for x in run_windows.values(ds, panel, which)]
    survivors = np.max([np.isfinite(x).sum(axis=0) for x in every], axis=0)
    lines = [
        _one_line(line.label, x, labels[which], None if nominal is None else _largest(nominal, starts), survivors)
        for line, x, nominal in zip(panel.lines, every, _nominal(ds, panel), strict=True)
    ]
    return PanelSeries(ds["time"].values[starts], int(which.sum()), survivors, lines)


def _together(ds: xr.Dataset, panel: Panel) -> int:
    """How many consecutive times of a panel are shown by the largest value: what is rounding in most steps would
    cover it with ink."""
    return -(-ds.sizes["time"] // MOST_PEAKS) if panel.logarithmic else 1


def _largest(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """The largest of the values (..., times) from each start on; NaN where there is none."""
    if len(starts) == values.shape[-1]:
        return values
    found: np.ndarray = np.fmax.reduceat(values, starts, axis=-1)
    return found


def ended_early(shown: Sequence[PanelSeries]) -> str:
    """From when on quantiles are of some runs, as the series with most times tell; empty if all go on to the end."""
    fullest = max(shown, key=lambda x: (len(x.times), x.survivors.mean()), default=None)
    if fullest is None or fullest.survivors[-1] == fullest.runs:
        return ""
    first = fullest.times[(fullest.survivors < fullest.runs).argmax()]
    last = f"{fullest.survivors[-1]:,} of {fullest.runs:,} at the end"
    alone = "" if fullest.enough.all() else f", each drawn where {FEW} or fewer are left"
    return f"from {first:g} s on some runs have ended, and quantiles are of those that go on: {last}{alone}"


def histograms(ds: xr.Dataset, panel: Panel) -> list[Histogram]:
    """What each run has once of a panel, line by line; of a time series the last value."""
    which = run_windows.shown_runs(ds, panel)
    failed = np.isin(ds[panel.dim].values[which], ds["run"].values[~ds["status"].isin(GOOD).values])
    found = []
    for line, x, nominal in zip(panel.lines, run_windows.values(ds, panel, which), _nominal(ds, panel), strict=True):
        finite = np.isfinite(x[:, 0])
        own = None if nominal is None or not np.isfinite(nominal[-1]) else float(nominal[-1])
        missing = len(x) - int(finite.sum())
        found.append(Histogram(line.label, x[finite, 0], missing, own, x[finite & failed, 0] if failed.any() else None))
    return found


def statuses(ds: xr.Dataset) -> dict[str, int]:
    """How many runs of the sweep ended in each way that occurs."""
    codes = ds["status"].values[of_sweep(ds)]
    counts = {status.name: int((codes == status.code).sum()) for status in STATUSES}
    return {name: count for name, count in counts.items() if count}


def label(ds: xr.Dataset, panel: Panel) -> str:
    """What the axis of the values shows, with its unit."""
    if panel.angles:
        return f"angle of its axes\nfrom {run_windows.reference(ds, panel)} (°)"
    together = _together(ds, panel) if panel.over_time else 1
    return panel.label + (f"\nlargest of each {together} times" if together > 1 else "")


def quantiles(values: np.ndarray, levels: Sequence[float] = LEVELS) -> np.ndarray:
    """Quantiles (levels, times) of values (runs, times) at each time, over the runs that have one."""
    ordered = np.sort(values.T, axis=1)  # NaN last
    last = np.maximum(np.isfinite(ordered).sum(axis=1) - 1, 0)
    at = np.multiply.outer(np.asarray(levels), last)
    below, rows = at.astype(int), np.arange(len(ordered))
    low, high = ordered[rows, below], ordered[rows, np.minimum(below + 1, last)]
    found: np.ndarray = low + (at - below) * (high - low)
    return found


def bins(found: Sequence[Histogram]) -> np.ndarray:
    """The edges of a histogram of all of these: one thin bar of a constant; around whole numbers if they are few; of
    positive numbers of many magnitudes in equal ratios; else as many as Rice's rule says, 2 n^(1/3)."""
    every = np.concatenate([one.values for one in found])
    low, high = float(every.min()), float(every.max())
    if high - low <= ROUNDING * max(abs(low), abs(high)):
        half = THIN * (abs(low) or 1.0)
        return np.array([low - half, low + half])
    if high - low < MOST_BINS and (every == np.round(every)).all():
        return np.arange(low - 0.5, high + 1.0)
    number = int(np.clip(np.ceil(2.0 * max(len(one.values) for one in found) ** (1 / 3)), FEWEST_BINS, MOST_BINS))
    if low > 0.0 and high > WIDE * np.median(every):
        return np.geomspace(low, high, number + 1)
    return np.linspace(low, high, number + 1)


def _one_line(
    label: str, values: np.ndarray, labels: np.ndarray, nominal: np.ndarray | None, survivors: np.ndarray
) -> TimeSeries:
    """Of values (runs, times), of which so many (times,) are known."""
    kept = range(len(values)) if len(values) <= FEW else np.linspace(0, len(values) - 1, SAMPLES).astype(int)
    each = {int(labels[n]): values[n].copy() for n in kept}
    going = np.flatnonzero(np.isfinite(values[:, survivors <= FEW]).any(axis=1)) if len(values) > FEW else ()
    left = {int(labels[n]): np.where(survivors <= FEW, values[n], np.nan) for n in going[:FEW]}
    return TimeSeries(label, quantiles(values), np.fmax.reduce(values, axis=0), nominal, each, left)


def _nominal(ds: xr.Dataset, panel: Panel) -> list[np.ndarray | None]:
    """Each line of the nominal run (times,)."""
    at = run_windows.nominal_run(ds, panel)
    if at is None or (panel.angles and run_windows.reference(ds, panel) == attitude.NOMINAL):
        return [None for _ in panel.lines]
    only = np.arange(ds.sizes[panel.dim]) == at
    return [x[0] for x in run_windows.values(ds, panel, only)]
