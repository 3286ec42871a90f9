"""A batch of runs on a pool of threads: runs fill lanes, lanes fill blocks, a few blocks are a chunk.

The kernels release the interpreter, so plain threads share the cores. How runs are dealt out changes nothing in any
run's result.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from time import thread_time
from typing import Any

import numpy as np

from lienumba.compiler.rows import W
from lienumba.groups.state import ELEMENT
from lienumba.integrators.codes import EXCHANGED
from lienumba.integrators.machine import Machine, aligned, prepare
from lienumba.mechanics.landing import Landing
from lienumba.mechanics.tables import Numbers

CHUNK_BYTES = 32 * 2**20  # of records in one chunk
CHUNKS_PER_WORKER = 10  # so that the cores finish together and progress moves
SAME = 1e-9  # times nearer to each other than this fraction of a step are one
POLL = 0.1  # s between two looks at the progress


@dataclass(frozen=True)
class Batch:
    """Everything the runs need.

    parameters: one number per slot, a float or an array (runs,), or a table's Numbers; states (runs, 18 k + held) at
    the start; codes (runs,): 0 for the runs to be integrated; h: step (s); outputs: the steps to be stored, 0 to
    `steps` at most; landings: where steps must land.
    """

    machine: Machine
    parameters: list[Any]
    states: np.ndarray
    codes: np.ndarray
    h: float
    steps: int
    outputs: np.ndarray
    tolerance: float
    iterations: int
    landings: tuple[Landing, ...] = ()

    @property
    def runs(self) -> int:
        return len(self.states)

    def part(self, runs: np.ndarray) -> "Batch":
        """The batch of these runs (indices) alone."""
        parameters = [p[runs] if np.ndim(p) else p for p in self.parameters]
        landings = tuple(landing.part(runs) for landing in self.landings)
        return replace(self, parameters=parameters, states=self.states[runs], codes=self.codes[runs], landings=landings)


@dataclass(frozen=True)
class Chunk:
    """Finished runs: records (runs, outputs, rows), codes (runs,), and the last good step of each (runs,); seconds: how
    long a core was busy with their steps."""

    runs: slice
    records: np.ndarray
    codes: np.ndarray
    steps: np.ndarray
    seconds: float


def execute(batch: Batch, workers: int, report: Callable[[float, int], None]) -> Iterator[Chunk]:
    """Yield the chunks as they finish. `report(runs done, runs failed)` is called a few times per second.

    An interrupt stops all workers at their next step and is raised again.
    """
    stop = np.zeros(1, np.int64)
    slices = list(_slices(batch, workers))
    counters = [np.zeros(1, np.int64) for _ in slices]
    failed = 0
    with ThreadPoolExecutor(workers) as pool:
        waiting = iter(range(len(slices)))
        active: set[Future[Chunk]] = set()

        def submit() -> None:
            for i in waiting:
                active.add(pool.submit(_integrate, batch, slices[i], counters[i], stop))
                return

        try:
            for _ in range(workers + 1):  # one more than can run: what is in flight bounds the memory
                submit()
            while active:
                done, _ = wait(active, timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    active.discard(future)
                    chunk = future.result()
                    failed += int(np.count_nonzero((chunk.codes != 0) & (chunk.codes != EXCHANGED)))
                    yield chunk
                    submit()
                blocks = sum(int(c[0]) for c in counters) / len(batch.outputs)
                report(min(blocks * W, batch.runs - bool(active)), failed)  # all are done once all are counted
        except BaseException:
            stop[0] = 1
            raise


def _record_rows(machine: Machine) -> int:
    """A state, what is seen of it, and the iterations of the two projections."""
    return ELEMENT * machine.elements + machine.held.rows + machine.seen + 2


def _slices(batch: Batch, workers: int) -> Iterator[slice]:
    """The runs of each chunk: whole blocks, enough chunks for all workers, none too large for the memory."""
    blocks = -(-batch.runs // W)
    landings = 2 * sum(len(landing.knots) for landing in batch.landings)
    record = 8 * W * (len(batch.outputs) * _record_rows(batch.machine) + landings)
    per_chunk = max(1, min(CHUNK_BYTES // record, blocks // (CHUNKS_PER_WORKER * workers)))
    for first in range(0, batch.runs, per_chunk * W):
        yield slice(first, min(first + per_chunk * W, batch.runs))


def _lanes(values: np.ndarray, blocks: int) -> np.ndarray:
    """(runs, rows) as (blocks, rows, W); the lanes behind the last run repeat it."""
    padded = values[np.minimum(np.arange(blocks * W), len(values) - 1)]
    out = aligned(blocks, values.shape[1], W)
    out[:] = padded.reshape(blocks, W, -1).transpose(0, 2, 1)
    return out


def _landings(batch: Batch, runs: slice, blocks: int) -> np.ndarray:
    """The times on which steps must land (blocks, n, W), those of a run ascending, with an infinite one behind them.

    Those outside the run are left out; those at the end of a step are that end to the bit.
    """
    count = runs.stop - runs.start
    every = [landing.part(runs).times(count) for landing in batch.landings]
    times = np.concatenate([*every, np.full((count, 1), np.inf)], axis=1)
    times = np.where((times > 0.0) & (times <= batch.h * batch.steps), times, np.inf)
    finite = np.where(np.isfinite(times), times, 0.0)
    ends = np.round(finite / batch.h) * batch.h
    times = np.where(np.isfinite(times) & (np.abs(finite - ends) <= SAME * batch.h), ends, times)
    times.sort(axis=1)
    used = int(np.isfinite(times).sum(axis=1).max()) + 1
    return _lanes(times[:, :used], blocks)


def _number(parameter: Any) -> np.ndarray:
    """A parameter as the kernels read it: tables by their address."""
    return np.asarray(parameter.address if isinstance(parameter, Numbers) else parameter, float)


def _integrate(batch: Batch, runs: slice, progress: np.ndarray, stop: np.ndarray) -> Chunk:
    from lienumba.integrators.driver import drive

    machine, count = batch.machine, runs.stop - runs.start
    held = machine.held
    blocks = -(-count // W)
    states = _lanes(batch.states[runs], blocks)
    table = np.stack(
        [np.broadcast_to(_number(p), (batch.runs,))[runs] for p in batch.parameters]
        or [np.zeros(count)], axis=1,
    )  # fmt: skip
    parameters = aligned(blocks, max(machine.parameter_rows, 1), W)
    parameters[:, : table.shape[1]] = _lanes(table, blocks)
    prepare(machine, parameters)
    rows = _record_rows(machine)
    records = aligned(blocks, len(batch.outputs), rows, W)
    codes = _lanes(batch.codes[runs, None].astype(float), blocks)[:, 0].copy()
    steps = np.zeros((blocks, W))
    landings, buffer, started = _landings(batch, runs, blocks), machine.buffer(), thread_time()
    drive(
        machine.kernels, machine.nodes, machine.elements, held.rows, held.first_mask, len(held.masks), bool(held.fixed),
        machine.seen, batch.steps, batch.iterations, batch.h, batch.tolerance, batch.outputs, states, parameters,
        landings, records, codes, steps, buffer, progress, stop,
    )  # fmt: skip
    seconds = thread_time() - started
    by_run = records.transpose(0, 3, 1, 2).reshape(blocks * W, len(batch.outputs), rows)[:count]
    codes, steps = codes.reshape(-1)[:count].astype(np.int8), steps.reshape(-1)[:count].astype(np.int64)
    return Chunk(runs, by_run, codes, steps, seconds)
