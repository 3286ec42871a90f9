"""A sweep on the disk: its shards, the dataset that was finished before, and the one that comes of both."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.results import Results
from lienumba.scenario.resume import check_same
from lienumba.scenario.simulate import Runs
from lienumba.store import stream
from lienumba.store.files import folder_of, read
from lienumba.store.finished import Finished
from lienumba.store.layout import FULL
from lienumba.store.shards import Shards
from lienumba.store.stream import Source


@dataclass(frozen=True)
class Stored:
    """What there is of a sweep whose dataset will be `target`."""

    target: Path
    shards: Shards
    finished: Finished | None

    def sources(self, table: str) -> list[Source]:
        older = self.finished.tables.get(table) if self.finished else None
        return [*self.shards.sources(table), *([older] if older is not None else [])]

    @property
    def labels(self) -> np.ndarray:
        """The runs that are there, ascending."""
        every = [source.labels for source in self.sources("run")]
        return np.unique(np.concatenate(every)).astype(np.int64) if every else np.empty(0, np.int64)

    def column(self, name: str) -> np.ndarray:
        """What these runs have of a variable."""
        every = stream.pieces(self.labels, self.sources("run"))
        return np.concatenate([np.empty(0), *(piece.source.read(piece.part)[name] for piece in every)])

    def failed(self) -> int:
        """How many of these failed."""
        return int(np.count_nonzero(~np.isin(self.column("status"), GOOD)))

    def write(self, resolved: Scenario, runs: Runs, tell: Callable[[int], None], **more: str) -> None:
        """Write the dataset of these runs, all of which are there; then the shards have done their work. more:
        attributes of the dataset."""
        results = Results(resolved, runs.nominal)
        frame = results.frame(runs.samples, len(runs.labels), **more)
        labels = {"run": runs.labels, FULL: runs.labels[results.in_full(runs.labels)]}
        kept = {name: x for name, x in labels.items() if name in results.tables}
        tables = {name: stream.pieces(x, self.sources(name)) for name, x in kept.items()}
        stream.write(frame, {**kept, **runs.samples}, tables, self.target, tell)
        self.shards.remove()


@contextmanager
def stored(target: Path, resolved: Scenario, resume: bool) -> Iterator[Stored]:
    """What there is already, if it is to go on; a ScenarioError if that is of another sweep."""
    shards, finished = Shards(target), None
    if not resume and folder_of(target).exists():
        shutil.rmtree(folder_of(target))
    try:
        if resume and shards.exists:
            check_same(shards.load(), resolved, str(shards.folder))
        if resume and target.exists():
            read(target).close()  # which refuses what is none
            finished = Finished(target)
            check_same(finished.attributes, resolved, str(target))
        there = Stored(target, shards, finished)
        _check_room(there, resolved)
        yield there
    finally:
        shards.close()
        if finished is not None:
            finished.close()


def _check_room(there: Stored, resolved: Scenario) -> None:
    """No run that is there may be lost."""
    data: Any = resolved.data
    labels = there.labels
    if len(labels) and labels[-1] >= data.sweep.runs:
        raise ScenarioError(
            f"{there.target}: has runs up to {labels[-1]} already, but sweep.runs = {data.sweep.runs}; give at least "
            f"{labels[-1] + 1}, or start again with --overwrite"
        )
