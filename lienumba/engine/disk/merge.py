"""Datasets of parts of a sweep become the dataset of the whole, which never is in memory."""

import glob
import os
import warnings
from collections.abc import Iterable, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba import __version__
from lienumba.batch.execute import usable_cores
from lienumba.engine.disk.resume import check_parts
from lienumba.engine.progress import shown
from lienumba.engine.quality import result_warnings
from lienumba.engine.results import Results
from lienumba.engine.simulate import Progress, Runs, Tell
from lienumba.errors import ScenarioError
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.resolve import resolve, written_tables
from lienumba.scenario.start.prepare import check_initial
from lienumba.store.files import read
from lienumba.store.finished import Finished, OpenFiles
from lienumba.store.form import scenario_tables
from lienumba.store.outputs import Output
from lienumba.store.refusals import damaged
from lienumba.store.shards import Shards
from lienumba.store.stream import Stream, slices
from lienumba.store.study_layout import is_study
from lienumba.store.targets import claimed_dataset
from lienumba.words import option, plural

if TYPE_CHECKING:
    import xarray as xr

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
        opened = OpenFiles()
        try:
            parts = [_part(path, opened) for path in paths]
            _check(parts)
            check_allowed(_scenario(parts[0]), str(parts[0].path), "merging", allow_code)
            _write(parts, output, tell)
        finally:
            opened.close()
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
        f"{plural(len(missing), 'run is', 'runs are')} missing of {total}: {_ranges(missing)}; run them "
        f"with {option('resume')}, or merge the datasets that have them, too"
    ]


def _part(path: Path, opened: OpenFiles) -> Finished:
    """A dataset of a sweep; a ScenarioError for any other file."""
    with read(path) as dataset:
        if is_study(dataset):
            raise ScenarioError(f"{path}: is a study, which is never in parts; give datasets of sweeps")
        written_tables(dataset, str(path))  # which refuses what is none
    return Finished(path, opened)


def _scenario(part: Finished) -> Keys:
    """Of the sweep that a dataset is a part of."""
    return scenario_tables(part.attributes, str(part.path))


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


def _check(parts: Sequence[Finished]) -> None:
    """They must be of one sweep and of this version, and no run may be in two of them."""
    first = parts[0]
    if first.attributes["lienumba_version"] != __version__:
        raise ScenarioError(
            f"{first.path}: was made by lienumba {first.attributes['lienumba_version']}, but this is {__version__}; "
            "merge with that version"
        )
    if "stop" in _sweep(_scenario(first)):
        raise ScenarioError(
            f"{first.path}: is of a sweep that ends by sweep.stop, which only the whole can decide; run it on "
            f"with {option('resume')}"
        )
    for part in parts[1:]:
        check_parts(part.attributes, first.attributes, str(part.path), str(first.path))
        if part.inputs.keys() != first.inputs.keys() or part.tables.keys() != first.tables.keys():
            raise damaged(str(part.path), f"it has other inputs or tables than {first.path}")
    own = [part.tables["run"].labels for part in parts]
    labels, owners = np.concatenate(own), np.repeat(np.arange(len(parts)), [*map(len, own)])
    order = np.argsort(labels, kind="stable")
    labels, owners = labels[order], owners[order]
    twice = np.flatnonzero(labels[1:] == labels[:-1])
    if len(twice):
        a, b = owners[twice[0]], owners[twice[0] + 1]
        both = labels[twice[(owners[twice] == a) & (owners[twice + 1] == b)]]
        raise ScenarioError(f"{parts[a].path} and {parts[b].path} both have {_named(both)}; leave one of them out")


def _write(parts: Sequence[Finished], output: Output, tell: Tell) -> None:
    """Write the dataset of all their runs."""
    resolved = resolve(max(map(_scenario, parts), key=lambda scenario: int(_sweep(scenario)["runs"])))
    every = np.concatenate([part.tables["run"].labels for part in parts])
    order = np.argsort(every)
    labels = every[order]
    samples = {path: np.concatenate([part.inputs[path] for part in parts])[order] for path in parts[0].inputs}
    results = Results(resolved, check_initial(resolved))
    stream = Stream(results.frame(samples, len(labels)), output, usable_cores())
    try:
        for part in parts:
            part.check({table: results.dtype(table) for table in results.tables}, str(part.path))
            for dim, wanted in results.labels(part.tables["run"].labels).items():
                if len(lost := np.setdiff1d(wanted, part.tables[dim].labels)):
                    raise damaged(str(part.path), f"it has lost the course of {_named(lost)}")
        columns = results.labels(labels)
        for dim, own in columns.items():
            told = partial(_tell, tell, len(own)) if dim == "run" else lambda done: None
            stream.put(dim, slices(own, [part.tables[dim] for part in parts]), told)

        def column(name: str, which: np.ndarray) -> np.ndarray:
            whole = np.concatenate([part.tables["run"].column(name) for part in parts])
            found: np.ndarray = whole[order][np.isin(labels, which)]
            return found

        runs = Runs(labels, samples, check_initial(resolved))
        said = result_warnings.attributes(resolved, runs, column)
        stream.finish(columns | samples, said)
    finally:
        stream.discard()


def _sweep(scenario: Keys) -> dict[str, Any]:
    return {"runs": 1, "nominal": False, **table_in(scenario, "sweep")}


def _tell(tell: Tell, total: int, done: int) -> None:
    tell(Progress("write", done, total, 0))


def _named(labels: np.ndarray) -> str:
    return f"run {labels[0]}" if len(labels) == 1 else f"the runs {_ranges(labels)}"


def _ranges(labels: np.ndarray) -> str:
    """Labels (ascending) as --runs takes them, the first few ranges."""
    bounds = [0, *(np.flatnonzero(np.diff(labels) > 1) + 1).tolist(), len(labels)]
    found = [(int(labels[a]), int(labels[b - 1]) + 1) for a, b in pairwise(bounds)]
    shown = [str(a) if b == a + 1 else f"{a}:{b}" for a, b in found[:SHOWN]]
    return ",".join(shown) + (f" and {len(found) - SHOWN} more ranges" if len(found) > SHOWN else "")
