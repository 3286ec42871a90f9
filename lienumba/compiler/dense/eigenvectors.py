"""Eigenvectors of real matrices as routines, from the form to which `eigenvalues` has brought them.

After the second half of hqr2 of EISPACK (Smith et al. 1976, Matrix Eigensystem Routines): those of the nearly
triangular matrix by substitution, where eigenvalues that are equal count as apart by rounding.
"""

import numpy as np

from lienumba.compiler.dense.eigenvalues import ROUNDING, balance, found, lose, reduce, size_of
from lienumba.compiler.routines.marks import Floats2, Floats3, apart, inlined


def eigenvectors(A: Floats3, Z: Floats3, real: Floats2, imaginary: Floats2, work: Floats2) -> None:
    """Of matrices (runs, n, n), which are overwritten, as columns of Z: of a pair of eigenvalues the real and the
    imaginary part of that with the positive imaginary part. Where they are not found eigenvalues are NaN. work (1, 2):
    room."""
    n = A.shape[1]
    for run in range(A.shape[0]):
        for i in range(n):
            for j in range(n):
                Z[run, i, j] = 1.0 if i == j else 0.0
        balance(A[run], Z[run], True)
        reduce(A[run], Z[run], True)
        if found(A[run], Z[run], real[run], imaginary[run], True):
            _vectors(A[run], Z[run], real[run], imaginary[run], work[0])
        else:
            lose(real[run], imaginary[run])


@apart
def _vectors(H: np.ndarray, Z: np.ndarray, real: np.ndarray, imaginary: np.ndarray, quotient: np.ndarray) -> None:
    """Column by column of H, from the last one on, then Z times these."""
    size, norm = H.shape[0], 0.0
    for i in range(size):
        for j in range(max(i - 1, 0), size):
            norm += size_of(H[i, j])
    norm = norm if norm > 0.0 else 1.0
    for back in range(size):
        n = size - 1 - back
        if imaginary[n] == 0.0:
            _real(H, n, real, imaginary, norm)
        elif imaginary[n] < 0.0:
            _complex(H, n, real, imaginary, norm, quotient)
    for back in range(size):
        j = size - 1 - back
        for i in range(size):
            total = 0.0
            for k in range(j + 1):
                total += Z[i, k] * H[k, j]
            Z[i, j] = total


@inlined
def _shrink(H: np.ndarray, first: int, column: int, last: int, size: float) -> None:
    """Columns up to one, where numbers have become so large that their products would overflow."""
    if ROUNDING * size * size > 1.0:
        for j in range(first, last + 1):
            for k in range(column, last + 1):
                H[j, k] /= size


@apart
def _real(H: np.ndarray, n: int, real: np.ndarray, imaginary: np.ndarray, norm: float) -> None:
    """That of a real eigenvalue, into column n of H."""
    first, z, s, p = n, 0.0, 0.0, real[n]
    H[n, n] = 1.0
    for back in range(n):
        i = n - 1 - back
        w, r = H[i, i] - p, 0.0
        for j in range(first, n + 1):
            r += H[i, j] * H[j, n]
        if imaginary[i] < 0.0:
            z, s = w, r
            continue
        first = i
        if imaginary[i] == 0.0:
            least = ROUNDING * (size_of(p) + size_of(H[i, i]))
            least = least if least > 0.0 else ROUNDING * norm
            H[i, n] = -r / (w if size_of(w) > least else (least if w >= 0.0 else -least))
        else:
            x, y = H[i, i + 1], H[i + 1, i]
            q = (real[i] - p) * (real[i] - p) + imaginary[i] * imaginary[i]
            t = (x * s - z * r) / q
            H[i, n] = t
            H[i + 1, n] = (-r - w * t) / x if size_of(x) > size_of(z) else (-s - y * t) / z
        _shrink(H, i, n, n, size_of(H[i, n]))


@inlined
def _divide(a: float, b: float, c: float, d: float, to: np.ndarray) -> None:
    """(a + i b) / (c + i d)."""
    if size_of(c) > size_of(d):
        r = d / c
        e = c + r * d
        to[0] = (a + r * b) / e
        to[1] = (b - r * a) / e
    else:
        r = c / d
        e = d + r * c
        to[0] = (r * a + b) / e
        to[1] = (r * b - a) / e


@apart
def _complex(
    H: np.ndarray, n: int, real: np.ndarray, imaginary: np.ndarray, norm: float, quotient: np.ndarray
) -> None:  # fmt: skip
    """That of a pair, into columns n - 1 and n of H; the last of its numbers is 1."""
    first, z, r, s, p, q = n - 1, 0.0, 0.0, 0.0, real[n], imaginary[n]
    if size_of(H[n, n - 1]) > size_of(H[n - 1, n]):
        H[n - 1, n - 1] = q / H[n, n - 1]
        H[n - 1, n] = -(H[n, n] - p) / H[n, n - 1]
    else:
        _divide(0.0, -H[n - 1, n], H[n - 1, n - 1] - p, q, quotient)
        H[n - 1, n - 1] = quotient[0]
        H[n - 1, n] = quotient[1]
    H[n, n - 1] = 0.0
    H[n, n] = 1.0
    for back in range(n - 1):
        i = n - 2 - back
        w, a, b = H[i, i] - p, 0.0, 0.0
        for j in range(first, n + 1):
            a += H[i, j] * H[j, n - 1]
            b += H[i, j] * H[j, n]
        if imaginary[i] < 0.0:
            z, r, s = w, a, b
            continue
        first = i
        if imaginary[i] == 0.0:
            _divide(-a, -b, w, q, quotient)
            H[i, n - 1] = quotient[0]
            H[i, n] = quotient[1]
        else:
            x, y = H[i, i + 1], H[i + 1, i]
            c = (real[i] - p) * (real[i] - p) + imaginary[i] * imaginary[i] - q * q
            d = 2.0 * q * (real[i] - p)
            if c == 0.0 and d == 0.0:
                c = ROUNDING * norm * (size_of(w) + size_of(q) + size_of(x) + size_of(y) + size_of(z))
            _divide(x * r - z * a + q * b, x * s - z * b - q * a, c, d, quotient)
            H[i, n - 1] = quotient[0]
            H[i, n] = quotient[1]
            if size_of(x) > size_of(z) + size_of(q):
                H[i + 1, n - 1] = (-a - w * H[i, n - 1] + q * H[i, n]) / x
                H[i + 1, n] = (-b - w * H[i, n] - q * H[i, n - 1]) / x
            else:
                _divide(-r - y * H[i, n - 1], -s - y * H[i, n], z, q, quotient)
                H[i + 1, n - 1] = quotient[0]
                H[i + 1, n] = quotient[1]
        _shrink(H, i, n - 1, n, max(size_of(H[i, n - 1]), size_of(H[i, n])))
