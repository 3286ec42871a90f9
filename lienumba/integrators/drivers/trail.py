"""What a run has gone through, for whoever follows it again: its steps, and at changes what was done one by one."""

from typing import NamedTuple

from lienumba.compiler.routines.marks import Floats3, Integers1, apart
from lienumba.integrators.drivers.workspace import Rows

# An entry: its kind, the time (s), two numbers, the state afterwards, and behind it the impulses of all switched rows.
STEPS = 0  # from that time to the first number; the second one is the length where the step is not cut, else 0
SAMPLES = 1  # laws of the user's own
CAUSES = 2  # this condition (the first number) has become true, and there is a change
ACTS = 3  # an event
CLOSES = 4  # joints over their gaps
KICKS = 5  # impulses
GOES_ON = 6  # with these modes; 1 before joints close, else 0
HEAD = 4


class Trail(NamedTuple):
    """entries (runs, entries, 4 + state rows + switched rows), none where nobody asks; counts (runs,): how many there
    are of each run, also where there is no room for all."""

    entries: Floats3
    counts: Integers1


@apart
def note(
    trail: Trail, run: int, rows: Rows, lane: int, state: int, kind: int, t: float, first: float, second: float
) -> None:
    """Note what the state of a lane, which begins at the row `state`, is behind it."""
    n = trail.counts[run]
    if n < trail.entries.shape[1]:
        entry = trail.entries[run, n]
        entry[0], entry[1], entry[2], entry[3] = float(kind), t, first, second
        for row in range(entry.size - HEAD):
            entry[HEAD + row] = rows[state + row, lane]
    trail.counts[run] = n + 1


@apart
def note_impulses(trail: Trail, run: int, rows: Rows, lane: int, impulses: int, count: int) -> None:
    """Note the impulses of the last entry."""
    n = trail.counts[run] - 1
    if n < trail.entries.shape[1]:
        entry = trail.entries[run, n]
        for i in range(count):
            entry[entry.size - count + i] = rows[impulses + i, lane]
