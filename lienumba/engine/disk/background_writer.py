"""Writes the dataset of a sweep while it is computed: what is safe in shards, in the order of the runs, on a thread of
its own. If that fails, the sweep goes on all the same, and the dataset is written from the shards in the end."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np

from lienumba.store.outputs import LostError, TakenError, WriteError
from lienumba.store.stream import Source, Stream, slices
from lienumba.words import option

Sources = dict[str, list[Source]]  # of each table


class BackgroundWriter:
    """labels: of each table, ascending; `written`: how many of these records are in the stream."""

    def __init__(self, begin: Callable[[], Stream], labels: Mapping[str, np.ndarray], pool: ThreadPoolExecutor) -> None:
        self.begin, self.labels, self.pool = begin, labels, pool
        self.stream: Stream | None = None
        self.written = dict.fromkeys(labels, 0)
        self.going = True  # whether what can be written ahead is
        self.busy: Future[None] | None = None

    def follow(self, runs: int, sources: Sources) -> None:
        """Write the first so many runs, all of which are there, unless the last part is not yet written."""
        if self.going and (self.busy is None or self.busy.done()):
            self._wait()
            if self.going and runs > self.written["run"]:
                self.busy = self.pool.submit(self._write, runs, sources)

    def finish(
        self, labels: Mapping[str, np.ndarray], sources: Sources, columns: Mapping[str, np.ndarray],
        attributes: Mapping[str, str], tell: Callable[[int], None],
    ) -> None:  # fmt: skip
        """Write what is left of these records (their labels begin as those that are written), and the rest."""
        self._wait()
        self.labels = labels
        try:
            self._write(len(labels["run"]), sources, tell)
            assert self.stream is not None
            self.stream.finish({**labels, **columns}, attributes)
        except (LostError, TakenError):
            raise
        except WriteError as error:
            raise WriteError(f"{error}; no run is lost, go on with {option('resume')}") from None

    def _write(self, runs: int, sources: Sources, tell: Callable[[int], None] = lambda runs: None) -> None:
        if self.stream is None:
            self.stream = self.begin()
        limit = self.labels["run"][runs - 1] if runs else -np.inf
        for table, labels in self.labels.items():
            first, last = self.written[table], int(np.searchsorted(labels, limit, side="right"))
            told = tell if table == "run" else lambda runs: None
            self.stream.put(table, slices(labels[first:last], sources[table]), told, first)
            self.written[table] = last

    def _wait(self) -> None:
        """For the thread; where it has failed, everything is written in the end."""
        try:
            if self.busy is not None:
                self.busy.result()
        except WriteError:
            self.stream, self.going = None, False
            self.written = dict.fromkeys(self.labels, 0)
        self.busy = None


@contextmanager
def background_writer(begin: Callable[[], Stream], labels: Mapping[str, np.ndarray]) -> Iterator[BackgroundWriter]:
    """A dataset that begins when something of it can be written, and in the end is there whole or not at all."""
    pool = ThreadPoolExecutor(1)
    pool.submit(int).result()  # a thread whose start is interrupted is one that nobody waits for
    dataset = BackgroundWriter(begin, labels, pool)
    try:
        yield dataset
    finally:
        pool.shutdown()
        if dataset.stream is not None:
            dataset.stream.discard()
