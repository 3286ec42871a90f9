"""Householder's reflections, substitutions, Jacobi's rotations as routines (Golub and Van Loan 2013)."""

import numpy as np

from lienumba.compiler.routines.marks import Floats1, Floats2, Floats3, Integers1, Integers2, apart

SWEEPS = 40  # of Jacobi's rotations; some ten are enough
EQUAL = 1e-17  # of the diagonal beside it: what need not be rotated away


def product(A: Floats3, B: Floats3, out: Floats3) -> None:
    for run in range(A.shape[0]):
        _product(A[run], B[run], out[run])


@apart
def _product(A: np.ndarray, B: np.ndarray, out: np.ndarray) -> None:
    for i in range(A.shape[0]):
        for j in range(B.shape[1]):
            out[i, j] = 0.0
        for k in range(B.shape[0]):
            a = A[i, k]
            for j in range(B.shape[1]):
                out[i, j] += a * B[k, j]


def reflected(
    L: Floats3, Q: Floats3, most: Integers1, rank: Integers1, order: Integers2, v: Floats1, negligible: float
) -> None:
    for run in range(L.shape[0]):
        rank[run] = _reflected(L[run], Q[run], most[run], order[run], v, negligible)


@apart
def _reflected(L: np.ndarray, Q: np.ndarray, most: int, order: np.ndarray, v: np.ndarray, negligible: float) -> int:
    m, n = L.shape[0], L.shape[1]
    for i in range(n):
        for j in range(n):
            Q[i, j] = 1.0 if i == j else 0.0
    for i in range(m):
        order[i] = i
    largest = 0.0
    for k in range(most):
        best, size = k, 0.0
        for i in range(k, m):
            total = 0.0
            for j in range(k, n):
                total += L[order[i], j] * L[order[i], j]
            if total > size:
                best, size = i, total
        size = np.sqrt(size)
        if not size > negligible * largest:
            return k
        largest = max(largest, size)
        row = order[best]
        order[best] = order[k]
        order[k] = row
        column = k
        for j in range(k, n):
            if L[row, j] * L[row, j] > L[row, column] * L[row, column]:
                column = j
        _swap_columns(L, k, column)  # so that what this row does not touch is not mixed with what it does
        _swap_columns(Q, k, column)
        for j in range(k, n):
            v[j] = L[row, j]
        v[k] += size if v[k] > 0.0 else -size
        beta = 0.0
        for j in range(k, n):
            beta += v[j] * v[j]
        beta = 2.0 / beta
        for i in range(k, m):
            _reflect(L[order[i]], v, k, n, beta)
        for i in range(n):
            _reflect(Q[i], v, k, n, beta)
    return most


@apart
def _swap_columns(A: np.ndarray, p: int, q: int) -> None:
    for i in range(A.shape[0]):
        x = A[i, p]
        A[i, p] = A[i, q]
        A[i, q] = x


@apart
def _reflect(x: np.ndarray, v: np.ndarray, first: int, n: int, beta: float) -> None:
    """x - beta (x v) v, from a number on."""
    total = 0.0
    for j in range(first, n):
        total += x[j] * v[j]
    for j in range(first, n):
        x[j] -= beta * total * v[j]


def forward(L: Floats3, rank: Integers1, order: Integers2, b: Floats3, out: Floats3) -> None:
    for run in range(L.shape[0]):
        for k in range(rank[run]):
            row = order[run, k]
            for c in range(b.shape[2]):
                total = b[run, row, c]
                for j in range(k):
                    total -= L[run, row, j] * out[run, j, c]
                out[run, k, c] = total / L[run, row, k]


def backward(L: Floats3, rank: Integers1, order: Integers2, g: Floats3, out: Floats3) -> None:
    for run in range(L.shape[0]):
        for n in range(rank[run]):
            k = rank[run] - 1 - n
            row = order[run, k]
            for c in range(g.shape[2]):
                total = g[run, k, c]
                for i in range(k + 1, rank[run]):
                    total -= L[run, order[run, i], k] * out[run, order[run, i], c]
                out[run, row, c] = total / L[run, row, k]


def solved(A: Floats3, b: Floats3, first: Integers1, x: Floats3, work: Floats2, negligible: float) -> None:
    for run in range(A.shape[0]):
        _solved(A[run], b[run], first[run], x[run], work, negligible)


@apart
def _solved(A: np.ndarray, b: np.ndarray, first: int, x: np.ndarray, work: np.ndarray, negligible: float) -> None:
    """By reflections of columns, the largest ones first."""
    n, v, order = b.shape[0], work[0], work[1]
    for j in range(n):
        order[j] = j
    rank, largest = first, 0.0
    for k in range(first, n):
        best, size = k, 0.0
        for j in range(k, n):
            total, column = 0.0, int(order[j])
            for i in range(k, n):
                total += A[i, column] * A[i, column]
            if not total <= size:
                best, size = j, total
        size = np.sqrt(size)
        if size <= negligible * largest:
            break
        largest = max(largest, size)
        column = int(order[best])
        order[best] = order[k]
        order[k] = column
        for i in range(k, n):
            v[i] = A[i, column]
        v[k] += size if v[k] > 0.0 else -size
        beta = 0.0
        for i in range(k, n):
            beta += v[i] * v[i]
        beta = 2.0 / beta
        for j in range(k, n):
            _reflect_column(A, int(order[j]), v, k, beta)
        for j in range(b.shape[1]):
            _reflect_column(b, j, v, k, beta)
        rank = k + 1
    for back in range(rank - first):
        k = rank - 1 - back
        own = int(order[k])
        for c in range(b.shape[1]):
            total = b[k, c]
            for j in range(k + 1, rank):
                total -= A[k, int(order[j])] * x[int(order[j]), c]
            x[own, c] = total / A[k, own]


@apart
def _reflect_column(A: np.ndarray, column: int, v: np.ndarray, first: int, beta: float) -> None:
    total = 0.0
    for i in range(first, A.shape[0]):
        total += A[i, column] * v[i]
    for i in range(first, A.shape[0]):
        A[i, column] -= beta * total * v[i]


def rotated(A: Floats3, first: Integers1, out: Floats2, V: Floats3) -> None:
    """V: the identity, which becomes what A is turned by."""
    for run in range(A.shape[0]):
        _rotated(A[run], V[run], first[run])
        for i in range(first[run], A.shape[1]):
            out[run, i] = A[run, i, i]


@apart
def _rotated(A: np.ndarray, V: np.ndarray, first: int) -> None:
    n = A.shape[0]
    for _ in range(SWEEPS):
        turned = 0
        for p in range(first, n):
            for q in range(p + 1, n):
                if A[p, q] * A[p, q] > EQUAL * EQUAL * (A[p, p] * A[p, p] + A[q, q] * A[q, q]):
                    turned += 1
                    _rotate(A, V, first, p, q)
        if turned == 0:
            return


@apart
def _rotate(A: np.ndarray, V: np.ndarray, first: int, p: int, q: int) -> None:
    """Such that A[p, q] becomes 0; V is turned with it."""
    half = (A[q, q] - A[p, p]) / (2.0 * A[p, q])
    size = (half if half > 0.0 else -half) + np.sqrt(half * half + 1.0)
    t = 1.0 / size if half >= 0.0 else -1.0 / size
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for k in range(first, A.shape[0]):
        a, b = A[k, p], A[k, q]
        A[k, p] = c * a - s * b
        A[k, q] = s * a + c * b
        a, b = V[k, p], V[k, q]
        V[k, p] = c * a - s * b
        V[k, q] = s * a + c * b
    for k in range(first, A.shape[0]):
        a, b = A[p, k], A[q, k]
        A[p, k] = c * a - s * b
        A[q, k] = s * a + c * b
