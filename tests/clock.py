"""Quiet seconds: core time divided by that of a fixed loop, so that costs of machines of different speed or load
can be compared."""

import os
import statistics
import time

ADDITIONS = 200_000
QUIET = 0.065e-6  # s of core time of one addition on a quiet core, by definition: an AMD EPYC of 2.45 GHz, Python 3.11


def ratio(repetitions: int = 5) -> float:
    """Core time of a loop of integer additions relative to a quiet core: 2 where all takes twice as long."""
    return statistics.median(_seconds() for _ in range(repetitions)) / (ADDITIONS * QUIET)


def _seconds() -> float:
    start, total = time.process_time(), 0
    for n in range(ADDITIONS):
        total += n
    return time.process_time() - start


def core_seconds() -> float:
    """Core time so far of this process and of the children that it has waited for, in s."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system
