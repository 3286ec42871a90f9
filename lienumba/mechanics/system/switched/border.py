"""Rows of contacts that stick or slide, which are solved together once all else is eliminated.

Where a contact slides, its friction follows from its normal force: of its multipliers lambda = T lambda*, with
-mu d in the columns of normals, d being the direction of sliding. So what is left, S lambda = b with S symmetric,
becomes m (S T) m lambda* = m b, m being 1 for rows in use: of what slides the normal alone.

Several contacts may say the same. Then m selects independent rows R, and the rates of all that carry are 1 + G times
those of R, G S m = S in them. As if each gave way a little, they carry lambda = P (1 + G) y: of normals P is 1, of
tangents a part V of what they gave way and a part c of their normal force. In R that is K y, K = (1 + G)^T P (1 + G),
and with what slides S (K + F T (1 + G)) y = b, where F are the rows of S^-1 S of the tangents that slide. With V = 1
and c = 0 forces are those of least norm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from lienumba.numerics.number import Number
from lienumba.numerics.operations import divide, where

SINGULAR = 1e-12  # a pivot below this fraction of the diagonal counts as zero
DEPENDENT, PARADOX = 0.0, -1.0  # in the place of 1: rows depend on each other; friction leaves no solution, or many

Entries = Mapping[tuple[int, int], Any]
Matrix = list[list[Any]]


@dataclass(frozen=True)
class FrictionCoupling:
    """T without its diagonal, by rows of C: (tangent, normal), where a contact sticks c; compliance: V, (tangent,
    tangent); carries: 1 for every row that has a force of its own, 0 for others."""

    T: Entries = field(default_factory=dict)
    compliance: Entries = field(default_factory=dict)
    carries: Sequence[Any] = ()


class Factors(NamedTuple):
    """L U of a matrix, its rows and columns in some order; L below the diagonal, where it has 1; inverse: that of the
    diagonal of U."""

    order: Sequence[int]
    rows: Matrix
    inverse: list[Any]

    @staticmethod
    def of(A: Matrix, order: Sequence[int]) -> "Factors":
        """A is used up."""
        inverse: list[Any] = [0.0] * len(A)
        for n, k in enumerate(order):
            inverse[k] = divide(1.0, A[k][k])
            for i in order[n + 1 :]:
                A[i][k] = A[i][k] * inverse[k]
                for j in order[n + 1 :]:
                    A[i][j] = A[i][j] - A[i][k] * A[k][j]
        return Factors(order, A, inverse)

    def solve(self, b: Sequence[Number]) -> list[Any]:
        """x with A x = b."""
        x: list[Any] = list(b)
        for n, i in enumerate(self.order):
            for j in self.order[:n]:
                x[i] = x[i] - self.rows[i][j] * x[j]
        for n, i in reversed([*enumerate(self.order)]):
            for j in self.order[n + 1 :]:
                x[i] = x[i] - self.rows[i][j] * x[j]
            x[i] = x[i] * self.inverse[i]
        return x


class Border(NamedTuple):
    """S: as it is; factors: L U of m (S T) m, or, where contacts may say the same, of K with what slides; forces: of
    all rows, from what these solve for; inverse: then that of S in the rows in use, with a minus."""

    S: Matrix
    factors: Factors
    mask: list[Any]
    forces: Matrix
    inverse: Matrix | None
    nonsingular: Any

    @staticmethod
    def of(
        S: Sequence[Sequence[Number]], names: Sequence[int], mask: Sequence[Number], coupling: FrictionCoupling
    ) -> "Border":
        """S: symmetric; names: which rows of C its rows are."""
        place = {row: n for n, row in enumerate(names)}
        T = {(place[t], place[n]): x for (t, n), x in coupling.T.items()}
        if T and len(names) - len({t for t, _ in T}) > 1:
            V = {(place[a], place[b]): x for (a, b), x in coupling.compliance.items()}
            return _sharing(S, mask, T, V, [coupling.carries[row] for row in names])
        size = range(len(names))
        B: Matrix = [list(row) for row in S]
        forces: Matrix = [[1.0 if i == j else 0.0 for j in size] for i in size]
        for (t, n), x in T.items():
            forces[t][n] = x
            for i in size:
                B[i][n] = B[i][n] + S[i][t] * x
        for (a, b), x in _beside(S, mask, [coupling.carries[row] for row in names] if T else [], T).items():
            forces[a][b] = x
            for i in size:
                B[i][b] = B[i][b] + S[i][a] * x
        for i in size:
            for j in size:
                B[i][j] = mask[i] * B[i][j] * mask[j] + (1.0 - mask[i] if i == j else 0.0)
        factors, nonsingular = Factors.of(B, size), 1.0
        for k in size:
            least = SINGULAR * (mask[k] * S[k][k] + (1.0 - mask[k]))
            nonsingular = _sounder(nonsingular, B[k][k], least, any(n == k for _, n in T))
        return Border([list(row) for row in S], factors, list(mask), forces, None, nonsingular)

    def solve(self, y: Sequence[Number]) -> list[Any]:
        """lambda with -S lambda = y in the rows in use."""
        pushed = [m * c for m, c in zip(self.mask, y, strict=True)]
        if self.inverse is None:
            return self.reactions(self.factors.solve([-c for c in pushed]))
        return self.reactions(_times(self.inverse, pushed))

    def reactions(self, x: Sequence[Number]) -> list[Any]:
        """All multipliers from those of the rows in use, or from those that these would have if nothing slid and
        nothing else carried."""
        return _times(self.forces, x if self.inverse is None else self.factors.solve(x))


def _beside(
    S: Sequence[Sequence[Number]], mask: Sequence[Number], carries: Sequence[Number], T: Entries
) -> dict[tuple[int, int], Any]:
    """Of a tangent that says the same as the other one of its contact what it carries for a unit of that: the force is
    along their motion then, and no larger than it has to be, however the tangents lie."""
    found = {}
    for (a, n), (b, m) in ((x, y) for x in T for y in T):
        if n == m and a != b:
            idle = carries[a] * (1.0 - mask[a]) * mask[b]
            found[a, b] = idle * divide(S[max(a, b)][min(a, b)], where(mask[b] > 0.0, S[b][b], 1.0))
    return found


def _sounder(nonsingular: Any, pivot: Number, least: Number, leans: bool) -> Any:
    lost = where(pivot < -least, PARADOX, DEPENDENT) if leans else DEPENDENT
    return where(pivot > least, nonsingular, where(nonsingular < lost, nonsingular, lost))  # NaN is not


def _sharing(
    S: Sequence[Sequence[Number]], mask: Sequence[Number], T: Entries, V: Entries, carries: Sequence[Number]
) -> Border:  # fmt: skip
    size, tangents = range(len(S)), {t for t, _ in T}
    swept, nonsingular = _swept(S, mask)
    extra = [c * (1.0 - m) for c, m in zip(carries, mask, strict=True)]
    whole: Matrix = [[mask[i] if i == j else extra[i] * mask[j] * swept[i][j] for j in size] for i in size]
    forces: Matrix = [[0.0] * len(S) if i in tangents else list(whole[i]) for i in size]
    for (a, b), x in [*T.items(), *V.items()]:
        for j in size:
            forces[a][j] = forces[a][j] + x * whole[b][j]
    K: Matrix = [[1.0 - mask[i] if i == j else 0.0 for j in size] for i in size]
    for k in size:  # what carries by itself; what slides, as what it does in the rows in use
        for i in size:
            weight = whole[k][i]
            if k in tangents:
                weight = weight + (1.0 - carries[k]) * mask[i] * (1.0 - mask[k]) * swept[i][k]
            for j in size:
                K[i][j] = K[i][j] + weight * forces[k][j]
    order = [i for i in size if i not in tangents] + [i for i in size if i in tangents]
    factors = Factors.of(K, order)
    for k in size:
        nonsingular = _sounder(nonsingular, K[k][k], 0.0 if k in tangents else SINGULAR, k not in tangents)
    inverse: Matrix = [[mask[i] * mask[j] * swept[i][j] for j in size] for i in size]
    return Border([list(row) for row in S], factors, list(mask), forces, inverse, nonsingular)


def _times(A: Matrix, x: Sequence[Number]) -> list[Any]:
    found: list[Any] = []
    for row in A:
        total: Any = 0.0
        for a, b in zip(row, x, strict=True):
            total = total + a * b
        found.append(total)
    return found


def _swept(S: Sequence[Sequence[Number]], mask: Sequence[Number]) -> tuple[Matrix, Any]:
    """S once its rows in use R have been swept: -S^-1 in these, S_XR S^-1 in others; and whether R is independent."""
    size = range(len(S))
    A: Matrix = [list(row) for row in S]
    nonsingular: Any = 1.0
    for k in size:
        nonsingular = _sounder(nonsingular, mask[k] * A[k][k] + (1.0 - mask[k]), SINGULAR * mask[k] * S[k][k], False)
        inverse = mask[k] * divide(1.0, where(mask[k] > 0.0, A[k][k], 1.0))
        column = [A[min(i, k)][max(i, k)] for i in size]  # A is kept in its upper triangle
        for i in size:
            if i == k:
                continue
            for j in range(i, len(S)):
                if j != k:
                    A[i][j] = A[i][j] - column[i] * inverse * column[j]
        for i in size:
            swept = where(mask[k] > 0.0, column[i] * inverse, column[i])
            if i < k:
                A[i][k] = swept
            elif i > k:
                A[k][i] = swept
        A[k][k] = where(mask[k] > 0.0, -inverse, A[k][k])
    return [[A[min(i, j)][max(i, j)] for j in size] for i in size], nonsingular
