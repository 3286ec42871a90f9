"""Computes runs on a cluster of dask: deals out chunks of them, a few more at a time than its workers can take.

Which worker computes a run changes nothing in its result. Workers may come and go: a chunk whose worker dies is dealt
out again.
"""

import secrets
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

from lienumba.engine.chunk_sizes import Dealt
from lienumba.engine.cluster import dask_worker
from lienumba.engine.cluster.connection import Connection
from lienumba.engine.results import Piece, Results
from lienumba.engine.simulate import Runs, portions
from lienumba.errors import ClusterError
from lienumba.scenario.resolve import Scenario

if TYPE_CHECKING:
    from distributed import Client, Future

DEATHS = 3  # times that the scheduler may give a chunk up, each after several workers have died under it
POLL = 0.1  # s between two looks at the cluster


@dataclass(frozen=True)
class Sent:
    """A chunk that is being computed, and how often it was given up before."""

    part: slice
    deaths: int = 0


class Cluster:
    """Computes on a cluster; given, workers: see `Connection`, which is made when there is something to compute."""

    def __init__(self, resolved: Scenario, given: "str | Client", workers: int) -> None:
        self.resolved, self.given, self.workers = resolved, given, workers
        self.shelf = [dask_worker.SHELF, secrets.token_hex(8)]
        self.versions = dask_worker.versions()

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        if "connection" in vars(self):
            self.connection.close()

    @cached_property
    def connection(self) -> Connection:
        connection = Connection(self.given, self.workers)
        connection.put(self.shelf, self.resolved.to_toml())
        return connection

    def __call__(
        self, runs: Runs, fixed: bool, report: Callable[[float], None], begin: Callable[[], None]
    ) -> Iterator[Piece]:
        """Workers compile on their own, of which nothing is told."""
        self._refuse_hopeless(runs)
        dealt, cluster = Dealt(len(runs.labels), self._run_bytes(runs)), self.connection
        active: dict[Future, Sent] = {}
        finished: SimpleQueue[Future] = SimpleQueue()
        done = 0

        def send(chunk: Sent) -> None:
            some = runs.part(chunk.part)
            future = cluster.submit(dask_worker.compute, self.shelf, self.versions, fixed, some.labels, some.samples)
            active[future] = chunk
            future.add_done_callback(finished.put)

        try:
            while active or dealt.more:
                while dealt.more and len(active) <= 2 * cluster.cores:  # more than can run, so that none waits
                    send(Sent(dealt.next(cluster.cores)))
                report(done)
                future = _next(finished)
                if future is None:
                    continue
                chunk, piece = active.pop(future), cluster.result(future)
                if piece is None:
                    send(self._again(chunk, runs))
                    continue
                dealt.learn(len(piece.codes), piece.seconds)
                done += len(piece.codes)
                yield piece
        finally:
            cluster.cancel(active)

    def _refuse_hopeless(self, runs: Runs) -> None:
        """Raise what is wrong with a sweep of which no run can be prepared; a chunk has too few to tell."""
        data = self.resolved.data
        if len(runs.labels) >= data.sweep.runs:
            next(portions(self.resolved, runs))

    def _run_bytes(self, runs: Runs) -> int:
        """What is sent for a run there and back."""
        results = Results(self.resolved, runs.nominal)
        return 8 * (1 + len(runs.samples)) + sum(results.dtype(table).itemsize for table in results.tables)

    def _again(self, chunk: Sent, runs: Runs) -> Sent:
        if chunk.deaths == DEATHS:
            first, last = runs.labels[chunk.part][[0, -1]]
            raise ClusterError(
                f"{self.connection.where}: every worker that took the runs {first} to {last} has died; look at what "
                "the workers say, they may need more memory"
            )
        return Sent(chunk.part, chunk.deaths + 1)


def _next(finished: "SimpleQueue[Future]") -> "Future | None":
    try:
        return finished.get(timeout=POLL)
    except Empty:
        return None
