"""A dataset some runs at a time: what is on the disk need not fit into the memory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lienumba.store.layout import RUN

if TYPE_CHECKING:
    import xarray as xr

WINDOW_BYTES = 8 * 2**20


def windows(
    ds: xr.Dataset, names: Sequence[str], dim: str = RUN[0], which: np.ndarray | None = None
) -> Iterator[xr.Dataset]:
    """These variables of consecutive runs, loaded; dim: along which the runs are; which (runs,): those that are wanted,
    all if omitted."""
    few, runs = ds[list(names)], ds.sizes[dim]
    few = few.drop_vars([name for name in few.coords if name not in (*few.dims, *names)])  # samples need not be read
    step = max(1, int(WINDOW_BYTES * runs / max(few.nbytes, 1)))
    for first in range(0, runs, step):
        here = None if which is None else which[first : first + step].nonzero()[0]
        if here is None:
            yield few.isel({dim: slice(first, first + step)}).load()
        elif len(here):
            span = slice(first + int(here[0]), first + int(here[-1]) + 1)
            yield few.isel({dim: span}).load().isel({dim: here - here[0]})
