"""A dataset that never is in memory: its frame is written first, then run by run what tables of runs hold."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lienumba.store.columns import Column, Columns
from lienumba.store.layout import FULL, RUN
from lienumba.store.opening import NETCDF
from lienumba.store.outputs import Output, WriteError, discard, refusal

if TYPE_CHECKING:
    import xarray as xr

    Records = Mapping[str, np.ndarray]  # columns by name; a structured array is one, too

RUNS = (RUN, (FULL,))  # the first dimension of what is not the same for all runs
PART_BYTES = 8 * 2**20  # that are read and written at a time


class Source(Protocol):
    """Some runs of a table: their labels (runs,), the columns of a part of them, and one column of all."""

    labels: np.ndarray

    def read(self, part: slice) -> Any: ...

    def column(self, name: str) -> np.ndarray: ...


@dataclass(frozen=True)
class SourceSlice:
    """Consecutive records of a table that come from one source."""

    source: Source
    part: slice


def slices(labels: np.ndarray, sources: Sequence[Source]) -> list[SourceSlice]:
    """From which source each of these runs (labels, ascending) comes, in their order; of several the first counts."""
    place = np.full(len(labels), -1, np.int64)  # of the record in its source
    origin = np.full(len(labels), -1, np.int64)
    for n in reversed(range(len(sources))):
        own = sources[n].labels
        if not len(own) or not len(labels) or own.max() < labels[0] or own.min() > labels[-1]:
            continue
        at = np.minimum(np.searchsorted(labels, own), len(labels) - 1)
        wanted = np.flatnonzero(labels[at] == own)
        place[at[wanted]], origin[at[wanted]] = wanted, n
    if (origin < 0).any():
        raise ValueError(f"no source has run {labels[origin < 0][0]}")
    breaks = np.flatnonzero((np.diff(origin) != 0) | (np.diff(place) != 1)) + 1
    bounds = [0, *breaks.tolist(), len(labels)] if len(labels) else [0]
    return [SourceSlice(sources[origin[a]], slice(int(place[a]), int(place[a]) + b - a)) for a, b in pairwise(bounds)]


class Stream:
    """A dataset on its way to the disk, which bears its name only when all of it is there, as with `outputs.write`.

    frame: the dataset without any run; threads: that compress.
    """

    def __init__(self, frame: xr.Dataset, output: Output, threads: int) -> None:
        self.output, self.partial = output, output.partial()
        self.file: Any = None
        self.columns: Columns | None = None
        try:
            with self._safely():
                unlimited = [name for (name,) in RUNS if name in frame.dims]
                frame.to_netcdf(self.partial, mode="w", format="NETCDF4", engine="netcdf4", unlimited_dims=unlimited)
                import h5py  # netCDF4 has closed the file: the two bring an HDF5 library each

                self.file, self.text = h5py.File(self.partial, "r+"), partial(h5py.string_dtype, "utf-8")
                own = {str(name): str(x.dims[0]) for name, x in frame.variables.items() if x.dims[:1] in RUNS}
                self.columns = Columns({name: Column(self.file[name]) for name in own}, threads)
                self.tables = {dim: [n for n in own if n in frame.data_vars and own[n] == dim] for dim in unlimited}
        except BaseException:
            self.discard()
            raise

    def put(self, dim: str, every: Iterable[SourceSlice], tell: Callable[[int], None], before: int = 0) -> None:
        """Write pieces of a table behind what is there; tell(how many records there are then, `before` among them)."""
        with self._safely():
            assert self.columns is not None
            for records in (part for piece in every for part in _parts(piece)):
                own = [name for name in self.tables[dim] if name in _names(records)]
                for name in own:
                    self.columns.take(name, records[name])
                before += len(records[own[0]])
                tell(before)

    def finish(self, columns: Mapping[str, np.ndarray], attributes: Mapping[str, str]) -> None:
        """Write coordinates of all runs, and attributes that were not known before; then the dataset is whole."""
        with self._safely():
            assert self.columns is not None
            for name, text in attributes.items():
                self.file.attrs.create(name, text.encode(), dtype=self.text(len(text.encode())))
            for name, column in columns.items():
                self.columns.take(name, column)
            self.columns.end()
            self.columns.close()
            self.file.close()
            self.output.settle(self.partial)

    def discard(self) -> None:
        """Leave nothing of a dataset that is not whole."""
        if self.columns is not None:
            self.columns.close()
        with NETCDF, suppress(OSError, RuntimeError):
            if self.file is not None:
                self.file.close()
        discard(self.partial)

    @contextmanager
    def _safely(self) -> Iterator[None]:
        try:
            with NETCDF:
                yield
        except WriteError:
            self.discard()
            raise
        except (OSError, RuntimeError) as error:  # some of HDF5's errors are RuntimeErrors
            why = refusal(error, self.partial)
            self.discard()
            raise self.output.failed(why) from error


def _names(records: Records) -> Iterable[str]:
    """Of the columns."""
    return records.dtype.names if hasattr(records, "dtype") else records


def _parts(piece: SourceSlice) -> Iterator[Records]:
    """What is written at a time."""
    first, last = piece.part.start, piece.part.stop
    one = piece.source.read(slice(first, first + 1))
    step = max(1, PART_BYTES // max(1, sum(one[name].nbytes for name in _names(one))))
    for start in range(first, last, step):
        yield piece.source.read(slice(start, min(start + step, last)))
