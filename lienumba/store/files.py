"""The way to the disk: a file bears its final name only when all of it is safely there."""

from __future__ import annotations

import os
import secrets
import shutil
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError

if TYPE_CHECKING:
    import xarray as xr

# HDF5 is not thread-safe, not even on different files: whoever calls, one thread at a time writes.
NETCDF = threading.RLock()
DIMENSIONS = ("run", "time", "body", "joint", "axis", "body_axis")  # of which a selection keeps at least one label


class WriteError(OSError):
    """The finished message of a dataset that could not be written."""

    def __str__(self) -> str:
        return str(self.args[0])


def folder_of(target: Path) -> Path:
    """Where the runs of a sweep are that is not finished."""
    return target.with_name(f"{target.name}.runs")


def read(path: Path) -> xr.Dataset:
    """Open a dataset that `lienumba run` wrote; a ScenarioError for any other file."""
    import xarray as xr

    if path.is_dir():
        raise ScenarioError(f"{path} is a folder; give the dataset in it, a file that lienumba run wrote")
    if not path.is_file():
        raise ScenarioError(f"{path} does not exist; check the path")
    try:
        with NETCDF:
            dataset = xr.open_dataset(path, engine="netcdf4")
    except OSError as error:
        raise ScenarioError(f"{path} cannot be opened as netCDF ({error}); is it complete?") from None
    if "scenario_sha256" not in dataset.attrs or "status" not in dataset:
        dataset.close()
        raise ScenarioError(f"{path} is a netCDF file but not of lienumba; give one that lienumba run wrote")
    try:
        check_whole(dataset, str(path))
    except ScenarioError:
        dataset.close()
        raise
    return dataset


def check_whole(dataset: xr.Dataset, where: str, needed: Sequence[str] = ("status",)) -> None:
    """Refuse a selection that has lost what is needed of each run, or a dimension; where: its name."""
    for dim in DIMENSIONS:
        if dim in dataset.variables and dim not in dataset.dims:
            label = dataset[dim].values.tolist()
            raise ScenarioError(
                f"{where}: has only one {dim}, without its dimension; select with a list, such as "
                f"ds.sel({dim}=[{label!r}])"
            )
    for name in needed:
        if name not in dataset or "run" not in dataset[name].dims:
            raise ScenarioError(
                f"{where}: does not say {name} of each run; select runs and variables of what lienumba run wrote, and "
                f"keep {' and '.join(needed)}"
            )
    if not dataset.sizes["run"]:
        raise ScenarioError(f"{where}: has no run; select at least one")


def write(dataset: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Write the dataset in one step: at any moment `path` is the old file, or none, or the whole new one.

    A process that is killed on the way leaves at most a `*.partial` beside it, which may be deleted.
    """
    target = Path(path).resolve()
    partial = partial_of(target)
    try:
        with NETCDF:
            dataset.to_netcdf(partial, mode="w", format="NETCDF4", engine="netcdf4")
        settle(partial, target)
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError for a full disk
        free = shutil.disk_usage(target.parent).free if target.parent.is_dir() else 0
        raise WriteError(
            f"output = {path}: could not be written ({error}): it takes up to {dataset.nbytes / 1e6:.1f} MB,"
            f" and {target.parent} has {free / 1e6:.1f} MB free; make room there, choose another folder,"
            " or store fewer times or variables"
        ) from error
    finally:
        discard(partial)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Where to write a file that bears its name only when all of it is on the disk."""
    target = path.resolve()
    partial = partial_of(target)
    try:
        yield partial
        settle(partial, target)
    except OSError as error:
        raise WriteError(
            f"output = {path}: could not be written ({error.strerror}); make room there, or choose another folder"
        ) from error
    finally:
        discard(partial)


def discard(partial: Path) -> None:
    """Remove what is left of a failed write; nothing to do after a good one."""
    if partial.exists():
        os.truncate(partial, 0)  # HDF5 may hold a file open that it failed to write: give its room back all the same
        partial.unlink()


def partial_of(target: Path) -> Path:
    return target.with_name(f"{target.name}.{secrets.token_hex(4)}.partial")


def settle(partial: Path, target: Path) -> None:
    """Give a file its name when all of it is on the disk."""
    to_disk(partial)
    os.replace(partial, target)
    to_disk(target.parent)


def to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
