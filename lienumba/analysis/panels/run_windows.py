"""The values of the lines of a panel, read by windows of runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from lienumba.analysis.outcomes import of_sweep
from lienumba.analysis.panels import attitude
from lienumba.analysis.panels.select_panels import Panel, PanelLine, good_runs
from lienumba.batch.statuses import GOOD
from lienumba.store.layout import FULL
from lienumba.store.windows import windows
from lienumba.sweep.design import NOMINAL_RUN

MOST_VALUES = 2**22  # of one line, over all runs and times
BLOCK = 64  # consecutive runs


def shown_runs(ds: xr.Dataset, panel: Panel) -> np.ndarray:
    """The runs that a panel shows, along its dimension (runs,): the good ones, of an input all that were sampled; where
    these have more values than a picture needs, blocks of them that are evenly spread over the sweep."""
    which = of_sweep(ds) if panel.sampled else good_runs(ds)
    if panel.dim == FULL:
        which = np.isin(ds[FULL].values, ds["run"].values[which])
    most = max(MOST_VALUES // (ds.sizes["time"] * BLOCK), 1) * BLOCK if panel.over_time else len(which)
    if which.sum() <= most:
        return which
    blocks = np.arange(len(which)) // BLOCK
    return which & np.isin(blocks, np.linspace(0, blocks[-1], most // BLOCK).astype(int))


def nominal_run(ds: xr.Dataset, panel: Panel) -> int | None:
    """The index of the nominal run, if it is not the only one and, but for an input, good."""
    labels, good = ds[panel.dim].values, ds["run"].values[ds["status"].isin(GOOD).values]
    own = np.flatnonzero(labels == NOMINAL_RUN)
    shown = panel.sampled or NOMINAL_RUN in good
    return int(own[0]) if len(own) and shown and not shown_runs(ds, panel)[own[0]] else None


def reference(ds: xr.Dataset, panel: Panel) -> str:
    """From what the angles of an attitude are measured."""
    if panel.over_time and shown_runs(ds, panel).sum() == 1:
        return attitude.START
    return attitude.MEAN if nominal_run(ds, panel) is None else attitude.NOMINAL


def reached(ds: xr.Dataset) -> xr.Dataset:
    """The dataset up to the last stored time that a good run has reached."""
    good = ds["status"].isin(GOOD).values & (np.isin(ds["run"].values, ds[FULL].values) if FULL in ds.dims else True)
    if "end_time" not in ds or not good.any():
        return ds
    times = int(np.searchsorted(ds["time"].values, ds["end_time"].values[good].max(), side="right"))
    return ds if times >= ds.sizes["time"] else ds.isel(time=slice(max(times, 1)))


def values(ds: xr.Dataset, panel: Panel, which: np.ndarray) -> list[np.ndarray]:
    """The values (runs, times) of each line for some of the runs, NaN where a run has none; one time of
    what each run has once."""
    here = ds if panel.over_time else ds.isel(time=slice(-1, None)) if "time" in ds.dims else ds
    of = _angles(here, panel, which) if panel.angles else _plain(here, panel.lines, panel.dim, which)
    return [np.where(np.isfinite(line), line, np.nan) for line in of]


def _plain(ds: xr.Dataset, lines: Sequence[PanelLine], dim: str, which: np.ndarray) -> list[np.ndarray]:
    """The values (runs, times, ...) of each line."""
    found = []
    for name in dict.fromkeys(line.variable for line in lines):
        own = [line for line in lines if line.variable == name]
        found += [np.concatenate(parts) for parts in zip(*_columns(ds, name, own, dim, which), strict=True)]
    return found


def _columns(
    ds: xr.Dataset, name: str, lines: Sequence[PanelLine], dim: str, which: np.ndarray
) -> Iterator[list[np.ndarray]]:
    """The values (runs, times, ...) of lines of one variable, window by window; times: 1 of what a run has once."""
    shared = {key: n for key, n in lines[0].place.items() if all(line.place[key] == n for line in lines)}
    few = ds[[name]].isel(shared)
    for window in windows(few, [name], dim, which):
        whole = window[name]
        timed = whole if "time" in whole.dims else whole.expand_dims("time")
        ordered = timed.transpose(dim, "time", ...).astype(float)
        yield [ordered.isel({key: n for key, n in line.place.items() if key not in shared}).values for line in lines]


def _angles(ds: xr.Dataset, panel: Panel, which: np.ndarray) -> list[np.ndarray]:
    """The angles (runs, times) of the axes of a body from their reference."""
    kind = reference(ds, panel)
    if kind == attitude.START:
        return [attitude.angles(x, x[:, :1]) for x in _plain(ds, panel.lines, panel.dim, which)]
    if kind == attitude.NOMINAL:
        only = np.arange(ds.sizes[panel.dim]) == nominal_run(ds, panel)
        of = _plain(ds, panel.lines, panel.dim, only)
    else:
        sums = [
            [np.nansum(x, axis=0) for x in columns]
            for columns in _columns(ds, panel.name, panel.lines, panel.dim, shown_runs(ds, panel))
        ]
        of = [attitude.mean_directions(sum(parts))[None] for parts in zip(*sums, strict=True)]
    turned = (
        [attitude.angles(x, y) for x, y in zip(columns, of, strict=True)]
        for columns in _columns(ds, panel.name, panel.lines, panel.dim, which)
    )
    return [np.concatenate(parts) for parts in zip(*turned, strict=True)]
