"""Some runs from their start to their end: the arrays that the jitted steps need, window by window."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.reference.compiling import compile_for
from lienumba.reference.mechanism import STATE, SUCCESS, Method, Records, Run, records_of, room_of
from lienumba.reference.step import march
from lienumba.reference.table import Table

WINDOW = 128  # steps that are made at a time: for so many the numbers that vary in time are tabulated
IDENTITY_STATE = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0], float)


@dataclass(frozen=True)
class Runs:
    """states (runs, 18 k) and angles (runs,) by joint, in rad, at the start; codes (runs,): SUCCESS for those to be
    integrated; steps: of each run; outputs: the steps that are stored, from 0 on; dropped: dependent rows."""

    table: Table
    method: Method
    states: np.ndarray
    angles: Mapping[int, np.ndarray]
    codes: np.ndarray
    steps: int
    outputs: np.ndarray
    dropped: Sequence[int]

    def integrate(self, runs: np.ndarray, stop: np.ndarray) -> Iterator[tuple[Run, Records]]:
        """Integrate N runs (indices) together; yields where they are and what is stored after each window of steps, and
        ends where stop[0] is set."""
        mechanism, method, table = self.table.mechanism(runs, self.dropped), self.method, self.table
        records, room = records_of(mechanism, self.outputs), room_of(mechanism, method.b.size)
        run = self._start(runs, mechanism.coordinates.vectors)
        room.y[:], room.hat[:] = run.x, run.x  # with the ground, which no step moves
        nodes = np.append(method.A.sum(axis=1), 1.0) * method.h
        numbers: np.ndarray | None = None
        for first in range(0, self.steps, WINDOW):
            steps = np.arange(first, min(first + WINDOW, self.steps) + 1)
            numbers = table.numbers_at(steps[:, None] * method.h + nodes, runs, numbers)
            given = mechanism, method, numbers[: len(steps)], run, room, records, first
            compile_for(march, *given)
            march(*given)
            yield run, records
            if stop[0] or not (run.code == SUCCESS).any():
                return

    def _start(self, runs: np.ndarray, vectors: np.ndarray) -> Run:
        N = len(runs)
        near = np.zeros((len(vectors), N))
        for joint, n in self.table.angles.items():
            near[n] = np.broadcast_to(self.angles.get(joint, 0.0), (len(self.states),))[runs]
        ground = np.broadcast_to(IDENTITY_STATE, (N, STATE))
        x = np.ascontiguousarray(np.concatenate([self.states[runs], ground], axis=1).T)
        places = x.reshape(-1, STATE, N)[:, :3]
        size = np.sqrt((places * places).sum(axis=1)).max(axis=0) + np.abs(vectors).max(axis=(0, 1), initial=0.0)
        code = self.codes[runs].astype(np.int64)
        return Run(x, near, np.zeros(N), code, np.zeros(N, np.int64), np.zeros((2, N)), size)
