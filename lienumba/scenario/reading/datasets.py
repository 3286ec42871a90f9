"""Datasets that a scenario names: where it starts, and the reference of its study."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.schema.tables import check_file
from lienumba.scenario.study_errors import STATE, Truth
from lienumba.sweep.noise import checksum_of
from lienumba.words import listed, show

if TYPE_CHECKING:
    import xarray as xr

START, REFERENCE = "start.file", "study.reference.file"
SAME_START, SAME = 1e-9, 1e-12  # relative: times and samples nearer to each other are the same
COORDINATES = ("q", "qd")
OF_FILE = ("file", "run", "time")


def _opened(at: str, file: str) -> "xr.Dataset":
    from lienumba.store.files import read

    try:
        return read(Path(file))
    except ScenarioError as error:
        raise error.inside(f"{at} = {show(file)}") from None


def _nearest(times: np.ndarray, time: float, rtol: float) -> tuple[int, bool]:
    """The index of the stored time that is the nearest, and whether it is the same one."""
    index = int(np.argmin(np.abs(times - time)))
    return index, bool(abs(times[index] - time) <= rtol * max(abs(time), 1.0))


# ---------------------------------------------------------------- the start
def with_start(raw: Keys, folder: Path) -> Keys:
    """The scenario with the path of the file of its start, which is relative to this folder, and `q.piston.angle = ...`
    without quotes, which TOML reads as a table in a table, as one name."""
    start = raw.get("start")
    if not isinstance(start, dict):
        return raw
    flat = {key: _flat(x) if key in COORDINATES else x for key, x in start.items()}
    if isinstance(flat.get("file"), str):
        flat["file"] = (folder / flat["file"]).as_posix()
    return {**raw, "start": flat}


def _flat(given: Any) -> Any:
    if not isinstance(given, dict):
        return given
    found: Keys = {}
    for name, item in given.items():
        inner = _flat(item)
        found |= {f"{name}.{rest}": x for rest, x in inner.items()} if isinstance(inner, dict) else {name: item}
    return found


def read_start(raw: Keys) -> Keys:
    """The scenario with the coordinates that the file of its start has, below those that it gives itself."""
    model = table_in(raw, "model")
    start = table_in(model, "start")
    if not any(key in start for key in OF_FILE):
        return raw
    file = start.get("file")
    if not isinstance(file, str):
        key = next(key for key in OF_FILE if key in start)
        raise ScenarioError.at(f"start.{key}", "has no meaning without a file", 'give file = "out.nc"', start[key])
    given = {key: x for key, x in start.items() if key not in OF_FILE}
    found = _coordinates(file, start.get("run"), start.get("time"))
    for key in COORDINATES:
        own = given.get(key, {})
        given[key] = {**_below(found[key], own), **own} if isinstance(own, dict) else own
    return {**raw, "model": {**model, "start": given}}


def _below(found: dict[str, float], own: Keys) -> dict[str, float]:
    """Without what a list gives for all coordinates of a joint."""
    return {name: x for name, x in found.items() if name.partition(".")[0] not in own}


def _coordinates(file: str, run: object, time: object) -> dict[str, dict[str, float]]:
    """q and qd by coordinate, of one run at a stored time: the only or first run, the last time of all."""
    with _opened(START, file) as ds:
        missing = [name for name in COORDINATES if name not in ds or "time" not in ds[name].dims]
        if missing:
            remedy = "give one that was run with output.joint_coordinates = true"
            raise ScenarioError.at(START, f"has no {listed(missing)}", remedy, file)
        q = COORDINATES[0]
        labels, times = ds[q][ds[q].dims[0]].values.tolist(), ds["time"].values
        place = labels.index(run) if run in labels else 0 if run is None else None
        if place is None:
            raise ScenarioError.at("start.run", f"{file} has no such run", f"give one such as {labels[0]}", run)
        at = len(times) - 1
        if time is not None:
            if not isinstance(time, int | float):
                raise ScenarioError.at("start.time", "must be a number", "give a stored time in s", time)
            at, same = _nearest(times, time, SAME_START)
            if not same:
                remedy = f"the nearest stored time is {times[at]:.9g}"
                raise ScenarioError.at("start.time", "is not stored", remedy, time)
        found = {name: ds[name].values[place, at] for name in COORDINATES}
        names = [str(name) for name in ds["coordinate"].values]
    if not all(np.isfinite(x).all() for x in found.values()):
        rule = f"run {labels[place]} has no state at t = {times[at]:.9g} s"
        raise ScenarioError.at(START, rule, "give a run and a time that it reached", file)
    return {key: dict(zip(names, x.tolist(), strict=True)) for key, x in found.items()}


# ---------------------------------------------------------------- the reference of a study
def with_reference(raw: Keys, folder: Path) -> Keys:
    """The scenario with the path of the file of its reference, which is relative to this folder, and its checksum."""
    study = table_in(raw, "study")
    reference = table_in(study, "reference")
    named = reference.get("file")
    if not isinstance(named, str):
        return raw
    path = folder / named
    check_file(REFERENCE, path, named)
    found = checksum_of(path)
    if reference.get("sha256", found) != found:
        rule = f"has changed since sha256 = {show(reference['sha256'])} was written"
        raise ScenarioError.at(REFERENCE, rule, "give the file as it was, or leave sha256 out", named)
    return {**raw, "study": {**study, "reference": {**reference, "file": path.as_posix(), "sha256": found}}}


def read_reference(
    reference: Mapping[str, object],
    bodies: Sequence[str],
    runs: Sequence[int],
    times: Sequence[float],
    samples: Mapping[str, np.ndarray],
) -> Truth:
    """The states of these bodies, runs and times; a ScenarioError where the file has others."""
    file = str(reference["file"])
    with _opened(REFERENCE, file) as ds:
        names = [name for name in STATE if name in ds]
        if "time" not in ds.coords or not names:
            raise _refused(file, f"has none of {listed(STATE)}", "give one with output.variables that has")
        rounded = [name for name in names if ds[name].dtype != np.float64]
        if rounded:
            raise _refused(file, f"has {listed(rounded)} in single precision", "leave out output.precision")
        found = [str(name) for name in ds["body"].values]
        if found != list(bodies):
            rule = f"has the bodies {listed(found)}, but the scenario {listed(bodies)}"
            raise _refused(file, rule, "give a dataset of this mechanism")
        ds = ds.isel(run=_runs(file, ds, runs, samples), time=_times(file, ds, times))
        return Truth({name: np.asarray(ds[name].values) for name in names}, {name: list(bodies) for name in names})


def _refused(file: str, rule: str, remedy: str) -> ScenarioError:
    return ScenarioError.at(REFERENCE, rule, remedy, file)


def _times(file: str, ds: "xr.Dataset", times: Sequence[float]) -> list[int]:
    """The index of each of these times."""
    found = []
    for time in times:
        index, same = _nearest(ds["time"].values, time, SAME)
        if not same:
            rule = f"has no state at t = {time!r}, where the study compares"
            raise _refused(file, rule, "store its states at all of output.every or output.times of the study")
        found.append(index)
    return found


def _runs(file: str, ds: "xr.Dataset", runs: Sequence[int], samples: Mapping[str, np.ndarray]) -> list[int]:
    """The index of each of these runs; of a file with one run, that one, if the study varies nothing."""
    labels = ds["run"].values.tolist()
    missing = [run for run in runs if run not in labels]
    if missing and len(labels) == 1 and not samples:
        return [0]
    if missing:
        rule = f"does not have run {missing[0]}, with which the study compares"
        raise _refused(file, rule, "make it with the same runs")
    found = [labels.index(run) for run in runs]
    for path, values in samples.items():
        if path not in ds.coords:
            raise _refused(file, f'does not vary "{path}", which the study varies', "make it with the same sweep")
        for run, mine, other in zip(runs, values, ds[path].values[found], strict=True):
            if not abs(mine - other) <= SAME * abs(mine):
                rule = f"has {path} = {other:.6g} in run {run}, but the study {mine:.6g}"
                raise _refused(file, rule, "make it with the same sweep and seed")
    return found
