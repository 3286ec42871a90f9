"""A dataset some runs at a time: what is on the disk need not fit into the memory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from lienumba.store.layout import RUN

if TYPE_CHECKING:
    import xarray as xr

WINDOW_BYTES = 8 * 2**20


def windows(ds: xr.Dataset, names: Sequence[str], dim: str = RUN[0]) -> Iterator[xr.Dataset]:
    """These variables of consecutive runs, loaded; dim: along which the runs are."""
    few, runs = ds[list(names)], ds.sizes[dim]
    step = max(1, int(WINDOW_BYTES * runs / max(few.nbytes, 1)))
    for first in range(0, runs, step):
        yield few.isel({dim: slice(first, first + step)}).load()
