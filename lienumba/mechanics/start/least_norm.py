"""Least changes that fulfil linear conditions, elementwise: numbers are floats or arrays of shape (runs,)."""

from collections.abc import Sequence
from functools import reduce
from typing import Any, Protocol

import numpy as np

from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, where

ROUNDING = 1e-26  # of the largest diagonal: a row below is zero but for rounding
DEPENDENT = 1e-12  # a pivot below this fraction of its diagonal belongs to a row that adds nothing
FEW = 8  # runs up to which a matrix of all entries is faster than a number for each

Entries = dict[tuple[int, int], Any]
Columns = list[dict[int, Any]]  # the lower triangle of a symmetric matrix by column; the order of entries counts


class Solve(Protocol):
    def __call__(self, b: Sequence[Number]) -> list[Any]: ...


class Least:
    """The x of least x^T W x with C x = b, or the closest that dependent rows allow, for any b; `inverse`: entries of
    W^-1; rows, size: of C.

    damping: with some, all rows count, and rows that contradict each other meet halfway (Levenberg and Marquardt).
    """

    def __init__(self, C: Entries, inverse: Entries, rows: int, size: int, damping: Number = 0.0) -> None:
        by_column: dict[int, dict[int, Any]] = {}
        for (row, c), value in C.items():
            by_column.setdefault(c, {})[row] = value
        left: dict[int, dict[int, Any]] = {}  # column -> row -> (C W^-1)
        for (i, j), w in inverse.items():
            for row, value in by_column.get(i, {}).items():
                target = left.setdefault(j, {})
                target[row] = target.get(row, 0.0) + value * w
        S: Columns = [{} for _ in range(rows)]
        for c, lefts in left.items():
            for i, x in lefts.items():
                for j, y in by_column.get(c, {}).items():
                    if i >= j:
                        S[j][i] = S[j].get(i, 0.0) + x * y
        for j in range(rows):
            S[j][j] = S[j].get(j, 0.0) * (1.0 + damping)
        self._left, self._size = left, size
        self._solve = eliminated(S)

    def change(self, b: Sequence[Number]) -> list[Any]:
        """The x of this b."""
        y = self._solve(b)
        solution: list[Any] = [0.0] * self._size
        for c, lefts in self._left.items():
            for row, x in lefts.items():
                solution[c] = solution[c] + x * y[row]
        return solution


def least(C: Entries, inverse: Entries, b: Sequence[Number], size: int, damping: Number = 0.0) -> list[Any]:
    """See `Least`."""
    return Least(C, inverse, len(b), size, damping).change(b)


def eliminated(S: Columns) -> Solve:
    """What solves S y = b by L D L^T, rows without a pivot left out."""
    own = [S[j].get(j, 0.0) for j in range(len(S))]
    runs = max((np.size(x) for x in own if np.ndim(x)), default=0)
    if not runs and any(np.ndim(x) for column in S for x in column.values()):
        return _Entries(S)  # of which some results are the same in all runs
    return _Matrix(S, (runs,) if runs else ()) if runs <= FEW else _Entries(S)


def _kept(pivot: Any, scale: Any, most: Any) -> Any:
    """1/pivot; 0 where the row depends on those before it."""
    independent = np.asarray(pivot > DEPENDENT * scale) & np.asarray(pivot > ROUNDING * most)
    return where(independent, 1.0 / where(independent, pivot, 1.0), 0.0)


class _Entries:
    """S eliminated entry by entry."""

    def __init__(self, S: Columns) -> None:
        self.S = S
        scale = [S[j].get(j, 0.0) for j in range(len(S))]
        most = reduce(maximum, scale, 0.0)
        self.kept: list[Any] = []
        for j, column in enumerate(S):
            self.kept.append(_kept(column.get(j, 0.0), scale[j], most))
            below = [(i, x) for i, x in column.items() if i > j]
            for n, (i, x) in enumerate(below):
                factor = x * self.kept[j]
                for i2, x2 in below[n:]:
                    high, low = max(i, i2), min(i, i2)
                    S[low][high] = S[low].get(high, 0.0) - factor * x2

    def __call__(self, b: Sequence[Number]) -> list[Any]:
        y: list[Any] = list(b)
        for j, column in enumerate(self.S):
            for i, x in column.items():
                if i > j:
                    y[i] = y[i] - x * self.kept[j] * y[j]
        for j in reversed(range(len(y))):
            total = y[j]
            for i, x in self.S[j].items():
                if i > j:
                    total = total - x * y[i]
            y[j] = total * self.kept[j]
        return y


class _Matrix:
    """The same operations on every entry, in the same order, column by column on a matrix; shape: of a number."""

    def __init__(self, S: Columns, shape: tuple[int, ...]) -> None:
        m = len(S)
        self.shape = shape
        self.A = A = np.zeros((m, m, *shape))
        for j, column in enumerate(S):
            for i, x in column.items():
                A[i, j] = A[j, i] = x
        scale = [A[j, j].copy() for j in range(m)]
        most = reduce(maximum, scale, 0.0)
        order = [dict.fromkeys(column) for column in S]
        self.below: list[np.ndarray] = []
        self.kept: list[Any] = []
        for j in range(m):
            self.kept.append(_kept(A[j, j], scale[j], most))
            own = dict.fromkeys(i for i in order[j] if i > j)
            for i in own:
                order[i] |= own
            rows = np.array(list(own), int)
            self.below.append(rows)
            x = A[rows, j]
            factor = x * self.kept[j]
            products = factor[:, None] * x[None]  # of two rows: the factor of that which comes first
            first = np.tri(len(rows), dtype=bool).T.reshape(len(rows), len(rows), *[1] * len(shape))
            block = np.ix_(rows, rows)
            A[block] = A[block] - np.where(first, products, products.swapaxes(0, 1))

    def __call__(self, b: Sequence[Number]) -> list[Any]:
        shape = np.broadcast_shapes(self.shape, *(np.asarray(x).shape for x in b))
        y = np.array([np.broadcast_to(np.asarray(x, float), shape) for x in b])
        A = self.A.reshape(*self.A.shape[:2], *[1] * (len(shape) - len(self.shape)), *self.shape)
        for j, rows in enumerate(self.below):
            y[rows] = y[rows] - A[rows, j] * self.kept[j] * y[j]
        for j in reversed(range(len(y))):
            rows = self.below[j]
            y[j] = np.subtract.reduce(np.concatenate([y[j][None], A[rows, j] * y[rows]])) * self.kept[j]
        return list(y)
