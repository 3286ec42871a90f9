"""A sweep on the disk: its shards, the dataset that was finished before, and the one that comes of both."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from lienumba.batch.statuses import GOOD
from lienumba.engine.disk.background_writer import Sources
from lienumba.engine.disk.resume import check_same
from lienumba.engine.results import Results, in_full
from lienumba.engine.simulate import Runs
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import Scenario
from lienumba.store.files import read
from lienumba.store.finished import Finished, OpenFiles
from lienumba.store.layout import FULL
from lienumba.store.outputs import Output
from lienumba.store.shards import Shards, labels_of
from lienumba.store.stream import Source
from lienumba.words import option


@dataclass(frozen=True)
class SweepFiles:
    """What there is of a sweep that becomes `output`."""

    resolved: Scenario
    output: Output
    shards: Shards
    finished: Finished | None

    def of(self, table: str) -> list[Source]:
        """Where runs of a table are."""
        older = self.finished.tables.get(table) if self.finished else None
        return [*self.shards.sources(table), *([older] if older is not None else [])]

    def sources(self, tables: Iterable[str]) -> Sources:
        return {table: self.of(table) for table in tables}

    @property
    def labels(self) -> np.ndarray:
        """The runs that are there, ascending; with their courses, if these are kept."""
        runs = labels_of(self.of("run"))
        return runs[~in_full(self.resolved, runs) | np.isin(runs, labels_of(self.of(FULL)))]

    @property
    def older(self) -> np.ndarray:
        """The runs of the dataset that was finished before."""
        return self.finished.tables["run"].labels if self.finished else np.empty(0, np.int64)

    def column(self, name: str, labels: np.ndarray) -> np.ndarray:
        """The values of a variable of these runs (ascending)."""
        found: np.ndarray | None = None
        for source in reversed(self.of("run")):
            own = np.isin(source.labels, labels)
            if own.any():
                values = source.column(name)[own]
                found = np.empty((len(labels), *values.shape[1:]), values.dtype) if found is None else found
                found[np.searchsorted(labels, source.labels[own])] = values
        return np.empty(0) if found is None else found

    def samples(self, runs: Runs) -> Runs:
        """These runs with the samples that those had that were finished before, whoever drew them."""
        if self.finished is None:
            return runs
        had, rows = self.finished.inputs, np.searchsorted(runs.labels, self.older)
        samples = {path: x.copy() for path, x in runs.samples.items()}
        for path in samples.keys() & had.keys():
            samples[path][rows] = had[path]
        return replace(runs, samples=samples)

    def failed(self) -> int:
        """How many of these failed."""
        return int(np.count_nonzero(~np.isin(self.column("status", self.labels), GOOD)))


class Arrived:
    """Which of the runs (labels, ascending) have arrived, of which the finished ones were there before."""

    def __init__(self, labels: np.ndarray, finished: np.ndarray) -> None:
        self.labels, self.first = labels, 0
        self.there = np.isin(labels, finished)

    def take(self, labels: np.ndarray) -> None:
        self.there[np.searchsorted(self.labels, labels)] = True

    def prefix(self, most: int) -> int:
        """How many of the first so many runs are there up to one that is not."""
        rest = self.there[self.first :]
        self.first = len(self.there) if rest.all() else self.first + int(rest.argmin())
        return min(self.first, most)


@contextmanager
def sweep_files(output: Output, results: Results, resume: bool) -> Iterator[SweepFiles]:
    """What there is already, if it is to go on; a ScenarioError if that is of another sweep."""
    shards, finished, replaced, resolved = Shards(output), None, False, results.resolved
    opened = OpenFiles()
    try:
        if resume and shards.exists:
            manifest = shards.load()
            check_same(manifest, resolved, str(shards.named))
            shards.take_over({table: results.dtype(table) for table in results.tables})
            replaced = bool(manifest.get("overwrites"))
        if resume and output.target.exists() and not replaced:
            read(output.path).close()  # which refuses what is none
            finished = Finished(output.path, opened)
            check_same(finished.attributes, resolved, str(output.path))
            finished.check({table: results.dtype(table) for table in results.tables}, str(output.path))
        there = SweepFiles(resolved, output, shards, finished)
        check_room(str(output.path), there.labels, resolved.data.sweep.runs)
        yield there
    finally:
        opened.close()


def check_room(path: str, labels: np.ndarray, runs: int) -> None:
    """A ScenarioError if a sweep of so many `runs` has no place for one that the dataset has (labels, ascending)."""
    if len(labels) and labels[-1] >= runs:
        raise ScenarioError(
            f"{path}: has runs up to {labels[-1]} already, but sweep.runs = {runs}; give at least {labels[-1] + 1}, or "
            f"start again with {option('overwrite')}"
        )
