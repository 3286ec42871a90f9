"""Least changes that fulfil linear conditions, elementwise: numbers are floats or arrays of shape (runs,)."""

from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np

from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, where

ROUNDING = 1e-26  # of the largest diagonal: a row below is zero but for rounding
DEPENDENT = 1e-12  # a pivot below this fraction of its diagonal belongs to a row that adds nothing

Entries = dict[tuple[int, int], Any]


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
        S: list[dict[int, Any]] = [{} for _ in range(rows)]  # C W^-1 C^T, its lower triangle by column
        for c, lefts in left.items():
            for i, x in lefts.items():
                for j, y in by_column.get(c, {}).items():
                    if i >= j:
                        S[j][i] = S[j].get(i, 0.0) + x * y
        for j in range(rows):
            S[j][j] = S[j].get(j, 0.0) * (1.0 + damping)
        self._left, self._size, self._S = left, size, S
        self._inverse_pivots = _eliminated(S)

    def change(self, b: Sequence[Number]) -> list[Any]:
        """The x of this b."""
        y: list[Any] = list(b)
        for j, column in enumerate(self._S):
            for i, x in column.items():
                if i > j:
                    y[i] = y[i] - x * self._inverse_pivots[j] * y[j]
        for j in reversed(range(len(y))):
            total = y[j]
            for i, x in self._S[j].items():
                if i > j:
                    total = total - x * y[i]
            y[j] = total * self._inverse_pivots[j]
        solution: list[Any] = [0.0] * self._size
        for c, lefts in self._left.items():
            for row, x in lefts.items():
                solution[c] = solution[c] + x * y[row]
        return solution


def _eliminated(S: list[dict[int, Any]]) -> list[Any]:
    """Eliminate S to L D L^T, in place; the inverse of D, 0 for rows that depend on those before them."""
    scale = [S[j].get(j, 0.0) for j in range(len(S))]
    most = reduce(maximum, scale, 0.0)
    inverse_pivots: list[Any] = []
    for j, column in enumerate(S):
        pivot = column.get(j, 0.0)
        independent = np.asarray(pivot > DEPENDENT * scale[j]) & np.asarray(pivot > ROUNDING * most)
        inverse_pivots.append(where(independent, 1.0 / where(independent, pivot, 1.0), 0.0))
        below = [(i, x) for i, x in column.items() if i > j]
        for n, (i, x) in enumerate(below):
            factor = x * inverse_pivots[j]
            for i2, x2 in below[n:]:
                high, low = max(i, i2), min(i, i2)
                S[low][high] = S[low].get(high, 0.0) - factor * x2
    return inverse_pivots
