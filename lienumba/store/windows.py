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
            yield _loaded(few.isel({dim: slice(first, first + step)}))
        elif len(here):
            span = slice(first + int(here[0]), first + int(here[-1]) + 1)
            yield _loaded(few.isel({dim: span})).isel({dim: here - here[0]})


def _loaded(few: xr.Dataset) -> xr.Dataset:
    """In memory; sums of what is stored in single precision are not to be rounded so."""
    return few.load().assign({str(n): x.astype(float) for n, x in few.data_vars.items() if x.dtype == np.float32})
