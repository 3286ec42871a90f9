"""Variables on their way into a file, chunk by chunk: several threads compress, one writes what they have made."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from lienumba.store.deflate import deflated
from lienumba.store.layout import NO_COUNT

AHEAD = 64  # jobs that are being compressed, or wait to be written


class Column:
    """A variable of an HDF5 file whose rows, the runs, come one behind the other."""

    def __init__(self, dataset: Any) -> None:
        self.dataset, self.rows = dataset, int(dataset.chunks[0])
        self.dtype, self.fill = dataset.dtype, dataset.fillvalue
        self.packed = dataset.compression is not None
        self.waiting: list[np.ndarray] = []  # what does not make a whole chunk
        self.begun = 0  # rows that are in chunks

    @property
    def taken(self) -> int:
        """How many rows there are."""
        return self.begun + sum(map(len, self.waiting))

    def take(self, values: np.ndarray) -> list[np.ndarray]:
        """What makes whole chunks now, together with what has waited."""
        waited = self.taken - self.begun
        used = (waited + len(values)) // self.rows * self.rows - waited
        if used <= 0:
            self.waiting.append(values.copy())  # of a part that is much longer
            return []
        parts, self.waiting = [*self.waiting, values[:used]], [values[used:].copy()]
        self.begun += waited + used
        return parts

    def end(self) -> list[np.ndarray]:
        """What is left."""
        parts, self.waiting = [part for part in self.waiting if len(part)], []
        self.begun += sum(map(len, parts))
        return parts

    def chunks(self, parts: Sequence[np.ndarray]) -> list[bytes]:
        """These rows as the chunks of the file, the last one filled up."""
        values = np.concatenate([as_stored(part, self.dtype) for part in parts])
        missing = -len(values) % self.rows
        if missing:
            values = np.concatenate([values, np.full((missing, *values.shape[1:]), self.fill, self.dtype)])
        cut = (values[first : first + self.rows] for first in range(0, len(values), self.rows))
        return [deflated(chunk) if self.packed else chunk.tobytes() for chunk in cut]

    def write(self, first: int, stop: int, chunks: Sequence[bytes]) -> None:
        """Write chunks that begin at a row; the variable ends at `stop` now."""
        self.dataset.resize(stop, axis=0)
        rest = (0,) * (self.dataset.ndim - 1)
        for n, chunk in enumerate(chunks):
            self.dataset.id.write_direct_chunk((first + n * self.rows, *rest), chunk)


class Columns:
    """Columns by name, which are compressed by so many threads."""

    def __init__(self, columns: dict[str, Column], threads: int) -> None:
        self.columns = columns
        self.pool = ThreadPoolExecutor(threads)
        self.active: deque[tuple[Column, int, int, Future[list[bytes]]]] = deque()

    def take(self, name: str, values: np.ndarray) -> None:
        """The next rows of a variable."""
        column = self.columns[name]
        first, parts = column.begun, column.take(values)
        self._send(column, first, parts)

    def end(self) -> None:
        """Write everything."""
        for column in self.columns.values():
            self._send(column, column.begun, column.end())
        self._settle(0)

    def close(self) -> None:
        self.pool.shutdown(cancel_futures=True)

    def _send(self, column: Column, first: int, parts: list[np.ndarray]) -> None:
        if parts:
            self.active.append((column, first, column.begun, self.pool.submit(column.chunks, parts)))
            self._settle(AHEAD)

    def _settle(self, most: int) -> None:
        """Write what is compressed until no more than so many jobs are left."""
        while self.active and (len(self.active) > most or self.active[0][3].done()):
            column, first, stop, chunks = self.active.popleft()
            column.write(first, stop, chunks.result())


def as_stored(values: np.ndarray, dtype: np.dtype[np.generic]) -> np.ndarray:
    """As the file holds them: counts as integers, and no count as -1."""
    if dtype.kind == "i" and values.dtype.kind == "f":
        values = np.where(np.isnan(values), NO_COUNT, values)
    return values.astype(dtype, copy=False)
