"""A batch of runs on a pool of threads: runs fill lanes, lanes fill blocks, a few blocks are a chunk.

The kernels release the interpreter, so plain threads share the cores. How runs are dealt out changes nothing in any
run's result.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

import numpy as np

from lienumba.batch.integrate import Batch, Chunk, integrate
from lienumba.batch.statuses import GOOD
from lienumba.compiler.rows import W
from lienumba.integrators.codes import EXCHANGED

CHUNK_BYTES = 32 * 2**20  # of records in one chunk
CHUNKS_PER_WORKER = 10  # so that the cores finish together and progress moves
LONG_CHUNKS_PER_WORKER = 3  # where lanes are filled again: only the end of a chunk leaves some empty
POLL = 0.1  # s between two looks at the progress
FINE = (*GOOD, EXCHANGED)  # codes of no failure


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
                active.add(pool.submit(integrate, batch, slices[i], counters[i], stop))
                return

        try:
            for _ in range(workers + 1):  # one more than can run: what is in flight bounds the memory
                submit()
            while active:
                done, _ = wait(active, timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    active.discard(future)
                    chunk = future.result()
                    failed += int(np.count_nonzero(~np.isin(chunk.codes, FINE)))
                    yield chunk
                    submit()
                blocks = sum(int(c[0]) for c in counters) / len(batch.outputs)
                report(min(blocks * W, batch.runs - bool(active)), failed)  # all are done once all are counted
        except BaseException:
            stop[0] = 1
            raise


def _slices(batch: Batch, workers: int) -> Iterator[slice]:
    """The runs of each chunk: whole blocks, enough chunks for all workers, none too large for the memory."""
    blocks = -(-batch.runs // W)
    landings = 2 * sum(len(landing.knots) for landing in batch.landings)
    record = 8 * W * (len(batch.outputs) * batch.record_rows + landings)
    chunks = workers * (LONG_CHUNKS_PER_WORKER if batch.machine.free else CHUNKS_PER_WORKER)
    per_chunk = max(1, min(CHUNK_BYTES // record, blocks // chunks))
    for first in range(0, batch.runs, per_chunk * W):
        yield slice(first, min(first + per_chunk * W, batch.runs))
