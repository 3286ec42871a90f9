"""A dataset that never is in memory: its frame is written first, then run by run what tables of runs hold."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lienumba.store.files import NETCDF, WriteError, discard, partial_of, to_disk
from lienumba.store.layout import FULL, NO_COUNT

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    Records = Mapping[str, np.ndarray]  # columns by name; a structured array is one, too

PART_BYTES = 16 * 2**20  # that are read and written at a time


class Source(Protocol):
    """Some runs of a table: their labels (runs,), and the columns of a part of them."""

    labels: np.ndarray

    def read(self, part: slice) -> Any: ...


@dataclass(frozen=True)
class Piece:
    """Consecutive records of a table that come from one source."""

    first: int
    source: Source
    part: slice


def pieces(labels: np.ndarray, sources: Sequence[Source]) -> list[Piece]:
    """From which source each of these runs (labels, ascending) comes, in their order; of several the first counts."""
    import numpy as np

    place = np.full(len(labels), -1, np.int64)  # of the record in its source
    origin = np.full(len(labels), -1, np.int64)
    for n in reversed(range(len(sources))):
        own = sources[n].labels
        at = np.minimum(np.searchsorted(labels, own), max(len(labels) - 1, 0))
        wanted = np.flatnonzero(labels[at] == own) if len(labels) else np.empty(0, np.int64)
        place[at[wanted]], origin[at[wanted]] = wanted, n
    if (origin < 0).any():
        raise ValueError(f"no source has run {labels[origin < 0][0]}")
    breaks = np.flatnonzero((np.diff(origin) != 0) | (np.diff(place) != 1)) + 1
    bounds = [0, *breaks.tolist(), len(labels)] if len(labels) else [0]
    return [Piece(a, sources[origin[a]], slice(int(place[a]), int(place[a]) + b - a)) for a, b in pairwise(bounds)]


def write(
    frame: xr.Dataset,
    columns: Mapping[str, np.ndarray],
    tables: Mapping[str, Iterable[Piece]],
    path: str | os.PathLike[str],
    tell: Callable[[int], None] = lambda runs: None,
) -> None:
    """Write a dataset in one step, as `files.write` does, from its frame, which is the dataset without any run.

    columns: coordinates of the runs, whole; tables: by the name of their dimension; tell(runs written).
    """
    target = Path(path).resolve()
    partial = partial_of(target)
    try:
        with NETCDF:
            unlimited = [name for name in ("run", FULL) if name in frame.dims]
            frame.to_netcdf(partial, mode="w", format="NETCDF4", engine="netcdf4", unlimited_dims=unlimited)
            _fill(partial, columns, tables, tell)
        to_disk(partial)
        os.replace(partial, target)
        to_disk(target.parent)
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError for a full disk
        free = shutil.disk_usage(target.parent).free if target.parent.is_dir() else 0
        raise WriteError(
            f"output = {path}: could not be written ({error}): {target.parent} has {free / 1e6:.1f} MB free; make room "
            "there, choose another folder, or store fewer times or variables"
        ) from error
    finally:
        discard(partial)


def _fill(
    partial: Path,
    columns: Mapping[str, np.ndarray],
    tables: Mapping[str, Iterable[Piece]],
    tell: Callable[[int], None],
) -> None:
    import netCDF4

    with netCDF4.Dataset(partial, "a") as file:
        file.set_auto_maskandscale(False)
        for name, column in columns.items():
            file.variables[name][: len(column)] = column
        for dim, every in tables.items():
            own = [name for name, x in file.variables.items() if x.dimensions[0:1] == (dim,) and name not in columns]
            for first, records in _parts(every):
                count = len(records[own[0]]) if own else 0
                for name in own:
                    file.variables[name][first : first + count] = _as_stored(records[name], file.variables[name].dtype)
                if dim == "run":
                    tell(first + count)


def _parts(every: Iterable[Piece]) -> Iterator[tuple[int, Records]]:
    """What is written at a time, and from which record on."""
    for piece in every:
        size = max(1, piece.source.read(slice(piece.part.start, piece.part.start + 1)).nbytes)
        step = max(1, PART_BYTES // size)
        for start in range(piece.part.start, piece.part.stop, step):
            part = slice(start, min(start + step, piece.part.stop))
            yield piece.first + start - piece.part.start, piece.source.read(part)


def _as_stored(values: np.ndarray, dtype: Any) -> np.ndarray:
    """As the file holds them: counts as integers, and no count as -1."""
    import numpy as np

    if dtype.kind == "i" and values.dtype.kind == "f":
        return np.where(np.isnan(values), NO_COUNT, values).astype(dtype)
    return values
