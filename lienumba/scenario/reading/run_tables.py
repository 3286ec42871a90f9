"""Courses of runs that stand in a file: what it has is read and checked, and stays there.

A scenario that has been read knows the checksum of its file and what that says of itself, so that it needs the file no
more until its runs go. That of a dataset may have moved: it is also looked for beside the dataset.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import BadValueError
from lienumba.scenario.base.problems import each
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.tables import reading
from lienumba.store.form import current, scenario_tables
from lienumba.store.opening import netcdf_file
from lienumba.sweep.noise import checksum_of, is_file
from lienumba.words import show, suggestion

if TYPE_CHECKING:
    import xarray as xr

AT_ONCE = 1 << 22  # numbers that are looked at together
NO_VARIABLE = "not a netCDF variable"  # what netCDF writes into a dimension that has no labels
EQUAL = 1e-9  # relative: intervals nearer than this are alike


def with_run_tables(raw: Keys, folder: Path) -> Keys:
    """The scenario with the paths of the files of its noise, which are relative to this folder."""
    return _each(raw, lambda item: {**item, "table": os.path.abspath(folder / item["table"])})


def read_run_tables(raw: Keys) -> Keys:
    """The scenario with what the files of its noise say, unless it knows that."""
    model = raw.get("model")
    return {**raw, "model": _each(model, _known)} if isinstance(model, dict) else raw


def tables_of(ds: "xr.Dataset", where: str) -> Keys:
    """The scenario of a dataset, whose files of courses are those beside it where they are not where they were."""

    def found(item: Any) -> Keys:
        here = Path(ds.encoding.get("source", "")).parent / Path(item["table"]).name
        moved = not is_file(item["table"], item.get("checksum")) and is_file(str(here), item.get("checksum"))
        return {**item, "table": os.path.abspath(here)} if moved else item

    return _each(current(scenario_tables(ds, where)), found)


def _each(raw: Keys, changed: Callable[[Any], Keys]) -> Keys:
    """The scenario, or its model, with each noise changed that has a file."""
    noise = raw.get("noise")
    if not isinstance(noise, list):
        return raw
    found = each(lambda item: changed(item) if _is_table(item) else item, noise)  # the schema refuses others
    return {**raw, "noise": found}


def _is_table(item: object) -> bool:
    return (
        isinstance(item, dict)
        and item.get("type") == "table"
        and isinstance(item.get("name"), str)
        and isinstance(item.get("table"), str)
        and isinstance(item.get("value"), str)
    )


def _known(item: Any) -> Keys:
    """A noise with what its file says."""
    if item.get("checksum") is not None:
        return item
    path = Path(item["table"])
    with reading(f"noise.{item['name']}", item["table"], path, "table"):
        found = {**item, "table": os.path.abspath(path), **_read(path, item["value"]), "checksum": checksum_of(path)}
    units = item.get("units", found["units"])
    return {key: x for key, x in (found | {"units": units}).items() if key != "units" or units}


def _read(path: Path, name: str) -> dict[str, Any]:
    import h5py

    if not h5py.is_hdf5(path):
        raise BadValueError("is no netCDF-4 file", "save it as such, for instance by xarray's to_netcdf")
    netcdf_file(path).close()  # h5py would not let other threads run
    with h5py.File(path, "r") as file:
        names = [key for key, x in file.items() if isinstance(x, h5py.Dataset)]
        if name not in names:
            raise BadValueError(f"has no variable {show(name)}", suggestion(name, names))
        values = file[name]
        if values.ndim != 2 or values.dtype.kind not in "fiu":
            raise BadValueError(
                f"the variable {name} has the shape {list(values.shape)}", "give numbers with dimensions run and time"
            )
        if "time" not in names or file["time"].shape != values.shape[1:] or values.shape[1] < 2:
            rule = f"has no variable time of {values.shape[1]} times, at least 2, as the second dimension of {name}"
            raise BadValueError(rule, "give run and time as dimensions, in this order")
        times = np.asarray(file["time"][:], float)
        every = float(times[-1] - times[0]) / (len(times) - 1)
        if times[0] != 0.0 or not every > 0.0 or not (abs(np.diff(times) - every) <= EQUAL * times[-1]).all():
            raise BadValueError("its times do not begin at 0 or are not at equal intervals", "resample the courses")
        if (
            "run" in names
            and NO_VARIABLE not in str(file["run"].attrs.get("NAME"))
            and not np.array_equal(file["run"][:], np.arange(len(values)))
        ):
            raise BadValueError("its runs are not 0, 1, 2 and so on", "sort them, or leave run out")
        step = max(AT_ONCE // values.shape[1], 1)
        for first in range(0, len(values), step):
            bad = np.flatnonzero(~np.isfinite(values[first : first + step]).all(axis=1))
            if len(bad):
                raise BadValueError(f"run {first + bad[0]} of {name} has a value that is not finite", "correct it")
        units = values.attrs.get("units")
        return {
            "every": every, "runs": len(values), "samples": len(times),
            "units": units if isinstance(units, str) else units.decode() if isinstance(units, bytes) else None,
        }  # fmt: skip
