"""Simulates the runs of a scenario: prepared portion by portion, compiled once, dealt out in chunks."""

from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from lienumba.batch.execute import Cost, Task, execute, tasks
from lienumba.batch.statuses import GOOD
from lienumba.engine.programs import batch_of, compiled_of
from lienumba.engine.results import Piece, Results
from lienumba.integrators.codes import RESELECT
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal, Prepared, prepare
from lienumba.store.shards import LABEL

if TYPE_CHECKING:
    from lienumba.batch.integrate import Chunk
    from lienumba.integrators.tracing.program import Outline

PORTION = 2**15  # runs of one body that are prepared at a time


@dataclass(frozen=True)
class Progress:
    """What a progress callable receives: the stage ("prepare", "compile" where needed, "run", "write"), and runs
    done and failed of total; those that go again are not yet done."""

    stage: str
    done: int
    total: int
    failed: int


Tell = Callable[[Progress], None]


@dataclass(frozen=True)
class Runs:
    """Runs to be simulated: labels (runs,), samples by path (runs,), and where the scenario starts."""

    labels: np.ndarray
    samples: dict[str, np.ndarray]
    nominal: Nominal

    def part(self, which: "slice | np.ndarray") -> "Runs":
        return Runs(self.labels[which], {path: x[which] for path, x in self.samples.items()}, self.nominal)

    def portions(self, bodies: int) -> "Iterator[Runs]":
        size = max(PORTION // bodies, 64)
        for first in range(0, len(self.labels), size):
            yield self.part(slice(first, first + size))


# compute(runs, fixed, report) yields what these runs give, each once, in any order; fixed: see
# `lienumba.integrators.tracing.program.build`; report(runs done) is called a few times per second; begin() where
# something has to be compiled.
Compute = Callable[[Runs, bool, Callable[[float], None], Callable[[], None]], Iterator[Piece]]


def simulate(
    runs: Runs, tell: Tell, compute: Compute, before: tuple[int, int] = (0, 0)
) -> Generator[Piece, None, None]:
    """Yield the runs as they finish; of each the status is final. before: runs done and failed already."""
    (done, failed), remaining = before, runs
    total, told, waiting = done + len(runs.labels), done, 0  # waiting: how many are to go again

    def report(count: float) -> None:
        nonlocal told
        told = max(told, done + int(count) - waiting)
        tell(Progress("run", told, total, failed))

    def compiling() -> None:
        tell(Progress("compile", done, total, failed))

    for fixed in (True, False):  # the few runs that need other constraint rows on their way go again, with all of them
        again: list[np.ndarray] = []
        for piece in compute(remaining, fixed, report, compiling):
            going = piece.codes == RESELECT
            failed += int(np.count_nonzero(~np.isin(piece.codes, GOOD) & ~going))
            if going.any():
                again.append(piece.tables["run"][LABEL][going])
                waiting += int(np.count_nonzero(going))
                piece = piece.of(~going)
            yield piece
        if not again:
            return
        remaining = remaining.part(np.isin(remaining.labels, np.concatenate(again)))
        done, waiting = total - len(remaining.labels), 0


@dataclass(frozen=True)
class Threads:
    """Computes on threads of this process.

    results: what is kept of runs; prepared: where portions come from, if they are known.
    """

    results: Results
    workers: int
    prepared: Callable[[Runs], Iterable[Prepared]] | None = None

    def __call__(
        self, runs: Runs, fixed: bool, report: Callable[[float], None], begin: Callable[[], None]
    ) -> Iterator[Piece]:
        prepared = iter((self.prepared or partial(portions, self.results.resolved))(runs))
        first = next(prepared)  # a sweep of which no run can be prepared ends here, before anything is compiled
        every = chunks(self.results, chain([first], prepared), fixed, self.workers, report, begin)
        return execute(every, self.workers, report)


def portions(resolved: Scenario, runs: Runs) -> Iterator[Prepared]:
    data = resolved.data
    for portion in runs.portions(len(data.model.bodies)):
        yield prepare(resolved, portion.labels.tolist(), portion.samples, runs.nominal, len(runs.labels))


def chunks(
    results: Results,
    portions: Iterable[Prepared],
    fixed: bool,
    workers: int,
    report: Callable[[float], None],
    begin: Callable[[], None] = lambda: None,
) -> Iterator[Task[Piece]]:
    """The chunks of all portions; the first of these is what is compiled, where it is not yet."""
    resolved = results.resolved
    if resolved.data.integrator.engine is not None:
        from lienumba.engine.reference import runs as reference  # Numba takes half a second

        yield from reference.chunks(results, portions, workers, begin)
        return
    program, cost = None, Cost()
    for prepared in portions:
        if program is None:
            program, machine = compiled_of(resolved, prepared, fixed, begin)
            report(0)
        batch = batch_of(resolved, prepared, program, machine)
        yield from tasks(batch, workers, partial(_piece, results, program, np.array(prepared.labels)), cost)


def _piece(results: Results, program: "Outline", labels: np.ndarray, chunk: "Chunk") -> Piece:
    return results.piece(chunk, program, labels[chunk.runs])
