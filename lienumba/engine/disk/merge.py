"""Datasets of parts of a sweep become the dataset of the whole, which never is in memory."""

import glob
import os
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba import __version__
from lienumba.engine.cores import usable_cores
from lienumba.engine.disk.resume import check_parts
from lienumba.engine.progress import shown
from lienumba.engine.quality import result_warnings
from lienumba.engine.requirements import attributes
from lienumba.engine.results import Results
from lienumba.engine.simulate import Progress, Runs, Tell
from lienumba.errors import ScenarioError
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.resolve import resolve, written_tables
from lienumba.scenario.start.prepare import check_initial
from lienumba.store.files import read
from lienumba.store.finished import Finished, RecordColumns
from lienumba.store.form import scenario_tables
from lienumba.store.outputs import Output
from lienumba.store.refusals import damaged
from lienumba.store.shards import Shards
from lienumba.store.stream import Stream, slices
from lienumba.store.study_layout import is_study
from lienumba.store.targets import claimed_dataset
from lienumba.words import plural

if TYPE_CHECKING:
    import xarray as xr

OPEN = 8  # files that are open at the same time
SHOWN = 5  # ranges of labels in a sentence

Paths = Sequence[str | os.PathLike[str]]


def merge(
    files: Paths,
    output: str | os.PathLike[str],
    *,
    allow_code: bool = False,
    overwrite: bool = False,
    progress: Tell | bool | None = None,
) -> "xr.Dataset":
    """Write the runs of datasets of one sweep into one dataset, and return it.

    Runs that none of them has are a warning; `run(..., resume=True)` adds them.

    Parameters
    ----------
    files : sequence of paths
        Datasets, or patterns such as "part*.nc".
    output : path
        The netCDF file to write.
    allow_code : bool
        Run the Python code that they bring, without which it is not known what their dataset looks like.
    overwrite : bool
        Whether `output` may be replaced.
    progress : callable or bool, optional
        As for `lienumba.run`.

    Returns
    -------
    xarray.Dataset
        The dataset, read from the file when values are asked for.

    Raises
    ------
    ScenarioError
        Where datasets do not belong together or have runs in common, before anything is written.
    """
    with shown(progress) as tell:
        dataset = merged(files, Path(output), allow_code, overwrite, tell)
    for sentence in gaps(dataset):
        warnings.warn(sentence, stacklevel=2)
    return dataset


def merged(files: Paths, target: Path, allow_code: bool, overwrite: bool, tell: Tell) -> "xr.Dataset":
    """As `merge`, which tells what is missing, too."""
    paths = _paths(files)
    if any(path.resolve() == target.resolve() for path in paths):
        raise ScenarioError(f"output = {target}: is one of the datasets to be merged; choose another name")
    with claimed_dataset(target, overwrite) as output:
        parts = [PartialDataset.of(path) for path in paths]
        _check(parts)
        check_allowed(parts[0].scenario, str(parts[0].path), "merging", allow_code)
        _write(parts, output, tell)
        Shards(output).remove()
        return read(output.target)


def gaps(dataset: "xr.Dataset") -> list[str]:
    """A sentence about runs of the sweep that a dataset does not have."""
    sweep = _sweep(written_tables(dataset, "the dataset"))
    total = sweep["runs"]
    missing = np.setdiff1d(np.arange(-1 if sweep["nominal"] else 0, total), dataset["run"].values)
    if not len(missing):
        return []
    return [
        f"{plural(len(missing), 'run is', 'runs are')} missing of {total}: {_ranges(missing)}; add them by "
        "lienumba run --resume, or merge the datasets that have them, too"
    ]


@dataclass(frozen=True)
class PartialDataset:
    """A dataset: labels of its tables (runs,), samples (runs,) by path."""

    path: Path
    attributes: dict[str, Any]
    scenario: Keys
    labels: dict[str, np.ndarray]
    inputs: dict[str, np.ndarray]

    @property
    def sweep(self) -> dict[str, Any]:
        """The section of the sweep that it is of."""
        return _sweep(self.scenario)

    @classmethod
    def of(cls, path: Path) -> "PartialDataset":
        with read(path) as dataset:  # which refuses what is none
            if is_study(dataset):
                raise ScenarioError(f"{path}: is a study, which is never in parts; give datasets of sweeps")
            written_tables(dataset, str(path))  # which refuses what is none
            scenario = scenario_tables(dataset, str(path))
        file = Finished(path)
        try:
            return cls(path, file.attributes, scenario, {dim: x.labels for dim, x in file.tables.items()}, file.inputs)
        finally:
            file.close()


class OpenFiles:
    """Files that are open, the one that was read last at the end."""

    def __init__(self) -> None:
        self.files: dict[Path, Finished] = {}

    def __call__(self, path: Path) -> Finished:
        if len(self.files) >= OPEN and path not in self.files:
            self.files.pop(next(iter(self.files))).close()
        file = self.files.pop(path, None) or Finished(path)
        self.files[path] = file
        return file

    def close(self) -> None:
        for file in self.files.values():
            file.close()


@dataclass
class LazyTable:
    """A table of a dataset, which is opened when it is read."""

    opened: OpenFiles
    path: Path
    dim: str
    labels: np.ndarray

    def read(self, part: slice) -> RecordColumns:
        return self.opened(self.path).tables[self.dim].read(part)

    def column(self, name: str) -> np.ndarray:
        return self.opened(self.path).tables[self.dim].column(name)


def _paths(files: Paths) -> list[Path]:
    """The files that are named; a pattern that the shell has left as it is names all that match."""
    several = isinstance(files, Iterable) and not isinstance(files, str)
    if not several or not all(isinstance(file, str | os.PathLike) for file in files):
        raise ScenarioError.at("files", "must be paths in a list", 'give such as ["a.nc", "b.nc"]', files)
    found: list[Path] = []
    for name in (os.fspath(file) for file in files):
        matching = [name] if os.path.exists(name) or not glob.has_magic(name) else sorted(glob.glob(name))
        if not matching:
            raise ScenarioError(f"{name}: matches no file; check the pattern")
        found += map(Path, matching)
    for path in (path for n, path in enumerate(found) if path in found[:n]):
        raise ScenarioError(f"{path}: is named twice; name each dataset once")
    if not found:
        raise ScenarioError("no dataset is named; give those that are to be merged, such as part*.nc")
    return found


def _check(parts: Sequence[PartialDataset]) -> None:
    """They must be of one sweep and of this version, and no run may be in two of them."""
    first = parts[0]
    if first.attributes["lienumba_version"] != __version__:
        raise ScenarioError(
            f"{first.path}: was made by lienumba {first.attributes['lienumba_version']}, but this is {__version__}; "
            "merge with that version"
        )
    if "stop" in first.sweep:
        raise ScenarioError(
            f"{first.path}: is of a sweep that ends by sweep.stop, which only the whole can decide; go on with it by "
            "lienumba run --resume"
        )
    for part in parts[1:]:
        check_parts(part.attributes, first.attributes, str(part.path), str(first.path))
        if part.inputs.keys() != first.inputs.keys() or part.labels.keys() != first.labels.keys():
            raise damaged(str(part.path), f"it has other inputs or tables than {first.path}")
    labels = np.concatenate([part.labels["run"] for part in parts])
    owners = np.repeat(np.arange(len(parts)), [len(part.labels["run"]) for part in parts])
    order = np.argsort(labels, kind="stable")
    labels, owners = labels[order], owners[order]
    twice = np.flatnonzero(labels[1:] == labels[:-1])
    if len(twice):
        a, b = owners[twice[0]], owners[twice[0] + 1]
        both = labels[twice[(owners[twice] == a) & (owners[twice + 1] == b)]]
        raise ScenarioError(f"{parts[a].path} and {parts[b].path} both have {_named(both)}; leave one of them out")


def _write(parts: Sequence[PartialDataset], output: Output, tell: Tell) -> None:
    """Write the dataset of all their runs."""
    whole = max(parts, key=lambda part: int(part.sweep["runs"]))
    resolved = resolve(whole.scenario)
    labels = np.concatenate([part.labels["run"] for part in parts])
    order = np.argsort(labels)
    samples = {path: np.concatenate([part.inputs[path] for part in parts])[order] for path in parts[0].inputs}
    results = Results(resolved, check_initial(resolved))
    opened, stream = OpenFiles(), Stream(results.frame(samples, len(labels)), output, usable_cores())
    try:
        for part in parts:
            opened(part.path).check({table: results.dtype(table) for table in results.tables}, str(part.path))
            for dim, wanted in results.labels(part.labels["run"]).items():
                if len(lost := np.setdiff1d(wanted, part.labels[dim])):
                    raise damaged(str(part.path), f"it has lost the course of {_named(lost)}")
        columns = results.labels(labels[order])
        for dim, own in columns.items():
            sources = [LazyTable(opened, part.path, dim, part.labels[dim]) for part in parts]
            told = partial(_tell, tell, len(own)) if dim == "run" else lambda done: None
            stream.put(dim, slices(own, sources), told)

        def column(name: str, place: tuple[int, ...]) -> np.ndarray:
            every: Any = np.concatenate([opened(part.path).tables["run"].column(name) for part in parts])
            found: np.ndarray = every[(order, *place)]
            return found

        def some(name: str, which: np.ndarray) -> np.ndarray:
            return column(name, ())[np.isin(labels[order], which)]

        runs = Runs(labels[order], samples, check_initial(resolved))
        said = attributes(resolved, runs.labels, column) | result_warnings.attributes(resolved, runs, some)
        stream.finish(columns | samples, said)
    finally:
        stream.discard()
        opened.close()


def _tell(tell: Tell, total: int, done: int) -> None:
    tell(Progress("write", done, total, 0))


def _sweep(scenario: Keys) -> dict[str, Any]:
    return {"runs": 1, "nominal": False, **table_in(scenario, "sweep")}


def _named(labels: np.ndarray) -> str:
    return f"run {labels[0]}" if len(labels) == 1 else f"the runs {_ranges(labels)}"


def _ranges(labels: np.ndarray) -> str:
    """Labels (ascending) as --runs takes them, the first few ranges."""
    bounds = [0, *(np.flatnonzero(np.diff(labels) > 1) + 1).tolist(), len(labels)]
    found = [(int(labels[a]), int(labels[b - 1]) + 1) for a, b in pairwise(bounds)]
    shown = [str(a) if b == a + 1 else f"{a}:{b}" for a, b in found[:SHOWN]]
    return ",".join(shown) + (f" and {len(found) - SHOWN} more ranges" if len(found) > SHOWN else "")
