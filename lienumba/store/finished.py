"""A dataset on the disk as a source of runs, for one that has more of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
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
OPEN = 8  # files that are open at the same time


class OpenFiles:
    """Open netCDF files, the one that was read last at the end."""

    def __init__(self) -> None:
        self.files: dict[Path, netCDF4.Dataset] = {}

    def __call__(self, path: Path) -> netCDF4.Dataset:
        with NETCDF:
            if len(self.files) >= OPEN and path not in self.files:
                self.files.pop(next(iter(self.files))).close()
            file = self.files.pop(path, None) or _opened(path)
            self.files[path] = file
            return file

    def close(self) -> None:
        with NETCDF:
            for file in self.files.values():
                file.close()


@dataclass
class FinishedTable:
    """One table of a dataset, as the file holds it, which is opened when it is read."""

    opened: OpenFiles
    path: Path
    dim: str

    def __post_init__(self) -> None:
        self.labels = self.column(self.dim)

    def read(self, part: slice) -> dict[str, np.ndarray]:
        with NETCDF:
            variables = self.opened(self.path).variables
            own = [name for name, x in variables.items() if x.dimensions[:1] == (self.dim,)]
        return {name: self._values(name, part) for name in own}

    def column(self, name: str) -> np.ndarray:
        return self._values(name, slice(None))

    def _values(self, name: str, part: slice) -> np.ndarray:
        try:
            with NETCDF:
                values: np.ndarray = self.opened(self.path).variables[name][part]
                return values
        except RuntimeError as error:
            raise ScenarioError(
                f"{self.path}: is damaged, {name} cannot be read ({error}); make this file again"
            ) from None


class Finished:
    """A dataset by its tables; attributes: of the whole; inputs: the samples (runs,) of each varied path."""

    def __init__(self, path: Path, opened: OpenFiles) -> None:
        self.path, self.opened = path, opened
        with NETCDF:
            file = opened(path)
            self.attributes: dict[str, Any] = {name: file.getncattr(name) for name in file.ncattrs()}
            inputs = [name for name, x in file.variables.items() if getattr(x, "role", "") == "input"]
        self.tables = {dim: FinishedTable(opened, path, dim) for dim in ("run", FULL) if dim in file.variables}
        self.inputs = {name: self.tables["run"].column(name) for name in inputs}

    def check(self, dtypes: Mapping[str, np.dtype[Any]], where: str) -> None:
        """Refuse tables that lack fields of these types, or have them in another shape; where: what the file is
        called."""
        variables = self.opened(self.path).variables
        for table, dtype in dtypes.items():
            for name in (name for name in dtype.names or () if name != LABEL and table in self.tables):
                variable = variables.get(name)
                if variable is None or variable.dimensions[:1] != (table,) or variable.shape[1:] != dtype[name].shape:
                    raise damaged(where, f"it lacks {name} as its scenario stores it")
                if getattr(variable.dtype, "kind", "") not in NUMERIC:
                    raise damaged(where, f"{name} has no numbers")


def _opened(path: Path) -> netCDF4.Dataset:
    file = netcdf_file(path)
    file.set_auto_maskandscale(False)
    for variable in file.variables.values():
        if variable.dtype is not str:
            variable.set_var_chunk_cache(CACHE_BYTES)
    return file
