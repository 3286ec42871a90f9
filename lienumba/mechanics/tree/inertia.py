"""What a link has to be pushed with to be accelerated: wrench = A (acceleration, angular acceleration), both of the
link's origin, along its axes. Of a rigid body A is given by ten numbers; of a link with moving links behind it, it is
any symmetric matrix (the articulated inertia of Featherstone 1983).

Symmetric 3 x 3 matrices are given by xx yy zz xy xz yz.
"""

from typing import Any, NamedTuple

from lienumba.groups import so3
from lienumba.numerics.number import Matrix, Number, Vector

Six = tuple[Any, ...]
PLACES = ((0, 3, 4), (3, 1, 5), (4, 5, 2))
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class Rigid(NamedTuple):
    """m; h, the mass centre from the origin times m; J about the origin."""

    m: Any
    h: Any
    J: Any

    def rotated(self, E: Matrix) -> "Rigid":
        """Along the axes of which these are E's columns."""
        return Rigid(self.m, so3.rotate(E, self.h), _congruent(E, self.J))

    def shifted(self, q: Vector) -> "Rigid":
        """About an origin from which this one is at q (the axes are the same)."""
        h = so3.axpy(self.m, q, self.h)
        s = so3.add(h, self.h)
        t = so3.scale(0.5, s)
        xx, yy, zz, xy, xz, yz = self.J
        J = (
            xx + s[1] * q[1] + s[2] * q[2], yy + s[0] * q[0] + s[2] * q[2], zz + s[0] * q[0] + s[1] * q[1],
            xy - t[0] * q[1] - t[1] * q[0], xz - t[0] * q[2] - t[2] * q[0], yz - t[1] * q[2] - t[2] * q[1],
        )  # fmt: skip
        return Rigid(self.m, h, J)

    def plus(self, other: "Rigid") -> "Rigid":
        return Rigid(self.m + other.m, so3.add(self.h, other.h), _sum(self.J, other.J))

    def general(self) -> "General":
        """The inertia as a general matrix."""
        m = self.m
        return General((m, m, m, 0.0, 0.0, 0.0), so3.hat(so3.scale(-1.0, self.h)), tuple(self.J))


class General(NamedTuple):
    """A = [M H; H^T J]."""

    M: Any
    H: Any
    J: Any

    def rotated(self, E: Matrix) -> "General":
        H = so3.multiply(so3.multiply(E, self.H), so3.transpose(E))
        return General(_congruent(E, self.M), H, _congruent(E, self.J))

    def shifted(self, q: Vector) -> "General":
        M = full(self.M)
        rows = (so3.add(self.H[i : i + 3], so3.cross(q, M[i : i + 3])) for i in (0, 3, 6))
        H = tuple(x for row in rows for x in row)
        new, old = so3.multiply(so3.hat(q), H), so3.multiply(so3.hat(q), self.H)
        J = tuple(x + new[3 * i + j] + old[3 * j + i] for x, (i, j) in zip(self.J, PAIRS, strict=True))
        return General(self.M, H, J)

    def plus(self, other: "General") -> "General":
        return General(_sum(self.M, other.M), _sum(self.H, other.H), _sum(self.J, other.J))

    def general(self) -> "General":
        return self

    def without(self, y: Six, inverse: Number) -> "General":
        """A - y inverse y^T."""
        scaled = tuple(inverse * c for c in y)
        M = tuple(x - y[i] * scaled[j] for x, (i, j) in zip(self.M, PAIRS, strict=True))
        H = tuple(x - y[n // 3] * scaled[3 + n % 3] for n, x in enumerate(self.H))
        J = tuple(x - y[3 + i] * scaled[3 + j] for x, (i, j) in zip(self.J, PAIRS, strict=True))
        return General(M, H, J)

    def cleared(self, k: int) -> "General":
        """With a row and a column that are zero by their structure."""
        M, H, J = list(self.M), list(self.H), list(self.J)
        for n in range(3):
            if k < 3:
                M[PLACES[k][n]] = H[3 * k + n] = 0.0
            else:
                J[PLACES[k - 3][n]] = H[3 * n + k - 3] = 0.0
        return General(tuple(M), tuple(H), tuple(J))


Inertia = Rigid | General


def plus(a: Inertia, b: Inertia) -> Inertia:
    """A + B."""
    if isinstance(a, Rigid) and isinstance(b, Rigid):
        return a.plus(b)
    return a.general().plus(b.general())


def column(A: Inertia, k: int) -> Six:
    """A column of the 6 x 6 matrix."""
    M, H, J = A.general()
    if k < 3:
        return (*(M[PLACES[n][k]] for n in range(3)), *H[3 * k : 3 * k + 3])
    return (*(H[3 * n + k - 3] for n in range(3)), *(J[PLACES[n][k - 3]] for n in range(3)))


def times(A: Inertia, a: Six) -> Six:
    """A a."""
    M, H, J = A.general()
    force = so3.add(so3.rotate(full(M), a[0:3]), so3.rotate(H, a[3:6]))
    return force + so3.add(so3.rotate_back(H, a[0:3]), so3.rotate(full(J), a[3:6]))


def full(S: Six) -> Matrix:
    """All nine numbers of a symmetric matrix."""
    return tuple(S[PLACES[i][j]] for i in range(3) for j in range(3))


def _congruent(E: Matrix, S: Six) -> Six:
    """E S E^T."""
    B = so3.multiply(E, full(S))
    return tuple(so3.dot(B[3 * i : 3 * i + 3], E[3 * j : 3 * j + 3]) for i, j in PAIRS)


def _sum(a: Six, b: Six) -> Six:
    return tuple(x + y for x, y in zip(a, b, strict=True))
