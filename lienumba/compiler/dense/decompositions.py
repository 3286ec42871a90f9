"""Small dense matrices, run by run: the same bits on every processor, whatever the runs beside.

LAPACK chooses its code by the processor, and one matrix of which a decomposition does not converge ends a whole stack.
Here each run is one pass of plain loops (`lienumba.compiler.routines`). Nothing is raised: what is not finite, or has
no solution, is NaN in its own run. All arrays are (runs, rows, columns) or (runs, rows).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.flat import Flat, kept

Array = npt.NDArray[Any]
SMALL = 1e-7  # of the largest eigenvalue: rounding splits a double zero by less
DOUBTFUL = 1e-4  # of the largest: what may be rounding, if it is a sum of what is larger still, or moves little mass
SLOWLY = 1e-3  # of an eigenvalue: rounding makes one of several that are the same grow by less
FIRM = 0.1  # of a small eigenvalue, or growth: what is no rounding changes by less where A is rounded otherwise
TIMES = 3  # A is rounded otherwise: once, another eigenvalue may come near by chance
ROUNDED = 1.4e-14  # of the largest entry of a row of A
STORED = 3e-16  # of a number itself
EVEN = 1e-13  # of the largest eigenvalue: how much of another one may be rounding
NOTHING = 1e-10  # of the longest row of C, or of 1: what is no longer than that is rounding
ELIMINATION = "lienumba.compiler.dense.elimination"
EIGENVALUES, EIGENVECTORS = (f"lienumba.compiler.dense.{name}" for name in ("eigenvalues", "eigenvectors"))


@cache
def _routine(name: str, module: str = ELIMINATION) -> Flat:
    return kept(module, name)


def _given(x: Array) -> Array:
    """As routines take it."""
    return np.ascontiguousarray(x, float)


def _columns(b: Array) -> Array:
    """One column, where there are not several."""
    return b[:, :, None] if b.ndim == 2 else b


def product(A: Array, B: Array) -> Array:
    """A B, where B may also be (runs, rows)."""
    right = _columns(B)
    found = np.empty((len(A), A.shape[1], right.shape[2]))
    if found.size:
        _routine("product")(_given(A), _given(right), found)
    return found if B.ndim == 3 else found[:, :, 0]


def turned(A: Array) -> Array:
    """A^T."""
    return A.transpose(0, 2, 1)


def unit_rows(C: Array) -> tuple[Array, Array]:
    """C with rows of length 1, and how long they were (runs, rows); 0 and 1 of those that are `NOTHING`."""
    squares = np.zeros(C.shape[:2])
    for n in range(C.shape[2]):
        squares += C[:, :, n] * C[:, :, n]
    longest = squares.max(axis=1, initial=1.0)[:, None]
    says = ~(squares <= NOTHING * NOTHING * longest)  # also what is undefined
    lengths = np.where(says, np.sqrt(squares), 1.0)
    return np.where(says[:, :, None], C / lengths[:, :, None], 0.0), lengths


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

    def part(self, runs: Array) -> "Rows":
        """Of these runs alone."""
        return Rows(self.rank[runs], self.Q[runs], self.L[runs], self.order[runs])

    def within(self, b: Array) -> Array:
        """y with C Q y = b (runs, rows) or (runs, rows, k) in the rows that say something, 0 in what they leave
        free."""
        right = _columns(b)
        found = np.zeros((*self.Q.shape[:2], right.shape[2]))
        if right.size:
            _routine("forward")(self.L, self.rank, self.order, _given(right), found)
        return found if b.ndim == 3 else found[:, :, 0]

    def free(self, x: Array) -> Array:
        """Of what is along the columns of Q (runs, n) or (runs, k, n), that of those that are free; 0 of the others."""
        rank = self.rank.reshape(-1, *[1] * (x.ndim - 1))
        return np.where(np.arange(x.shape[-1]) >= rank, x, 0.0)

    def least(self, b: Array) -> Array:
        """The shortest x with C x = b in the rows that say something."""
        if not self.rank.any():
            return np.zeros((*self.Q.shape[:2], *b.shape[2:]))
        return product(self.Q, self.within(b))

    def multipliers(self, g: Array) -> Array:
        """mu with Q^T C^T mu = g as far as rows can; of those that say nothing of their own 0."""
        right = _columns(g)
        found = np.zeros((*self.L.shape[:2], right.shape[2]))
        if found.size:
            _routine("backward")(self.L, self.rank, self.order, _given(right), found)
        return found if g.ndim == 3 else found[:, :, 0]

    def least_multipliers(self, g: Array) -> Array:
        """Those of least length with C^T mu = g as far as rows can."""
        along = product(turned(self.Q), g)
        if (self.rank == self.L.shape[1]).all():
            return self.multipliers(along)
        said = np.arange(self.L.shape[2]) < self.rank[:, None]
        own = Rows.of(np.where(said[:, :, None], turned(self.L), 0.0), 0.0, self.rank)
        return own.least(np.where(said if g.ndim == 2 else said[:, :, None], along, 0.0))


def solved(A: Array, b: Array, first: Array, negligible: float) -> Array:
    """x with A x = b, where b may also be (runs, rows), in the rows and columns from `first` (runs,) on, 0 before.

    Where columns depend on others, of pivots below a fraction of the largest, their numbers are 0, too.
    """
    right = _columns(b)
    found = np.zeros(right.shape)
    if found.size:
        work = np.empty((2, b.shape[1]))
        _routine("solved")(_given(A).copy(), _given(right).copy(), first, found, work, float(negligible))
    return found if b.ndim == 3 else found[:, :, 0]


def accelerations(M: Array, b: Array, first: Array, negligible: float) -> Array:
    """The same of masses M, positive definite, whatever the units of its coordinates: light bodies beside heavy ones.
    By their sizes on both sides, as elimination along a diagonal rounds each body by itself."""
    own = M.diagonal(axis1=1, axis2=2)
    sizes = np.where(own > 0.0, np.sqrt(np.abs(own)), 1.0)[:, :, None]
    found = solved(M / (sizes * turned(sizes)), _columns(b) / sizes, first, negligible) / sizes
    return found if b.ndim == 3 else found[:, :, 0]


def symmetric(A: Array, first: Array) -> tuple[Array, Array]:
    """The eigenvalues of symmetric matrices, in the rows and columns from `first` (runs,) on, NaN before; and vectors
    of length 1 as columns, those of the identity before."""
    found, vectors = np.full(A.shape[:2], np.nan), np.broadcast_to(np.eye(A.shape[1]), A.shape).copy()
    _routine("rotated")(_given(A).copy(), first, found, vectors)
    return found, vectors


def eigenvalues(A: Array) -> Array:
    """Of real matrices, complex (runs, n); NaN where they are not found, as of what is not finite."""
    found = np.full(A.shape[:2], complex(np.nan, np.nan))
    for which, given in _sought(A, found):
        own = np.empty((2, *given.shape[:2]))
        _routine("eigenvalues", EIGENVALUES)(given, own[0], own[1], np.empty((0, 0)))
        found.real[which], found.imag[which] = own
    return found


def eigenvectors(A: Array) -> tuple[Array, Array]:
    """The same, and vectors of any length as columns (runs, n, n): of a real eigenvalue one; of a pair the real and the
    imaginary part of that of the first, whose imaginary part is positive."""
    found, vectors = np.full(A.shape[:2], complex(np.nan, np.nan)), np.full(A.shape, np.nan)
    for which, given in _sought(A, found):
        own, Z = np.empty((2, *given.shape[:2])), np.empty(given.shape)
        _routine("eigenvectors", EIGENVECTORS)(given, Z, own[0], own[1], np.empty((1, 2)))
        vectors[which], found.real[which], found.imag[which] = Z, *own
    return found, vectors


def _sought(A: Array, found: Array) -> Iterator[tuple[Array, Array]]:
    """Which eigenvalues are not found yet, and matrices to find those of: rounded otherwise, where shifts went round in
    circles."""
    draw = np.random.default_rng(1).uniform
    finite = np.isfinite(A).all(axis=(1, 2))
    for n in range(TIMES):
        which = np.flatnonzero(finite & np.isnan(found.real).any(axis=1))
        if not len(which) or not A.shape[1]:
            return
        yield which, _given(A[which] * (1.0 + ROUNDED * draw(-1.0, 1.0, A.shape[1:]) if n else 1.0)).copy()


def magnitudes(values: Array) -> Array:
    """Of complex numbers."""
    found: Array = np.sqrt(values.real * values.real + values.imag * values.imag)
    return found


def beyond_rounding(
    A: Array, values: Array, rates: slice, scale: Array, rounded: Callable[[Array], tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Eigenvalues (runs, n) without what of them is rounding, and which are 0: small ones that are not the same where
    entries of A are rounded otherwise; nor is growth that is not the same. scale (runs,): beside what they may be
    small; rounded: of some runs (indices), that the rows of `rates` are a matrix (some, rates, rates) times what may be
    wrong by so much (some, rates, n); entries of other rows may be as their largest one."""
    sizes = magnitudes(values)
    zero, largest = np.zeros(values.shape, bool), sizes.max(axis=1, initial=0.0)
    which = np.flatnonzero(sizes.min(axis=1, initial=np.inf) <= DOUBTFUL * np.maximum(largest, scale))
    if len(which):
        inverse, forces = rounded(which)
        entries = product(np.abs(inverse), forces)
        stiff, damped = (entries[:, :, x].max(axis=(1, 2), initial=0.0) for x in (slice(0, rates.start), rates))
        least = np.maximum(np.sqrt(stiff), damped)
        zero[which] = sizes[which] <= np.maximum(SMALL * largest[which], least)[:, None]
        some = (zero[which] & (sizes[which] > 0.0)).any(axis=1)
        which, inverse, forces = which[some], inverse[some], forces[some]
        every = np.broadcast_to(ROUNDED * np.abs(A[which]).max(axis=2)[:, :, None], A[which].shape).copy()
        every[:, rates] = STORED * np.abs(A[which][:, rates])

        def changes(signs: Array) -> Array:
            found = every * signs
            found[:, rates] += product(inverse, forces * signs[rates])
            return found

        moved = _moved(A[which], values[which], changes)
        zero[which] &= ~(moved < FIRM * sizes[which])
    grows = growing(np.where(zero, 0.0, values)) & (values.real < SLOWLY * sizes)
    which = np.flatnonzero(grows.any(axis=1))
    if len(which):
        moved = _moved(A[which], values[which], lambda signs: ROUNDED * np.abs(A[which]) * signs)
        grows[which] &= ~(moved < FIRM * values.real[which])
    found = np.where(zero, 0.0, values)
    found.real[grows & ~zero] = 0.0
    return found, zero


def _moved(A: Array, values: Array, changes: Callable[[Array], Array]) -> Array:
    """How far eigenvalues (runs, n) are from those of A at most, where its entries change by what random signs (n, n),
    from 0.5 to 1 in size, say."""
    n, draw, most = A.shape[1], np.random.default_rng(0).uniform, np.zeros(values.shape)
    for _ in range(TIMES):
        signs = draw(0.5, 1.0, (n, n)) * np.where(draw(-1.0, 1.0, (n, n)) < 0.0, -1.0, 1.0)
        others = eigenvalues(A + changes(signs))
        apart = magnitudes(values[:, :, None] - others[:, None, :]).min(axis=2)
        most = np.maximum(most, np.where(np.isnan(apart), np.inf, apart))
    return most


def growing(values: Array) -> Array:
    """Which eigenvalues (runs, n), 0 where they vanish, have a positive real part that is no rounding."""
    sizes = np.nan_to_num(magnitudes(values))
    least = np.maximum(SMALL * sizes, EVEN * sizes.max(axis=1, initial=0.0)[:, None])
    found: Array = np.nan_to_num(values.real, nan=-1.0) > least
    return found
