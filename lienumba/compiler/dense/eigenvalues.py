"""Eigenvalues of real matrices as routines: balanced, made Hessenberg, and then Francis' double steps.

After balanc, elmhes, elmtrans and hqr2 of EISPACK (Smith et al. 1976, Matrix Eigensystem Routines). Where vectors are
wanted, A becomes Z S Z^-1 with S upper triangular but for blocks of two, and the eigenvalues have the same bits.
"""

import numpy as np

from lienumba.compiler.routines.marks import Floats2, Floats3, apart, inlined

ROUNDING = 2.3e-16
ITERATIONS = 90  # for one eigenvalue; some three are enough
UNUSUAL = 10  # iterations, after which a shift is tried that is none of the usual ones
BALANCED = 0.95  # of the norms of a row and its column: what is not worth scaling
NAN = float("nan")


def eigenvalues(A: Floats3, real: Floats2, imaginary: Floats2, none: Floats2) -> None:
    """Of matrices (runs, n, n), which are overwritten; NaN where they are not found; none: an empty array."""
    for run in range(A.shape[0]):
        balance(A[run], none, False)
        reduce(A[run], none, False)
        if not found(A[run], none, real[run], imaginary[run], False):
            lose(real[run], imaginary[run])


@inlined
def lose(real: np.ndarray, imaginary: np.ndarray) -> None:
    for k in range(real.shape[0]):
        real[k] = NAN
        imaginary[k] = NAN


@inlined
def size_of(x: float) -> float:
    return -x if x < 0.0 else x


@apart
def balance(A: np.ndarray, Z: np.ndarray, vectors: bool) -> None:
    """Scale rows and columns by powers of two until they are alike; Z (diagonal) by as much, if vectors are wanted."""
    n, goes_on = A.shape[0], True
    for _ in range(ITERATIONS):
        if not goes_on:
            return
        goes_on = False
        for i in range(n):
            column, row = 0.0, 0.0
            for j in range(n):
                if j != i:
                    column += size_of(A[j, i])
                    row += size_of(A[i, j])
            f, total, scaled = 1.0, column + row, column
            if column > 0.0 and row > 0.0 and total < 1e300:
                while scaled < 0.5 * row / f:
                    f *= 2.0
                    scaled = column * f
                while scaled >= 2.0 * row / f:
                    f *= 0.5
                    scaled = column * f
                if scaled + row / f < BALANCED * total:
                    goes_on = True
                    for j in range(n):
                        A[i, j] /= f
                    for j in range(n):
                        A[j, i] *= f
                    if vectors:
                        Z[i, i] *= f


@apart
def reduce(A: np.ndarray, Z: np.ndarray, vectors: bool) -> None:
    """To Hessenberg's form, by elimination with pivots."""
    n = A.shape[0]
    for m in range(1, n - 1):
        pivot, best = 0.0, m
        for j in range(m, n):
            if size_of(A[j, m - 1]) > size_of(pivot):
                pivot, best = A[j, m - 1], j
        if best != m:
            for j in range(m - 1, n):
                x = A[best, j]
                A[best, j] = A[m, j]
                A[m, j] = x
            for j in range(n):
                x = A[j, best]
                A[j, best] = A[j, m]
                A[j, m] = x
            for j in range(n if vectors else 0):
                x = Z[j, best]
                Z[j, best] = Z[j, m]
                Z[j, m] = x
        if pivot != 0.0:
            for i in range(m + 1, n):
                factor = A[i, m - 1] / pivot
                if factor != 0.0:
                    for j in range(m - 1, n):
                        A[i, j] -= factor * A[m, j]
                    for j in range(n):
                        A[j, m] += factor * A[j, i]
                    for j in range(n if vectors else 0):
                        Z[j, m] += factor * Z[j, i]
    for i in range(2, n):
        for j in range(i - 1):
            A[i, j] = 0.0


@apart
def found(H: np.ndarray, Z: np.ndarray, real: np.ndarray, imaginary: np.ndarray, vectors: bool) -> bool:
    """From the last ones to the first, each pair deflated; whether all were found."""
    end, shift, tried, norm = H.shape[0] - 1, 0.0, 0, 0.0
    for i in range(H.shape[0]):
        for j in range(max(i - 1, 0), H.shape[0]):
            norm += size_of(H[i, j])
    while end >= 0:
        first = _split(H, end, norm)
        x = H[end, end]
        if first == end:
            H[end, end] = x + shift
            real[end] = x + shift
            imaginary[end] = 0.0
            end, tried = end - 1, 0
        elif first == end - 1:
            _pair(H, Z, end, shift, real, imaginary, vectors)
            end, tried = end - 2, 0
        else:
            if tried == ITERATIONS:
                return False
            y, w = H[end - 1, end - 1], H[end, end - 1] * H[end - 1, end]
            if tried % UNUSUAL == UNUSUAL - 1:
                shift += x
                for i in range(end + 1):
                    H[i, i] -= x
                s = size_of(H[end, end - 1]) + size_of(H[end - 1, end - 2])
                x = 0.75 * s
                y, w = x, -0.4375 * s * s
            tried += 1
            _step(H, Z, first, end, x, y, w, vectors)
    return True


@apart
def _split(H: np.ndarray, end: int, norm: float) -> int:
    """Where the last block begins that does not fall apart."""
    first = end
    while first > 0:
        s = size_of(H[first - 1, first - 1]) + size_of(H[first, first])
        s = norm if s == 0.0 else s
        if size_of(H[first, first - 1]) <= ROUNDING * s:
            H[first, first - 1] = 0.0
            return first
        first -= 1
    return 0


@apart
def _pair(
    H: np.ndarray, Z: np.ndarray, end: int, shift: float, real: np.ndarray, imaginary: np.ndarray, vectors: bool
) -> None:
    x, w = H[end, end], H[end, end - 1] * H[end - 1, end]
    p = 0.5 * (H[end - 1, end - 1] - x)
    q = p * p + w
    z = np.sqrt(size_of(q))
    x += shift
    H[end, end] = x
    H[end - 1, end - 1] += shift
    if q >= 0.0:
        z = p + (z if p >= 0.0 else -z)
        real[end - 1] = x + z
        real[end] = x - w / z if z != 0.0 else x + z
        imaginary[end - 1] = 0.0
        imaginary[end] = 0.0
        if vectors:
            _part(H, Z, end, p, z)
    else:
        real[end - 1] = x + p
        real[end] = x + p
        imaginary[end - 1] = z
        imaginary[end] = -z


@apart
def _part(H: np.ndarray, Z: np.ndarray, end: int, p: float, z: float) -> None:
    """Turn two rows and columns so that a real pair stands on the diagonal."""
    n, below = H.shape[0], H[end, end - 1]
    s = size_of(below) + size_of(z)
    if s == 0.0:
        return
    c, s = z / s, below / s
    r = np.sqrt(c * c + s * s)
    c, s = c / r, s / r
    for j in range(end - 1, n):
        a = H[end - 1, j]
        H[end - 1, j] = c * a + s * H[end, j]
        H[end, j] = c * H[end, j] - s * a
    for i in range(end + 1):
        a = H[i, end - 1]
        H[i, end - 1] = c * a + s * H[i, end]
        H[i, end] = c * H[i, end] - s * a
    for i in range(n):
        a = Z[i, end - 1]
        Z[i, end - 1] = c * a + s * Z[i, end]
        Z[i, end] = c * Z[i, end] - s * a
    H[end, end - 1] = 0.0


@apart
def _step(
    H: np.ndarray, Z: np.ndarray, first: int, end: int, x: float, y: float, w: float, vectors: bool
) -> None:  # fmt: skip
    """One double step with the shifts of the last block of two: their sum x + y, their product x y - w."""
    m = end - 2
    p, q, r = 0.0, 0.0, 0.0
    while m >= first:
        z = H[m, m]
        a, b = x - z, y - z
        p = (a * b - w) / H[m + 1, m] + H[m, m + 1]
        q = H[m + 1, m + 1] - z - a - b
        r = H[m + 2, m + 1]
        s = size_of(p) + size_of(q) + size_of(r)
        p, q, r = p / s, q / s, r / s
        if m == first:
            break
        u = size_of(H[m, m - 1]) * (size_of(q) + size_of(r))
        if u <= ROUNDING * size_of(p) * (size_of(H[m - 1, m - 1]) + size_of(z) + size_of(H[m + 1, m + 1])):
            break
        m -= 1
    for i in range(m + 2, end + 1):
        H[i, i - 2] = 0.0
        if i != m + 2:
            H[i, i - 3] = 0.0
    for k in range(m, end):
        size = 1.0
        if k != m:
            p, q = H[k, k - 1], H[k + 1, k - 1]
            r = H[k + 2, k - 1] if k != end - 1 else 0.0
            size = size_of(p) + size_of(q) + size_of(r)
            if size != 0.0:
                p, q, r = p / size, q / size, r / size
        s = np.sqrt(p * p + q * q + r * r)
        s = s if p >= 0.0 else -s
        if s != 0.0:
            if k != m:
                H[k, k - 1] = -s * size
            elif first != m:
                H[k, k - 1] = -H[k, k - 1]
            p += s
            _reflect(H, 0 if vectors else first, end, k, p / s, q / s, r / s, q / p, r / p, vectors)
            if vectors:
                _reflect_columns(Z, 0, H.shape[0], end, k, p / s, q / s, r / s, q / p, r / p)


@inlined
def _reflect(
    H: np.ndarray, first: int, end: int, k: int, x: float, y: float, z: float, q: float, r: float, vectors: bool
) -> None:  # fmt: skip
    """Rows and columns k to k + 2, or k + 1 at the end."""
    for j in range(k, H.shape[0] if vectors else end + 1):
        p = H[k, j] + q * H[k + 1, j]
        if k != end - 1:
            p += r * H[k + 2, j]
            H[k + 2, j] -= p * z
        H[k + 1, j] -= p * y
        H[k, j] -= p * x
    _reflect_columns(H, first, min(end, k + 3) + 1, end, k, x, y, z, q, r)


@inlined
def _reflect_columns(
    H: np.ndarray, first: int, last: int, end: int, k: int, x: float, y: float, z: float, q: float, r: float
) -> None:  # fmt: skip
    for i in range(first, last):
        p = x * H[i, k] + y * H[i, k + 1]
        if k != end - 1:
            p += z * H[i, k + 2]
            H[i, k + 2] -= p * r
        H[i, k + 1] -= p * q
        H[i, k] -= p
