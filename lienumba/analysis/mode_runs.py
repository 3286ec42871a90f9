"""A dataset of modes as one of runs, whose outputs are the frequencies and damping ratios of the modes."""

from __future__ import annotations

import numpy as np
import xarray as xr

from lienumba.batch.statuses import NOT_ASSEMBLED, SUCCESS
from lienumba.store.layout import RUN, SERIES, WEIGHT
from lienumba.store.linear_layout import KIND, is_modes

OUTPUTS = ("frequency", "damping_ratio", "growth")


def as_runs(ds: xr.Dataset) -> xr.Dataset:
    """Of a dataset of modes the outputs `frequency.1`, `damping_ratio.1`, `growth.1` and so on, over its times; other
    datasets as they are."""
    if not is_modes(ds):
        return ds
    there = (ds["status"] == 0).values.any(axis=1)
    variables: dict[str, tuple[object, ...]] = {
        f"{name}.{mode}": (SERIES, ds[name].sel(mode=mode).values, dict(ds[name].attrs))
        for name in OUTPUTS
        for mode in ds["mode"].values
    }
    inputs = {str(name): x for name, x in ds.coords.items() if x.attrs.get("role") == "input"}
    variables |= {WEIGHT: (RUN, ds[WEIGHT].values, dict(ds[WEIGHT].attrs))} if WEIGHT in ds else {}
    status = np.where(there, SUCCESS, NOT_ASSEMBLED).astype(np.int8)
    attributes = {name: x for name, x in ds.attrs.items() if name != KIND}
    return xr.Dataset(
        {"status": (RUN, status), **variables}, {"run": ds["run"], "time": ds["time"], **inputs}, attributes
    )
