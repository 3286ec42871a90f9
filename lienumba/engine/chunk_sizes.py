"""Deals runs out to a cluster, in chunks whose size follows from what runs have cost so far."""

from math import ceil

from lienumba.compiler.rows import W

SECONDS = 2.0  # that a chunk should take: short beside a sweep
PERIOD = 0.02  # s per chunk and core at least: what all cores send, one client must take
CHUNK_BYTES = 8 * 2**20  # that are sent for a chunk
CHUNKS_PER_CORE = 3  # that are still to come, so that the cores finish together
GROWTH = 2  # of the size at most from one chunk to the next: no two runs need cost the same


class Dealt:
    """runs: how many there are; run_bytes: that are sent for each."""

    def __init__(self, runs: int, run_bytes: int) -> None:
        self.runs, self.first = runs, 0
        self.most = max(1, CHUNK_BYTES // (run_bytes * W)) * W
        self.size, self.cost = W, 0.0  # runs that a chunk may have, and what one has cost (s)

    @property
    def more(self) -> bool:
        """Whether any are still to be dealt out."""
        return self.first < self.runs

    def next(self, cores: int) -> slice:
        """The next chunk for one of so many cores: whole blocks of lanes."""
        even = (self.runs - self.first) / (CHUNKS_PER_CORE * max(cores, 1))
        long = max(SECONDS, PERIOD * cores) / self.cost if self.cost else self.size
        size = ceil(min(self.size, self.most, even, long) / W) * W
        chunk = slice(self.first, min(self.first + size, self.runs))
        self.first = chunk.stop
        return chunk

    def learn(self, runs: int, seconds: float) -> None:
        """So many runs took a core so long (s)."""
        self.size, self.cost = GROWTH * runs, seconds / runs
