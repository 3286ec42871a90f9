"""Whether forces of stops and contacts can hold what rests: the contact problem of many runs."""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.routines.marks import Floats2, Floats3, Integers1, Integers2, apart
from lienumba.integrators.drivers.switching.complementarity import solve
from lienumba.integrators.drivers.switching.problem import UNKNOWNS, Problem


class Room(NamedTuple):
    """Memory of `Problem` for one run: vectors (9, q), matrix (q, q + 1), and three arrays of `pivoting`."""

    vectors: Floats2
    matrix: Floats2
    tableau: Floats2
    unknowns: Floats2
    labels: Floats2

    @staticmethod
    def of(q: int) -> "Room":
        """Room for q rows."""
        n = UNKNOWNS * q
        shapes = (9, q), (q, q + 1), (n, n + 2), (n, 7), (2, n + 1)
        return Room(*(np.zeros(shape) for shape in shapes))


def forces(
    S: Floats3, free: Floats2, switches: Integers2, law: Floats2, friction: Floats2, x: Floats2, rates: Floats2,
    status: Integers1, room: Room,
) -> None:  # fmt: skip
    """Solve `Problem` for every run, which is the first axis of all arrays; x is 0 before."""
    for run in range(S.shape[0]):
        status[run] = _forces(S[run], free[run], switches, law[run], friction[run], x[run], rates[run], room)


@apart
def _forces(
    S: np.ndarray, free: np.ndarray, switches: np.ndarray, law: np.ndarray, friction: np.ndarray, x: np.ndarray,
    rates: np.ndarray, room: Room,
) -> int:  # fmt: skip
    s, v = law.size, room.vectors
    return solve(Problem(
        S, free, switches, law, friction, v[0][:s], v[1], x, rates, v[2], v[3], v[4], v[5], v[6], room.matrix,
        v[7][:s], room.tableau, room.unknowns, room.labels,
    ))  # fmt: skip
