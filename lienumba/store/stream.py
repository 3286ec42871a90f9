"""A dataset that never is in memory: its frame is written first, then run by run what tables of runs hold."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lienumba.store.files import NETCDF, WriteError, discard, partial_of, settle
from lienumba.store.finished import small_caches
from lienumba.store.layout import FULL, NO_COUNT

if TYPE_CHECKING:
    import xarray as xr

    Records = Mapping[str, np.ndarray]  # columns by name; a structured array is one, too

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
    """A dataset on its way to the disk, which bears its name only when all of it is there, as with `files.write`.

    frame: the dataset without any run.
    """

    def __init__(self, frame: xr.Dataset, path: str | os.PathLike[str]) -> None:
        self.path, self.target = path, Path(path).resolve()
        self.partial = partial_of(self.target)
        self.file: Any = None
        with self._whole_or_nothing(), self._safely():
            unlimited = [name for name in ("run", FULL) if name in frame.dims]
            frame.to_netcdf(self.partial, mode="w", format="NETCDF4", engine="netcdf4", unlimited_dims=unlimited)
            self.file = _open(self.partial)

    def put(self, dim: str, first: int, every: Iterable[SourceSlice], tell: Callable[[int], None]) -> None:
        """Write pieces of a table, one behind the other, from a record on; tell(how many there are then)."""
        with self._safely():
            own = {name: x for name, x in self.file.variables.items() if x.dimensions[:1] == (dim,)}
            for records in (part for piece in every for part in _parts(piece)):
                for name in own.keys() & set(_names(records)):
                    values = _as_stored(records[name], own[name].dtype)
                    own[name][first : first + len(values)] = values
                first += len(values)
                tell(first)

    def finish(self, columns: Mapping[str, np.ndarray], attributes: Mapping[str, str]) -> None:
        """Write coordinates of all runs, and attributes that were not known before; then the dataset is whole."""
        with self._safely():
            self.file.setncatts(attributes)
            for name, column in columns.items():
                self.file.variables[name][: len(column)] = column
            self.file.close()
            settle(self.partial, self.target)

    def discard(self) -> None:
        """Leave nothing of a dataset that is not whole."""
        with NETCDF, suppress(OSError, RuntimeError):
            if self.file is not None and self.file.isopen():
                self.file.close()
        discard(self.partial)

    @contextmanager
    def _whole_or_nothing(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self.discard()
            raise

    @contextmanager
    def _safely(self) -> Iterator[None]:
        try:
            with NETCDF:
                yield
        except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError for a full disk
            self.discard()
            folder = self.target.parent
            free = shutil.disk_usage(folder).free if folder.is_dir() else 0
            raise WriteError(
                f"output = {self.path}: could not be written ({error}): {folder} has {free / 1e6:.1f} MB free; make "
                "room there, choose another folder, or store fewer times or variables"
            ) from error


def _open(path: Path) -> Any:
    import netCDF4

    file = netCDF4.Dataset(path, "a")
    file.set_auto_maskandscale(False)
    small_caches(file)
    return file


def _names(records: Records) -> Iterable[str]:
    """Of the columns."""
    return records.dtype.names if hasattr(records, "dtype") else records


def _parts(piece: SourceSlice) -> Iterator[Records]:
    """What is written at a time."""
    first, last = piece.part.start, piece.part.stop
    step = max(1, PART_BYTES // max(1, piece.source.read(slice(first, first + 1)).nbytes))
    for start in range(first, last, step):
        yield piece.source.read(slice(start, min(start + step, last)))


def _as_stored(values: np.ndarray, dtype: np.dtype[np.generic]) -> np.ndarray:
    """As the file holds them: counts as integers, and no count as -1."""
    if dtype.kind == "i" and values.dtype.kind == "f":
        return np.where(np.isnan(values), NO_COUNT, values).astype(dtype)
    return values
