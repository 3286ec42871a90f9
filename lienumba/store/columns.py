"""Variables on their way into a file, chunk by chunk: several threads compress, one writes what they have made."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from lienumba.store.deflate import deflated, noise_of, shuffled
from lienumba.store.layout import NO_COUNT, narrowed

AHEAD = 64  # jobs that are being compressed, or wait to be written
LOOK = 32  # chunks of which the first tells how much of all is noise


class Column:
    """A variable of an HDF5 file whose rows, the runs, come one behind the other."""

    def __init__(self, dataset: Any) -> None:
        self.dataset, self.rows = dataset, int(dataset.chunks[0])
        self.dtype, self.fill = dataset.dtype, dataset.fillvalue
        self.rest = dataset.shape[1:]
        self.packed = dataset.compression is not None
        self.waiting: list[np.ndarray] = []  # what does not make a whole chunk
        self.begun = 0  # rows that are in chunks
        self.noise, self.look = 0, 0  # how many low bytes of a number are noise; the row where that is looked at again

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

    def noise_at(self, first: int, parts: Sequence[np.ndarray]) -> int:
        """How many low bytes of a number are noise in rows that begin at this one."""
        if self.packed and first >= self.look:
            chunk = self._as_stored([part[: self.rows] for part in parts])[: self.rows]
            self.noise, self.look = noise_of(shuffled(chunk)), first + LOOK * self.rows
        return self.noise

    def chunks(self, parts: Sequence[np.ndarray], noise: int) -> list[bytes]:
        """These rows as the chunks of the file, the last one filled up."""
        values = self._as_stored(parts)
        missing = -len(values) % self.rows
        if missing:
            values = np.concatenate([values, np.full((missing, *self.rest), self.fill, self.dtype)])
        cut = (values[first : first + self.rows] for first in range(0, len(values), self.rows))
        return [deflated(shuffled(chunk), noise) if self.packed else chunk.tobytes() for chunk in cut]

    def write(self, first: int, stop: int, chunks: Sequence[bytes]) -> None:
        """Write chunks that begin at a row; the variable ends at `stop` now."""
        self.dataset.id.set_extent((stop, *self.rest))
        zeros = (0,) * len(self.rest)
        for n, chunk in enumerate(chunks):
            self.dataset.id.write_direct_chunk((first + n * self.rows, *zeros), chunk)

    def _as_stored(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """As the file holds them: counts as integers, and no count as -1."""
        values = np.concatenate(parts)
        if self.dtype.kind == "i" and values.dtype.kind == "f":
            values = np.where(np.isnan(values), NO_COUNT, values)
        return narrowed(values, self.dtype)


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
            chunks = self.pool.submit(column.chunks, parts, column.noise_at(first, parts))
            self.active.append((column, first, column.begun, chunks))
            self._settle(AHEAD)

    def _settle(self, most: int) -> None:
        """Write what is compressed until no more than so many jobs are left."""
        while self.active and (len(self.active) > most or self.active[0][3].done()):
            column, first, stop, chunks = self.active.popleft()
            column.write(first, stop, chunks.result())
