"""Whether forces of stops and contacts can hold what rests: the same complementarity problem, of many runs."""

import numpy as np

from lienumba.compiler.routines.marks import Floats2, Floats3, Integers1, Integers2, apart
from lienumba.integrators.drivers.switching.choices import solve
from lienumba.integrators.drivers.switching.problem import Problem

VECTORS = 10  # of `Problem`, to work in


def forces(
    S: Floats3, free: Floats2, switches: Integers2, law: Floats2, friction: Floats2, x: Floats2, rates: Floats2,
    said: Integers1, room: Floats2, matrix: Floats2,
) -> None:  # fmt: skip
    """Of `Problem` each array with the runs first; x: 0 before; said: what `solve` says; room: `VECTORS` of q, 0."""
    for run in range(S.shape[0]):
        said[run] = _forces(
            S[run], free[run], switches, law[run], friction[run], x[run], rates[run], room, matrix
        )  # fmt: skip


@apart
def _forces(
    S: np.ndarray, free: np.ndarray, switches: np.ndarray, law: np.ndarray, friction: np.ndarray, x: np.ndarray,
    rates: np.ndarray, room: np.ndarray, matrix: np.ndarray,
) -> int:  # fmt: skip
    s = law.size
    p = Problem(
        S, free, switches, law, friction, room[0][:s], room[1], x, rates, room[2], room[3], room[4], room[5], room[6],
        matrix, room[7][:s], room[8][:s], room[9],
    )  # fmt: skip
    return solve(p)
