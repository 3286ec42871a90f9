"""Wall time, and what the cores spent in it: a neighbour on the machine stretches the one far more than the other."""

import time
from collections.abc import Iterable
from typing import NamedTuple


class Spent(NamedTuple):
    """Seconds on the clock, and of all threads of this process."""

    wall: float
    core: float


class Stopwatch:
    def __init__(self) -> None:
        self._wall, self._core = time.perf_counter(), time.process_time()

    def spent(self) -> Spent:
        """Since it was made."""
        return Spent(time.perf_counter() - self._wall, time.process_time() - self._core)


def total(parts: Iterable[Spent]) -> Spent:
    wall, core = map(sum, zip(*parts, strict=True))
    return Spent(wall, core)
