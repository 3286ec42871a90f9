"""A dataset on the disk as a source of runs, for one that has more of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from lienumba.store.files import NETCDF
from lienumba.store.layout import FULL

if TYPE_CHECKING:
    import numpy as np


class Columns(dict[str, "np.ndarray"]):
    """Records of a table, column by column."""

    @property
    def nbytes(self) -> int:
        return sum(column.nbytes for column in self.values())


class Table:
    """One table of a dataset, as the file holds it."""

    def __init__(self, file: Any, dim: str) -> None:
        self.file, self.dim = file, dim
        self.labels: np.ndarray = file.variables[dim][:]

    def read(self, part: slice) -> Columns:
        with NETCDF:
            own = {name: x for name, x in self.file.variables.items() if x.dimensions[:1] == (self.dim,)}
            return Columns({name: x[part] for name, x in own.items()})

    def column(self, name: str) -> np.ndarray:
        with NETCDF:
            values: np.ndarray = self.file.variables[name][:]
            return values


class Finished:
    """The tables of a dataset that is closed in the end; attributes: of the whole."""

    def __init__(self, path: Path) -> None:
        import netCDF4

        with NETCDF:
            self.file = netCDF4.Dataset(path)
            self.file.set_auto_maskandscale(False)
            self.attributes: dict[str, Any] = {name: self.file.getncattr(name) for name in self.file.ncattrs()}
            self.tables = {dim: Table(self.file, dim) for dim in ("run", FULL) if dim in self.file.variables}

    def close(self) -> None:
        with NETCDF:
            self.file.close()
