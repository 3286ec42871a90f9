"""Courses of runs that stand in a file: what it has is read and checked, and stays there."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from lienumba.errors import BadValueError, Problem, ScenarioError
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.tables import reading
from lienumba.words import show, suggestion

AT_ONCE = 1 << 22  # numbers that are looked at together
NO_VARIABLE = "not a netCDF variable"  # what netCDF writes into a dimension that has no labels
EQUAL = 1e-9  # relative: intervals nearer than this are alike


def with_run_tables(raw: Keys, folder: Path) -> Keys:
    """The scenario with what is known of the files of its noise, whose paths are relative to this folder."""
    noise = raw.get("noise")
    if not isinstance(noise, list):
        return raw
    problems: list[Problem] = []
    found = []
    for item in noise:
        try:
            found.append(_known(item, folder) if isinstance(item, dict) and item.get("type") == "table" else item)
        except ScenarioError as error:
            problems += error.problems
    if problems:
        raise ScenarioError(*problems)
    return {**raw, "noise": found}


def _known(item: Keys, folder: Path) -> Keys:
    """A noise with what its file says; where it was read before, the file has to be the same."""
    at = f"noise.{item.get('name', '')}"
    table, value = item.get("table"), item.get("value")
    if not isinstance(table, str) or not isinstance(value, str):
        return item  # which the schema tells
    path = folder / table
    with reading(at, table, path, "table"):
        read = _read(path, value) | {"table": str(path.resolve()), "checksum": _checksum(path)}
    if item.get("checksum") not in (None, read["checksum"]):
        raise ScenarioError.at(
            f"{at}.table", "is not the file with which this was written", "give that file", item["table"]
        )
    units = item.get("units", read["units"])
    return {**item, **read, "units": units} if units else {k: x for k, x in {**item, **read}.items() if k != "units"}


def _read(path: Path, name: str) -> dict[str, Any]:
    import h5py

    if not h5py.is_hdf5(path):
        raise BadValueError("is no netCDF-4 file", "save it as such, for instance by xarray's to_netcdf")
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


def _checksum(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
