"""Tasks on a pool of threads, a few more at a time than can run.

The kernels release the interpreter, so plain threads share the cores. How runs are dealt out changes nothing in any
run's result.
"""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from time import thread_time
from typing import Generic, TypeVar

import numpy as np

from lienumba.batch.integrate import Batch, Chunk, integrate
from lienumba.compiler.rows import W
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import element_rows

CHUNK_BYTES = 8 * 2**20  # of records in one chunk
CHUNKS_PER_WORKER = 10  # so that the cores finish together and progress moves
LONG_CHUNKS_PER_WORKER = 3  # where lanes are filled again: only the end of a chunk leaves some empty
SECONDS = 2.0  # that a chunk should take: what is in flight is lost if the process is killed
FIRST_BLOCKS = 4  # of a chunk whose cost is not known
POLL = 0.1  # s between two looks at the progress
BRIEF = 20_000  # steps of a block and body, some 10 ms

T = TypeVar("T")


@dataclass(frozen=True)
class Task(Generic[T]):
    """work(progress, stop) integrates so many runs; progress[0] grows to `whole`, stop[0] is set from outside; brief:
    whether an interrupt may wait for its end."""

    runs: int
    whole: int
    work: Callable[[np.ndarray, np.ndarray], T]
    brief: bool = False


@dataclass
class Cost:
    """per_run: how long (s) a core was busy with a run of the chunk that ended last."""

    per_run: float | None = None


def execute(tasks: Iterable[Task[T]], workers: int, report: Callable[[float], None]) -> Iterator[T]:
    """Yield what the tasks give as they finish. `report(runs done)` is called a few times per second.

    Tasks are taken when they are needed, which may prepare them while others run. An interrupt, or nobody who asks
    for more, stops all workers at their next step.
    """
    stop = np.zeros(1, np.int64)
    waiting, finished = iter(tasks), 0
    ahead = list(islice(waiting, 1))
    if ahead and ahead[0].brief:
        ahead += islice(waiting, 1)
        if len(ahead) == 1:  # a thread would take longer
            yield ahead[0].work(np.zeros(1, np.int64), stop)
            report(ahead[0].runs)
            return
    waiting = chain(ahead, waiting)
    with ThreadPoolExecutor(workers) as pool:
        active: dict[Future[T], tuple[Task[T], np.ndarray]] = {}

        def submit() -> None:
            for task in waiting:
                counter = np.zeros(1, np.int64)
                active[pool.submit(task.work, counter, stop)] = task, counter
                return

        try:
            for _ in range(2 * workers):  # more than can run, so that none waits; what is in flight bounds the memory
                submit()
            while active:
                done, _ = wait(active, timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    finished += active.pop(future)[0].runs
                    submit()
                    yield future.result()
                report(finished + sum(task.runs * (counter[0] / task.whole) for task, counter in active.values()))
        except BaseException:
            stop[0] = 1
            raise


def tasks(batch: Batch, workers: int, then: Callable[[Chunk], T], cost: Cost | None = None) -> Iterator[Task[T]]:
    """One task for each chunk: integrate it, and then what is to be done with it; cost: what is known of it."""
    cost = cost or Cost()
    for runs in _slices(batch, workers, cost):
        whole = len(batch.outputs) * -(-(runs.stop - runs.start) // W)
        steps = np.inf if batch.h is None else batch.end / batch.h * -(-(runs.stop - runs.start) // W)
        brief = steps * element_rows(batch.machine.sizes) <= BRIEF * ELEMENT
        yield Task(runs.stop - runs.start, whole, partial(_chunk, batch, runs, then, cost), brief)


def _chunk(
    batch: Batch, runs: slice, then: Callable[[Chunk], T], cost: Cost, progress: np.ndarray, stop: np.ndarray
) -> T:
    started = thread_time()
    chunk = integrate(batch, runs, progress, stop)
    found = then(chunk)
    cost.per_run = (thread_time() - started) / len(chunk.codes)
    return found


def _slices(batch: Batch, workers: int, cost: Cost) -> Iterator[slice]:
    """The runs of each chunk: whole blocks, enough chunks for all workers, none too large or too long."""
    blocks = -(-batch.runs // W)
    times = 2 * sum(len(times.knots) for times in batch.discontinuities)
    record = 8 * W * (len(batch.outputs) * batch.record_rows + times)
    chunks = workers * (LONG_CHUNKS_PER_WORKER if batch.machine.queued else CHUNKS_PER_WORKER)
    most, first = min(CHUNK_BYTES // record, blocks // chunks), 0
    while first < batch.runs:
        long = FIRST_BLOCKS if cost.per_run is None else int(SECONDS / max(cost.per_run * W, 1e-9))
        size = W * max(1, min(most, long))
        yield slice(first, min(first + size, batch.runs))
        first += size


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
