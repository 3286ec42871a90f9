"""Correlated inputs: uniform numbers whose normal scores have a given correlation (a Gaussian copula)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt

import numpy as np

from lienumba.errors import BadValueError

Rows = Sequence[Sequence[float]]
ROUNDING = 1e-10  # relative to the largest diagonal element


class MatrixError(BadValueError):
    """What is wrong with a matrix, and the remedy."""


def cholesky(matrix: Rows) -> list[list[float]]:
    """The lower triangle L with L L^T = matrix, which may be singular; a MatrixError where there is none."""
    size = len(matrix)
    largest = max(abs(matrix[i][i]) for i in range(size))
    L = [[0.0] * size for _ in range(size)]
    for i in range(size):
        for j in range(i):
            if abs(matrix[i][j] - matrix[j][i]) > ROUNDING * largest:
                raise MatrixError(
                    f"is not symmetric: [{i}][{j}] is {matrix[i][j]:g}, but [{j}][{i}] is {matrix[j][i]:g}",
                    "give both the same value",
                )
    for j in range(size):
        pivot = matrix[j][j] - _dot(L[j], L[j], j)
        if pivot < -ROUNDING * largest:
            _check_definite(matrix, largest)
        L[j][j] = sqrt(pivot) if pivot > ROUNDING * largest else 0.0
        for i in range(j + 1, size):
            left = matrix[i][j] - _dot(L[i], L[j], j)
            if L[j][j] > 0.0:
                L[i][j] = left / L[j][j]
            elif abs(left) > sqrt(ROUNDING) * largest:
                _check_definite(matrix, largest)
    return L


def _dot(a: Sequence[float], b: Sequence[float], n: int) -> float:
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


def _check_definite(matrix: Rows, largest: float) -> None:
    """A MatrixError where it is more than rounding, behind a small pivot, that makes a matrix look indefinite."""
    least = float(np.linalg.eigvalsh(np.array(matrix, float))[0])
    if least < -ROUNDING * largest:
        raise MatrixError(
            f"is not positive semi-definite (its smallest eigenvalue is {least:.3g}), so nothing varies like this",
            "give smaller elements beside the diagonal",
        )


def correlated(u: Mapping[str, np.ndarray], names: Sequence[str], matrix: Rows) -> dict[str, np.ndarray]:
    """The uniform numbers u (runs,) of these names with correlated normal scores z = L z0. The first one, and each that
    has no correlation with those before it, stays as it is, bit by bit."""
    from lienumba.sweep.normal import inverse, probability

    L = cholesky(matrix)
    scores = {name: inverse(u[name]) for name in names}
    found = {}
    for i, name in enumerate(names):
        if not any(L[i][:i]):
            found[name] = u[name]
            continue
        z = L[i][0] * scores[names[0]]
        for j in range(1, i + 1):
            z = z + L[i][j] * scores[names[j]]
        found[name] = _inside(probability(z))
    return found


def followed(scores: Mapping[str, np.ndarray], names: Sequence[str], matrix: Rows) -> dict[str, np.ndarray]:
    """Of correlated normal scores (runs,) of these names those that follow from others, as a singular matrix says."""
    L = cholesky(matrix)
    independent: list[np.ndarray] = []
    found = {}
    for i, name in enumerate(names):
        others = sum((L[i][j] * independent[j] for j in range(i)), np.zeros_like(scores[name]))
        if L[i][i] > 0.0:
            independent.append((scores[name] - others) / L[i][i])
        else:
            independent.append(np.zeros_like(others))
            found[name] = others
    return found


def _inside(u: np.ndarray) -> np.ndarray:
    return np.clip(u, 5e-324, 1.0 - 2.0**-53)
