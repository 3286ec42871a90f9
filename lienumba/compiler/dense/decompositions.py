"""Small dense matrices, run by run: the same bits on every processor, whatever the runs beside.

LAPACK chooses its code by the processor, and one matrix of which a decomposition does not converge ends a whole stack.
Here each run is one pass of plain loops (`lienumba.compiler.routines`). Nothing is raised: what is not finite, or has
no solution, is NaN in its own run. All arrays are (runs, rows, columns) or (runs, rows).
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.flat import Flat, kept

Array = npt.NDArray[Any]
ELIMINATION = "lienumba.compiler.dense.elimination"
EIGENVALUES = "lienumba.compiler.dense.eigenvalues"


@cache
def _routine(name: str, module: str = ELIMINATION) -> Flat:
    return kept(module, name)


def _given(x: Array) -> Array:
    """As routines take it."""
    return np.ascontiguousarray(x, float)


def product(A: Array, B: Array) -> Array:
    """A B, where B may also be (runs, rows)."""
    flat = B.ndim == A.ndim - 1
    right = B[:, :, None] if flat else B
    found = np.empty((len(A), A.shape[1], right.shape[2]))
    if found.size:
        _routine("product")(_given(A), _given(right), found)
    return found[:, :, 0] if flat else found


def turned(A: Array) -> Array:
    """A^T."""
    return A.transpose(0, 2, 1)


@dataclass(frozen=True)
class Rows:
    """C Q = L, by reflections that take the largest rows first: the first `rank` columns of Q span what the rows of C
    say, the others what they leave free. order: of the rows, those that say something first, of which L is a lower
    triangle; the others say what these do."""

    rank: Array
    Q: Array
    L: Array
    order: Array

    @staticmethod
    def of(C: Array, negligible: float, most: Array | None = None) -> "Rows":
        """negligible: of the largest row, what counts as 0 of another beside those before it; most (runs,): how many
        rows may say something."""
        runs, m, n = C.shape
        L, Q = _given(C).copy(), np.empty((runs, n, n))
        rank, order = np.zeros(runs, np.int64), np.zeros((runs, max(m, 1)), np.int64)
        most = np.full(runs, min(m, n)) if most is None else most
        _routine("reflected")(L, Q, most, rank, order, np.empty(n), float(negligible))
        return Rows(rank, Q, L, order)

    def within(self, b: Array) -> Array:
        """y with C Q y = b in the rows that say something, 0 in what they leave free."""
        found = np.zeros(self.Q.shape[:2])
        _routine("forward")(self.L, self.rank, self.order, _given(b), found)
        return found

    def least(self, b: Array) -> Array:
        """The shortest x with C x = b in the rows that say something."""
        return product(self.Q, self.within(b))

    def multipliers(self, g: Array) -> Array:
        """mu with Q^T C^T mu = g as far as rows can; of those that say nothing of their own 0."""
        found = np.zeros(self.L.shape[:2])
        _routine("backward")(self.L, self.rank, self.order, _given(g), found)
        return found


def solved(A: Array, b: Array, first: Array, negligible: float) -> Array:
    """x with A x = b, where b may also be (runs, rows), in the rows and columns from `first` (runs,) on, 0 before.

    Where columns depend on others, of pivots below a fraction of the largest, their numbers are 0, too.
    """
    flat = b.ndim == A.ndim - 1
    right = b[:, :, None] if flat else b
    found = np.zeros(right.shape)
    if found.size:
        work = np.empty((2, b.shape[1]))
        _routine("solved")(_given(A).copy(), _given(right).copy(), first, found, work, float(negligible))
    return found[:, :, 0] if flat else found


def symmetric_values(A: Array, first: Array) -> Array:
    """The eigenvalues of symmetric matrices, in the rows and columns from `first` (runs,) on, NaN before."""
    found = np.full(A.shape[:2], np.nan)
    _routine("rotated")(_given(A).copy(), first, found)
    return found


def eigenvalues(A: Array) -> Array:
    """Of real matrices, complex (runs, n); NaN where they are not found, as of what is not finite."""
    found = np.full((2, *A.shape[:2]), np.nan)
    good = np.isfinite(A).all(axis=(1, 2))
    own = np.full((2, int(good.sum()), A.shape[1]), np.nan)
    if own.size:
        _routine("eigenvalues", EIGENVALUES)(_given(A[good]).copy(), own[0], own[1])
    found[:, good] = own
    whole: Array = found[0] + 1j * found[1]
    return whole
