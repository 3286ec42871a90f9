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


def least(C: Entries, inverse: Entries, b: Sequence[Number], size: int, damping: Number = 0.0) -> list[Any]:
    """The x of least x^T W x with C x = b, or the closest that dependent rows allow; `inverse`: entries of W^-1.

    damping: with some, all rows count, and rows that contradict each other meet halfway (Levenberg and Marquardt).
    """
    by_column: dict[int, dict[int, Any]] = {}
    for (row, c), value in C.items():
        by_column.setdefault(c, {})[row] = value
    left: dict[int, dict[int, Any]] = {}  # column -> row -> (C W^-1)
    for (i, j), w in inverse.items():
        for row, value in by_column.get(i, {}).items():
            target = left.setdefault(j, {})
            target[row] = target.get(row, 0.0) + value * w
    m = len(b)
    S: list[dict[int, Any]] = [{} for _ in range(m)]  # lower triangle by column
    for c, lefts in left.items():
        for i, x in lefts.items():
            for j, y in by_column.get(c, {}).items():
                if i >= j:
                    S[j][i] = S[j].get(i, 0.0) + x * y
    for j in range(m):
        S[j][j] = S[j].get(j, 0.0) * (1.0 + damping)
    y = _solved(S, b)
    solution: list[Any] = [0.0] * size
    for c, lefts in left.items():
        for row, x in lefts.items():
            solution[c] = solution[c] + x * y[row]
    return solution


def _solved(S: list[dict[int, Number]], b: Sequence[Number]) -> list[Any]:
    """S^-1 b by L D L^T, in place, rows without a pivot left out; S: the lower triangle by column."""
    m = len(b)
    scale = [S[j].get(j, 0.0) for j in range(m)]
    most = reduce(maximum, scale, 0.0)
    y = list(b)
    kept: list[Any] = []
    for j in range(m):
        pivot = S[j].get(j, 0.0)
        independent = np.asarray(pivot > DEPENDENT * scale[j]) & np.asarray(pivot > ROUNDING * most)
        kept.append(where(independent, 1.0 / where(independent, pivot, 1.0), 0.0))
        below = [(i, x) for i, x in S[j].items() if i > j]
        for n, (i, x) in enumerate(below):
            factor = x * kept[j]
            y[i] = y[i] - factor * y[j]
            for i2, x2 in below[n:]:
                high, low = max(i, i2), min(i, i2)
                S[low][high] = S[low].get(high, 0.0) - factor * x2
    for j in reversed(range(m)):
        total = y[j]
        for i, x in S[j].items():
            if i > j:
                total = total - x * y[i]
        y[j] = total * kept[j]
    return y
