"""What runs go through: their steps and changes, noted as they are made once more."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lienumba.batch.integrate import Batch, Chunk, integrate
from lienumba.compiler.rows import W
from lienumba.integrators import layout
from lienumba.integrators.drivers.trail import HEAD, SAMPLES, STEPS, Trail

FIRST_ENTRIES = 4096  # of a trail where a tolerance chooses steps, at first


class Noted(NamedTuple):
    """entries of the trail of a run (`drivers.trail`); event_times (events,): when they first happened (s); kept (kept,
    numbers): values of signals and their times."""

    entries: np.ndarray
    event_times: np.ndarray
    kept: np.ndarray


def noted(batch: Batch, jumps: Sequence[np.ndarray], states: bool) -> Iterator[Noted]:
    """Each of at most W runs; jumps: of each the times (s) at which F may jump; states: whether those between steps of
    one length are needed, and the values of signals. Without them such runs are not made again."""
    if batch.machine.queued:
        yield from _by_trail(batch)
        return
    assert batch.h is not None
    steps = np.arange(round(batch.last / batch.h) + 1) * batch.h
    chunk = _integrated(replace(batch, outputs=steps)) if states and batch.runs else None
    width = layout.state_rows(batch.machine.sizes)
    for run in range(batch.runs):
        whole, known, kept = steps, np.full((len(steps), width), np.nan), np.zeros((0, 2))
        if chunk is not None:
            whole = steps[: round(chunk.ends[run] / batch.h) + 1]
            known, kept = chunk.records[0, : len(whole), :width, run], chunk.kept[run]
        yield Noted(_steps(batch, batch.h, whole, known, jumps[run]), np.zeros(0), kept)


def _by_trail(batch: Batch) -> Iterator[Noted]:
    """By the trail of a queue."""
    entries = FIRST_ENTRIES if batch.h is None else 64 + round(batch.end / batch.h)
    width = HEAD + layout.state_rows(batch.machine.sizes) + batch.machine.sizes.switched
    while batch.runs:
        trail = Trail(np.full((W, entries, width), np.nan), np.zeros(W, np.int64))
        chunk = _integrated(replace(batch, trail=trail))
        if trail.counts.max() <= entries:
            for run in range(batch.runs):
                mine = trail.entries[run, : trail.counts[run]]
                yield Noted(mine, chunk.event_times[run], chunk.kept[run])
            return
        entries = int(trail.counts.max())


def _integrated(batch: Batch) -> Chunk:
    """All runs of a batch."""
    return integrate(batch, slice(0, batch.runs), np.zeros(1, np.int64), np.zeros(1, np.int64))


def _steps(batch: Batch, h: float, whole: np.ndarray, states: np.ndarray, jumps: np.ndarray) -> np.ndarray:
    """Entries of steps of length h between these times, cut where F may jump; states (times, rows)."""
    cuts = np.setdiff1d(jumps[(jumps > 0.0) & (jumps < whole[-1])], whole)
    times = np.insert(whole, np.searchsorted(whole, cuts), cuts)
    known = np.insert(np.ones(len(whole), bool), np.searchsorted(whole, cuts), False)
    rows = states.shape[1]
    found = np.full((len(times) - 1, HEAD + rows + batch.machine.sizes.switched), np.nan)
    found[:, 0], found[:, 1], found[:, 2] = STEPS, times[:-1], times[1:]
    found[:, 3] = np.where(known[:-1] & known[1:], h, 0.0)
    found[known[1:], HEAD : HEAD + rows] = states[1:]
    if batch.machine.kernels[layout.SAMPLE] == 0:
        return found
    sampled = np.flatnonzero(np.isin(times[1:], jumps))  # the state that is stored is the one behind the samples
    samples = found[sampled].copy()
    samples[:, 0], samples[:, 1], samples[:, 2:HEAD] = SAMPLES, samples[:, 2], 0.0
    found[sampled, HEAD:] = np.nan
    return np.insert(found, sampled + 1, samples, axis=0)
