"""Simulates the runs of a scenario: prepared portion by portion, compiled once, dealt out in chunks, kept in memory."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from lienumba.batch.execute import Cost, Task, execute, tasks
from lienumba.batch.integrate import Chunk
from lienumba.batch.statuses import GOOD
from lienumba.engine.programs import batch_of, compiled_of, method_of, selection_of
from lienumba.engine.results import Piece, Results
from lienumba.integrators.codes import RESELECT
from lienumba.integrators.tracing.program import Outline
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal, Prepared, prepare
from lienumba.store.layout import FULL
from lienumba.store.shards import LABEL

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

    def part(self, which: slice | np.ndarray) -> "Runs":
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

        shaped = ((x, method_of(resolved, x.model), selection_of(resolved, x)) for x in portions)
        yield from reference.chunks(results, shaped, workers, begin)
        return
    program, cost = None, Cost()
    for prepared in portions:
        if program is None:
            program, machine = compiled_of(resolved, prepared, fixed, begin)
            report(0)
        batch = batch_of(resolved, prepared, program, machine)
        yield from tasks(batch, workers, partial(_piece, results, program, prepared, fixed), cost)


def _piece(results: Results, program: "Outline", prepared: Prepared, fixed: bool, chunk: "Chunk") -> Piece:
    if results.derivatives is not None:
        chunk = replace(chunk, tangents=results.derivatives.of(prepared, chunk.runs, chunk.codes, fixed))
    return results.piece(chunk, program, np.array(prepared.labels)[chunk.runs])


class Memory:
    """Keeps what runs give, for datasets that are not written and for the points of a study.

    arrays: what was taken, by variable, in the order of the labels; seconds: that cores were busy with it.
    """

    def __init__(self, labels: Sequence[int]) -> None:
        self.labels = np.asarray(labels, np.int64)
        self.arrays: dict[str, np.ndarray] = {}
        self.seconds = 0.0
        self._full: list[np.ndarray] = []

    def take(self, piece: Piece) -> None:
        self.seconds += piece.seconds
        records = piece.tables["run"]
        rows = positions(self.labels, records[LABEL])
        for name in _fields(records):
            if name not in self.arrays:
                self.arrays[name] = np.empty((len(self.labels), *records.dtype[name].shape), records.dtype[name].base)
            self.arrays[name][rows] = records[name]
        if FULL in piece.tables:
            self._full.append(piece.tables[FULL])

    def columns(self, kept: np.ndarray) -> dict[str, np.ndarray]:
        """Every column of every table, of the runs (a mask) that are kept."""
        arrays = self.arrays if kept.all() else {name: x[kept] for name, x in self.arrays.items()}
        if not self._full:
            return arrays
        records = np.concatenate(self._full)
        records = records[np.isin(records[LABEL], self.labels[kept])]
        records = records[np.argsort(positions(self.labels, records[LABEL]))]
        return arrays | {name: np.ascontiguousarray(records[name]) for name in _fields(records)}

    def column(self, name: str, labels: np.ndarray) -> np.ndarray:
        """The values of a variable of these runs."""
        return self.arrays[name][positions(self.labels, labels)]


def _fields(records: np.ndarray) -> list[str]:
    names: Any = records.dtype.names
    return [name for name in names if name != LABEL]


def positions(labels: np.ndarray, some: np.ndarray) -> np.ndarray:
    """Where each of some labels stands among all."""
    order = np.argsort(labels, kind="stable")
    found: np.ndarray = order[np.searchsorted(labels, some, sorter=order)]
    return found
