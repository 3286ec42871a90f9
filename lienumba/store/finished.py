"""A dataset on the disk as a source of runs, for one that has more of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.store.form import NUMERIC
from lienumba.store.layout import CHUNK_BYTES, FULL, LABEL
from lienumba.store.opening import NETCDF, netcdf_file
from lienumba.store.refusals import damaged

if TYPE_CHECKING:
    import netCDF4

CACHE_BYTES = 4 * CHUNK_BYTES  # of each variable: runs are read and written in their order; HDF5's default is far more


def small_caches(file: netCDF4.Dataset) -> None:
    """Bound what HDF5 keeps in memory of an open file."""
    for variable in file.variables.values():
        if variable.dtype is not str:
            variable.set_var_chunk_cache(CACHE_BYTES)


class RecordColumns(dict[str, np.ndarray]):
    """Records of a table, column by column."""

    @property
    def nbytes(self) -> int:
        return sum(column.nbytes for column in self.values())


class FinishedTable:
    """One table of a dataset, as the file holds it."""

    def __init__(self, file: netCDF4.Dataset, dim: str) -> None:
        self.file, self.dim = file, dim
        self.labels = _read(file, dim, slice(None))

    def read(self, part: slice) -> RecordColumns:
        own = [name for name, x in self.file.variables.items() if x.dimensions[:1] == (self.dim,)]
        return RecordColumns({name: _read(self.file, name, part) for name in own})

    def column(self, name: str) -> np.ndarray:
        return _read(self.file, name, slice(None))


class Finished:
    """The tables of a dataset that is closed in the end; attributes: of the whole."""

    def __init__(self, path: Path) -> None:
        with NETCDF:
            self.file = netcdf_file(path)
            self.file.set_auto_maskandscale(False)
            small_caches(self.file)
            self.attributes: dict[str, Any] = {name: self.file.getncattr(name) for name in self.file.ncattrs()}
            self.tables = {dim: FinishedTable(self.file, dim) for dim in ("run", FULL) if dim in self.file.variables}

    def check(self, dtypes: Mapping[str, np.dtype[Any]], where: str) -> None:
        """Refuse tables that lack fields of these types, or have them in another shape; where: what the file is
        called."""
        for table, dtype in dtypes.items():
            for name in (name for name in dtype.names or () if name != LABEL and table in self.tables):
                variable = self.file.variables.get(name)
                if variable is None or variable.dimensions[:1] != (table,) or variable.shape[1:] != dtype[name].shape:
                    raise damaged(where, f"it lacks {name} as its scenario stores it")
                if getattr(variable.dtype, "kind", "") not in NUMERIC:
                    raise damaged(where, f"{name} has no numbers")

    @property
    def inputs(self) -> dict[str, np.ndarray]:
        """The samples (runs,) of each varied path, by path."""
        paths = [name for name, x in self.file.variables.items() if getattr(x, "role", "") == "input"]
        return {path: _read(self.file, path, slice(None)) for path in paths}

    def close(self) -> None:
        with NETCDF:
            self.file.close()


def _read(file: netCDF4.Dataset, name: str, part: slice) -> np.ndarray:
    try:
        with NETCDF:
            values: np.ndarray = file.variables[name][part]
            return values
    except RuntimeError as error:
        raise ScenarioError(
            f"{file.filepath()}: is damaged, {name} cannot be read ({error}); make this file again"
        ) from None
