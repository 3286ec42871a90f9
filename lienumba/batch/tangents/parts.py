"""Steps of a series, which are long, as several ones of another method."""

from itertools import pairwise

import numpy as np

from lienumba.batch.tangents.follow import Crossing, Trodden
from lienumba.batch.tangents.marcher import Marcher, Point
from lienumba.integrators.drivers.trail import HEAD, STEPS

PARTS = (2, 3, 4, 6, 8, 12, 16, 24, 32)
TRIED = 24  # steps in which it is tried how many parts are needed
ENOUGH = 1e-13  # of the largest number of a state, by which the end of a step may be another one
GAINS = 0.5  # of the error: where more parts leave more than this, it is rounding


def in_parts(run: Trodden, marcher: Marcher, start: Point) -> Trodden:
    """The same run with its steps cut into equal parts, so many that they lead to the same states."""
    number, places = _number(run.entries, marcher, start), [*range(len(run.entries))]
    rows, first = list[np.ndarray](), list[int]()
    for entry in run.entries:
        first.append(len(rows))
        if entry[0] != STEPS:
            rows.append(entry)
            continue
        ends = np.linspace(entry[1], entry[2], number + 1)
        for begin, end in pairwise(ends):
            part = np.full(len(entry), np.nan)
            part[:HEAD] = STEPS, begin, end, 0.0
            rows.append(part)
        rows[-1][HEAD:] = entry[HEAD:]
        rows[-1][2] = entry[2]
    found: dict[int, list[Crossing]] = {}
    for n in places:
        for crossing in run.crossings.get(n, ()):
            whole = min(int(crossing.part * number), number - 1)
            inside = crossing._replace(part=crossing.part * number - whole)
            found.setdefault(first[n] + whole, []).append(inside)
    return run._replace(entries=np.array(rows).reshape(-1, run.entries.shape[1]), crossings=found)


def _number(entries: np.ndarray, marcher: Marcher, start: Point) -> int:
    """How many parts are needed, by the longest steps of the run."""
    after = entries[:, HEAD : HEAD + marcher.rows]
    before = np.concatenate([start.x[0, :, :1].T, after[:-1]])
    steps = np.flatnonzero((entries[:, 0] == STEPS) & ~np.isnan(after).any(axis=1) & ~np.isnan(before).any(axis=1))
    tried = steps[np.argsort(entries[steps, 1] - entries[steps, 2])][:TRIED]
    last = np.inf
    for number in PARTS:
        error = 0.0
        for n in tried:
            ends = np.linspace(entries[n, 1], entries[n, 2], number + 1)
            point = Point(start.x.copy(), entries[n, 1])
            point.x[0] = before[n][:, None]
            marcher.march(point, np.stack([ends[:-1], ends[1:], np.diff(ends)]))
            error = max(error, float(np.abs(point.x[0, :, 0] - after[n]).max() / np.abs(after[n]).max()))
        if error <= ENOUGH or error > GAINS * last:
            return number
        last = error
    return PARTS[-1]
