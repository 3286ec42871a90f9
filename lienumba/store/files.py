"""Datasets on the disk: the one way by which any command reads one."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError
from lienumba.store.form import check_form
from lienumba.store.linear_layout import KIND
from lienumba.store.opening import DENSEST, opened, read_heaps
from lienumba.store.refusals import damaged
from lienumba.words import absence

if TYPE_CHECKING:
    import xarray as xr

ENDINGS = (".nc", ".nc4", ".cdf", ".h5")
OLD = b"CDF"  # what files in netCDF-3 begin with


def read(path: Path, kinds: Collection[str] = ()) -> xr.Dataset:
    """Open a dataset that `lienumba run` wrote, or one of these kinds; a ScenarioError for any other file."""
    if _is(path, Path.is_dir):
        raise ScenarioError(f"{path} is a folder; give the dataset in it, a file that lienumba run wrote")
    if not _is(path, Path.is_file):
        rule, remedy = absence(path, ENDINGS)
        raise ScenarioError(f"{path} {rule}; {remedy}")
    if path.suffix == ".toml":
        raise ScenarioError(f"{path} is a scenario, not a dataset; run it first: lienumba run {path}")
    try:
        dataset = opened(path, lambda: _opened(path))
    except ScenarioError:
        raise
    except Exception as error:  # whatever netCDF4 and xarray make of a file that somebody else has written
        raise ScenarioError(
            f"{path} cannot be opened as netCDF ({said(error)}); give a whole file that lienumba run wrote"
        ) from None
    try:
        if "scenario_sha256" not in dataset.attrs or not ("status" in dataset or KIND in dataset.attrs):
            raise ScenarioError(f"{path} is a netCDF file but not of lienumba; give one that lienumba run wrote")
        with readable(str(path)):
            check_form(dataset, str(path), kinds=kinds)
    except BaseException:
        dataset.close()
        raise
    return dataset


@contextmanager
def reading(
    source: str | os.PathLike[str] | xr.Dataset, kinds: Collection[str] = ()
) -> Iterator[tuple[xr.Dataset, str]]:
    """A dataset that is in memory or in a file, and what it is called; a ScenarioError where it cannot be read, even in
    the middle. kinds: see `linear_layout`, of which it may be, too."""
    import xarray as xr

    if isinstance(source, xr.Dataset):
        check_form(source, "the dataset", kinds=kinds)
        with readable("the dataset"):
            yield source, "the dataset"
    elif isinstance(source, str | os.PathLike):
        where = os.fspath(source)
        with read(Path(source), kinds) as dataset, readable(where):
            yield dataset, where
    else:
        raise ScenarioError(f"dataset = {source!r}: is neither a dataset nor a path of one")


@contextmanager
def readable(where: str) -> Iterator[None]:
    """Turn what netCDF says of a file that is damaged, or gone, into a sentence."""
    try:
        yield
    except RuntimeError as error:  # netCDF4's word for it
        if not str(error).startswith("NetCDF:"):
            raise
        raise ScenarioError(f"{where}: cannot be read ({said(error)}); it is damaged, make it again") from None


def _opened(path: Path) -> xr.Dataset:
    import xarray as xr

    _check_size(path)
    return xr.open_dataset(path, engine="netcdf4", decode_times=False)


def _check_size(path: Path) -> None:
    """Refuse labels and statuses that a file of its size cannot hold, before they are read."""
    import netCDF4

    with path.open("rb") as content:
        if content.read(len(OLD)) == OLD:  # 17 bytes of it may take all memory
            raise ScenarioError(f"{path} is in netCDF-3, which is not read; convert it: nccopy -4 FILE NEW.nc")
    size = path.stat().st_size
    with netCDF4.Dataset(path) as file:
        read = [x for name, x in file.variables.items() if name in (*x.dimensions, "status")]
        if max((math.prod(x.shape) for x in read), default=0) > DENSEST * size:
            raise damaged(str(path), "it is too small for what it says that it holds")
        read_heaps(file, size)


def said(error: Exception) -> str:
    """The first line of what another program says."""
    text = getattr(error, "strerror", None) or str(error)
    return next(iter(text.splitlines()), type(error).__name__)


def _is(path: Path, kind: Callable[[Path], bool]) -> bool:
    """Whether there is a file of this kind; a name that no file can have is none."""
    try:
        return kind(path)
    except (OSError, ValueError):
        return False
