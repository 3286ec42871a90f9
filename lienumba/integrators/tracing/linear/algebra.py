"""Dense linear algebra for many runs: arrays are (runs, rows, columns) or (runs, rows).

LAPACK does the work, by NumPy and SciPy. A matrix that is not finite gives NaN in its own run and nowhere else.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import qr, solve_triangular

Array = npt.NDArray[Any]
ROW_RTOL = 1e-10  # relative to the longest row, or to 1: a shorter row of C is zero
MASS_RTOL = 1e-13  # relative to the largest eigenvalue of the scaled masses: a smaller one is zero
TIE = (
    1e-6  # relative: of columns that are equally long the last one counts as the longest, so the first are independent
)
GROWTH_RTOL = 1e-7  # relative to an eigenvalue: less growth is roundoff
FITS_RTOL = 1e-3  # of the smallest singular value of C: that of the columns of dependent coordinates is larger
ROUNDOFF_RTOL = 1e-13  # relative to the largest eigenvalue: the error of a single one is smaller
PAIR_RTOL = 3e-7  # the same: roundoff moves a double one apart by less


def applied(A: Array, x: Array) -> Array:
    """A x of each run, for vectors (runs, columns)."""
    product: Array = (A @ x[:, :, None])[:, :, 0]
    return product


def is_finite(*arrays: Array) -> Array:
    """Whether all numbers of a run are finite (runs,)."""
    return np.logical_and.reduce([np.isfinite(x).reshape(len(x), -1).all(axis=1) for x in arrays])


def unit_rows(C: Array) -> tuple[Array, Array]:
    """C with rows of length 1, and their lengths (runs, rows). Rows that are zero stay zero and have the length 1."""
    lengths = np.linalg.norm(C, axis=2)
    longest = lengths.max(axis=1, initial=1.0)[:, None]
    lengths = np.where(lengths <= ROW_RTOL * longest, 0.0, lengths)
    zero = lengths == 0.0
    return np.where(zero[:, :, None], 0.0, C / np.where(zero, 1.0, lengths)[:, :, None]), np.where(zero, 1.0, lengths)


@dataclass(frozen=True)
class NullSpace:
    """The null space of constraints in coordinates: independent ones move freely, the others follow.

    C (runs, m, n): the Jacobians, with rows of length 1 or 0; lengths (runs, m): of the rows before that; independent
    (runs, n): which coordinates are; basis (runs, n, n): column j is the motion with the independent coordinate j = 1
    and all other independent ones 0, and zero where j is dependent. So constraints that do not touch a coordinate leave
    exact zeros there.
    """

    C: Array
    lengths: Array
    independent: Array
    basis: Array

    @staticmethod
    def of(C: Array, rtol: float, max_rank: Array | None = None) -> "NullSpace":
        """Choose independent coordinates by QR decompositions with column pivoting.

        Parameters
        ----------
        C : ndarray (runs, m, n)
            Constraint Jacobians.
        rtol : float
            A diagonal element of R below this, relative to the largest, counts as zero.
        max_rank : ndarray (runs,), optional
            The largest rank that C may have.
        """
        C, lengths = unit_rows(C)
        independent = np.ones((len(C), C.shape[2]), bool)
        for run in np.flatnonzero(is_finite(C)) if C.size else ():
            R, order = qr(C[run] * (1.0 + TIE * np.arange(C.shape[2])), mode="r", pivoting=True)
            size = np.abs(R.diagonal())
            rank = int((size > rtol * size.max()).sum())
            independent[run, order[: rank if max_rank is None else min(rank, max_rank[run])]] = False
        return NullSpace(C, lengths, independent, _basis(C, independent))

    def along(self, independent: Array) -> "NullSpace":
        """The null space with these independent coordinates (n,)."""
        if (self.independent == independent).all():
            return self
        chosen = np.broadcast_to(independent, self.independent.shape)
        return replace(self, independent=chosen, basis=_basis(self.C, chosen))

    def part(self, runs: Array) -> "NullSpace":
        """The null spaces of these runs alone."""
        return NullSpace(self.C[runs], self.lengths[runs], self.independent[runs], self.basis[runs])

    @property
    def rank(self) -> Array:
        """The rank of C (runs,)."""
        rank: Array = (~self.independent).sum(axis=1)
        return rank

    @cached_property
    def inverse(self) -> Array:
        """The pseudo-inverse of C (runs, n, m) before its rows had length 1: C x = b has the shortest solution
        x = inverse b."""
        finite = is_finite(self.C)
        inverse = np.full(self.C.mT.shape, np.nan)
        U, S, Vt = np.linalg.svd(self.C[finite], full_matrices=False)
        counts = np.arange(S.shape[1]) < self.rank[finite][:, None]
        weights = np.where(counts, 1.0 / np.where(counts, S, 1.0), 0.0)
        inverse[finite] = (Vt.mT * weights[:, None, :]) @ U.mT
        return inverse / self.lengths[:, None, :]

    def fits(self, independent: Array) -> Array:
        """Whether these coordinates (n,) are independent in each run, and far from being dependent (runs,)."""
        if (rank := int((~independent).sum())) == 0:
            return self.rank == 0
        finite = is_finite(self.C)
        C = np.where(finite[:, None, None], self.C, 0.0)
        own, every = (np.linalg.svd(x, compute_uv=False)[:, rank - 1] for x in (C[:, :, ~independent], C))
        fits: Array = finite & (self.rank == rank) & (own > FITS_RTOL * every)
        return fits

    def masses(self, M: Array) -> Array:
        """The masses (runs, n, n) of the independent coordinates, and the unit matrix for the dependent ones."""
        masses: Array = self.basis.mT @ M @ self.basis
        dependent = np.where(self.independent, 0.0, 1.0)
        return masses + dependent[:, :, None] * np.eye(M.shape[1])

    def dependent(self, b: Array) -> Array:
        """Solve C x = b (runs, m, k) by the x that is 0 in the independent coordinates."""
        x = self.inverse @ b
        return x - self.basis @ x

    def motion(self, M: Array, g: Array, b: Array) -> tuple[Array, Array]:
        """Solve M x + C^T mu = g (runs, n, k) and C x = b (runs, m, k); of redundant rows mu is the shortest."""
        x = self.dependent(b)
        x = x + self.basis @ accelerations(self.masses(M), self.basis.mT @ (g - M @ x))
        return x, self.inverse.mT @ (g - M @ x)


def _basis(C: Array, independent: Array) -> Array:
    """The basis of null spaces, from QR decompositions with the columns of the dependent coordinates first."""
    runs, _, n = C.shape
    basis = np.broadcast_to(np.eye(n), (runs, n, n)).copy()
    finite = is_finite(C)
    basis[~finite] = np.nan
    for run in np.flatnonzero(finite & ~independent.all(axis=1)):
        follows, leads = np.flatnonzero(~independent[run]), np.flatnonzero(independent[run])
        R, r = qr(C[run][:, [*follows, *leads]], mode="r")[0], len(follows)
        basis[run, :, follows] = 0.0
        basis[run, follows[:, None], leads] = -solve_triangular(R[:r, :r], R[:r, r:])
    return basis


def accelerations(M: Array, b: Array) -> Array:
    """Solve M x = b for positive definite M and b (runs, n, k). Without mass along a direction it does not move."""
    diagonal = M.diagonal(axis1=1, axis2=2)
    sizes = np.where(diagonal > 0.0, np.sqrt(np.abs(diagonal)), 1.0)[:, :, None]
    with np.errstate(invalid="ignore"):
        scaled, right = M / (sizes * sizes.mT), b / sizes
    bad = ~is_finite(scaled, right)
    scaled = np.where(bad[:, None, None], np.eye(M.shape[1]), scaled)
    right = np.where(bad[:, None, None], 0.0, right)
    singular = np.linalg.eigvalsh(scaled).min(axis=1, initial=1.0) <= MASS_RTOL
    x = np.linalg.solve(np.where(singular[:, None, None], np.eye(M.shape[1]), scaled), right)
    if singular.any():
        x[singular] = np.linalg.pinv(scaled[singular], MASS_RTOL, hermitian=True) @ right[singular]
    x[bad] = np.nan
    return x / sizes


def eigenvalues(A: Array, scale: Array) -> Array:
    """The eigenvalues (runs, n) of real matrices; scale (runs,): what their entries are sums of may be as large."""
    finite = is_finite(A)
    values = np.full(A.shape[:2], complex(np.nan, np.nan))
    values[finite] = np.linalg.eigvals(A[finite])
    return _without_zeros(values, scale)


def eigenvectors(A: Array, scale: Array) -> tuple[Array, Array]:
    """The eigenvalues (runs, n) of finite real matrices, and eigenvectors of length 1 as columns (runs, n, n)."""
    values, vectors = np.linalg.eig(A)
    return _without_zeros(values.astype(complex), scale), vectors.astype(complex)


def grows(values: Array) -> Array:
    """Which eigenvalues (runs, n) have a positive real part that roundoff does not explain."""
    sizes = np.abs(values)
    largest = np.nan_to_num(sizes).max(axis=1, initial=0.0)[:, None]
    least = np.maximum(GROWTH_RTOL * sizes, _unknown(values, largest))
    with np.errstate(invalid="ignore"):
        return (values.real > least) & (values.real > ROUNDOFF_RTOL * largest)


def _without_zeros(values: Array, scale: Array) -> Array:
    """Eigenvalues of which those that are zero but for roundoff are zero."""
    sizes = np.abs(values)
    largest = np.maximum(sizes.max(axis=1, initial=0.0), scale)[:, None]
    with np.errstate(invalid="ignore"):
        return np.where(sizes <= np.maximum(ROUNDOFF_RTOL * largest, _unknown(values, largest)), 0.0, values)


def _unknown(values: Array, largest: Array) -> Array:
    """By how much eigenvalues (runs, n) are not known because another one is close; 0 where none is."""
    apart = np.abs(values[:, :, None] - values[:, None, :])
    apart[:, range(values.shape[1]), range(values.shape[1])] = np.inf
    nearest = apart.min(axis=2, initial=np.inf)
    return np.where(nearest <= PAIR_RTOL * largest, np.maximum(2.0 * nearest, 0.1 * PAIR_RTOL * largest), 0.0)
