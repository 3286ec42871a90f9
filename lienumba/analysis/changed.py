"""Mechanisms that change: what changed in the runs of a dataset, when, by which impulse, and what energy it took."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.batch.changes import KIND_OF, NONE, Kind
from lienumba.errors import ScenarioError
from lienumba.store.refusals import check_together

QUANTILES = (0.05, 0.5, 0.95)
BLOCK = 1000  # runs that are read at once


@dataclass(frozen=True)
class Changed:
    """One kind of change of one thing, an event or a switch: how often and in how many runs, quantiles of its times
    (s), the median and the largest size of its impulse, and the median of the energy that was lost (J); told: of the
    first changes of each run."""

    what: str
    kind: Kind
    count: int
    runs: int
    low: float
    median: float
    high: float
    impulse: float
    largest_impulse: float
    energy: float


@dataclass(frozen=True)
class Modes:
    """A switch over times (T,) in s: in how many of so many runs it is on, by how it is (T,), and how many of them have
    ended."""

    name: str
    times: np.ndarray
    counts: dict[str, np.ndarray]
    ended: np.ndarray
    runs: int


def mode_counts(ds: xr.Dataset) -> Iterator[Modes]:
    """Of every switch that is ever on, in how many runs it is so, read by blocks of runs."""
    names = ds["mode"].attrs["flag_meanings"].split()
    shape = ds.sizes["time"], ds.sizes["switch"]
    found, ended = np.zeros((len(names), *shape), int), np.zeros(shape, int)
    rows = ds["mode"].dims[0]
    for first in range(0, ds.sizes[rows], BLOCK):
        block = ds["mode"].isel({rows: slice(first, first + BLOCK)}).values
        ended += np.isnan(block).sum(axis=0)
        for mode in range(len(names)):
            found[mode] += (block == mode).sum(axis=0)
    for n, name in enumerate(ds["switch"].values):
        counts = {how: found[mode, :, n] for mode, how in enumerate(names) if mode and found[mode, :, n].any()}
        if counts:
            yield Modes(str(name), ds["time"].values, counts, ended[:, n], ds.sizes[rows])


def changes(ds: xr.Dataset) -> xr.Dataset:
    """What changed, an entry for each change that a dataset tells of; `.to_dataframe()` makes a table of it.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned of a mechanism that changes, or a selection of its runs.

    Returns
    -------
    xarray.Dataset
        On the dimension entry, by run and time: run, time (s), kind ("impact", "locked", ...), what (the event or the
        switch), impulse (N s, or N m s of an angle) and energy (lost, J).

    Raises
    ------
    ScenarioError
        Where nothing of the mechanism can change.
    """
    if not tells(ds):
        raise ScenarioError("the dataset tells of no changes: its mechanism has no locks, limits, contacts or actions")
    run, n = np.nonzero(ds["change_kind"].values != NONE)
    pairs = zip(ds["change_kind"].values[run, n], ds["change_what"].values[run, n], strict=True)
    kinds, whats = np.array([change_names(ds, *pair) for pair in pairs], dtype=str).reshape(-1, 2).T
    columns = {
        "run": ds["run"].values[run],
        "kind": kinds,
        "what": whats,
        **{name: ds[f"change_{name}"].values[run, n] for name in ("time", "impulse", "energy")},
    }
    return xr.Dataset({name: ("entry", column) for name, column in columns.items()})


def tells(ds: xr.Dataset) -> bool:
    """Whether a dataset has the table of changes; a ScenarioError if it has a part of it."""
    check_together(ds, "the dataset")
    return "change_time" in ds


def change_names(ds: xr.Dataset, kind: float, what: float) -> tuple[str, str]:
    """The kind of a change and what changed, from their codes; empty where there was none."""
    if np.isnan(kind) or kind == NONE:
        return "", ""
    return KIND_OF[int(kind)].name, _name(ds, KIND_OF[int(kind)], int(what))


def _name(ds: xr.Dataset, kind: Kind, what: int) -> str:
    return str(ds["event" if kind.of_event else "switch"].values[what])


def changed(ds: xr.Dataset, which: np.ndarray) -> Iterator[Changed]:
    """Each kind of change that occurs in these runs (runs,), by the median of its times."""
    kinds, whats = ds["change_kind"].values[which].astype(int), ds["change_what"].values[which].astype(int)
    numbers = [ds[f"change_{name}"].values[which] for name in ("time", "impulse", "energy")]
    found = []
    for kind, what in {pair for pair in zip(kinds.flat, whats.flat, strict=True) if pair[0] != NONE}:
        same = (kinds == kind) & (whats == what)
        times, impulses, energies = (np.nan_to_num(x[same]) for x in numbers)
        low, median, high = np.quantile(times, QUANTILES).tolist()
        found.append(
            Changed(
                _name(ds, KIND_OF[kind], what), KIND_OF[kind], int(same.sum()), int(same.any(axis=1).sum()),
                low, median, high, float(np.median(impulses)), float(impulses.max()),
                float(np.median(energies)),
            )
        )  # fmt: skip
    yield from sorted(found, key=lambda x: (x.median, x.what, x.kind.code))


def told(ds: xr.Dataset, which: np.ndarray) -> str:
    """How many changes these runs had, how much energy they lost, and whether all are told of, in words."""
    counts, lost = ds["changes"].values[which], ds["energy_lost"].values[which]
    if not counts.any():
        return "no changes"
    low, high = int(counts.min()), int(counts.max())
    each = f"{low:,}" if low == high else f"{low:,} to {high:,}"
    most = ds.sizes["change"]
    first = f", of which the first {most} are told" if high > most else ""
    energy = f"; energy lost: {np.nanmin(lost):.6g} to {np.nanmax(lost):.6g} J, median {np.nanmedian(lost):.6g} J"
    return f"changes of each run: {each}{first}{energy}"
