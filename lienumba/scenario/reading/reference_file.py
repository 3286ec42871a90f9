"""A reference in a file: a dataset that `lienumba run` wrote, with the same bodies and runs and at least the times."""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.tables import check_file
from lienumba.scenario.study_errors import STATE, Truth
from lienumba.words import listed, show

if TYPE_CHECKING:
    import xarray as xr

AT = "study.reference.file"
SAME = 1e-12  # relative: times and samples nearer to each other are the same


def marked(raw: Keys, folder: Path) -> Keys:
    """The scenario with the path of the file of its reference, which is relative to this folder, and its checksum."""
    study = raw.get("study")
    reference = study.get("reference") if isinstance(study, dict) else None
    if not isinstance(study, dict) or not isinstance(reference, dict) or not isinstance(reference.get("file"), str):
        return raw
    path, named = folder / reference["file"], reference["file"]
    check_file(AT, path, named)
    with path.open("rb") as file:
        found = hashlib.file_digest(file, "sha256").hexdigest()
    if reference.get("sha256", found) != found:
        raise ScenarioError.at(
            AT,
            f"has changed since sha256 = {show(reference['sha256'])} was written",
            "give the file as it was, or leave sha256 out",
            named,
        )
    return {**raw, "study": {**study, "reference": {**reference, "file": path.as_posix(), "sha256": found}}}


def read(
    reference: Mapping[str, object],
    bodies: Sequence[str],
    runs: Sequence[int],
    times: Sequence[float],
    samples: "Mapping[str, np.ndarray]",
) -> Truth:
    """The states of these bodies, runs and times; a ScenarioError where the file has others."""
    from lienumba.store.files import read as opened

    file = str(reference["file"])
    try:
        dataset = opened(Path(file))
    except ScenarioError as error:
        raise error.inside(f"{AT} = {show(file)}") from None
    with dataset as ds:
        names = [name for name in STATE if name in ds]
        if "time" not in ds.coords or not names:
            raise ScenarioError.at(AT, f"has none of {listed(STATE)}", "give one with output.variables that has", file)
        rounded = [name for name in names if ds[name].dtype != np.float64]
        if rounded:
            raise ScenarioError.at(AT, f"has {listed(rounded)} in single precision", "leave out output.precision", file)
        _check_bodies(file, ds, bodies)
        ds = ds.isel(run=_runs(file, ds, runs, samples), time=_times(file, ds, times))
        return Truth({name: np.asarray(ds[name].values) for name in names}, {name: list(bodies) for name in names})


def _check_bodies(file: str, ds: "xr.Dataset", bodies: Sequence[str]) -> None:
    found = [str(name) for name in ds["body"].values]
    if found != list(bodies):
        raise ScenarioError.at(
            AT,
            f"has the bodies {listed(found)}, but the scenario {listed(bodies)}",
            "give a dataset of this mechanism",
            file,
        )


def _times(file: str, ds: "xr.Dataset", times: Sequence[float]) -> list[int]:
    """The index of each of these times."""
    known = ds["time"].values
    found = [int(np.argmin(np.abs(known - time))) for time in times]
    for time, index in zip(times, found, strict=True):
        if not abs(known[index] - time) <= SAME * max(abs(time), 1.0):
            raise ScenarioError.at(
                AT,
                f"has no state at t = {time!r}, where the study compares",
                "store its states at all of output.every or output.times of the study",
                file,
            )
    return found


def _runs(file: str, ds: "xr.Dataset", runs: Sequence[int], samples: "Mapping[str, np.ndarray]") -> list[int]:
    """The index of each of these runs; of a file with one run, that one, if the study varies nothing."""
    labels = ds["run"].values.tolist()
    missing = [run for run in runs if run not in labels]
    if missing and len(labels) == 1 and not samples:
        return [0]
    if missing:
        raise ScenarioError.at(
            AT, f"does not have run {missing[0]}, with which the study compares", "make it with the same runs", file
        )
    found = [labels.index(run) for run in runs]
    for path, values in samples.items():
        theirs = ds[path].values[found] if path in ds.coords else None
        if theirs is None:
            raise ScenarioError.at(
                AT, f'does not vary "{path}", which the study varies', "make it with the same sweep", file
            )
        for run, mine, other in zip(runs, values, theirs, strict=True):
            if not abs(mine - other) <= SAME * abs(mine):
                raise ScenarioError.at(
                    AT,
                    f"has {path} = {other:.6g} in run {run}, but the study {mine:.6g}",
                    "make it with the same sweep and seed",
                    file,
                )
    return found
