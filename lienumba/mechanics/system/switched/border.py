"""Rows of contacts that stick, slide or lean, which are solved together once all else is eliminated.

Where a contact slides, its friction follows from its normal force: of its multipliers lambda = T lambda*, with
-mu d in the columns of normals, d being the direction of sliding. So what is left, S lambda = b with S symmetric,
becomes m (S T) m lambda* = m b, m being 1 for rows in use: of what slides the normal alone.

Several contacts may say the same. Then m selects independent rows, and those that carry, too, have lambda* = G lambda*
of these, G S m = S in them. So lambda* is in the range of S: what contacts of the same small compliance would carry,
without friction the shares of least norm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from lienumba.numerics.number import Number
from lienumba.numerics.operations import divide, where

SINGULAR = 1e-12  # a pivot below this fraction of the diagonal counts as zero
DEPENDENT, PARADOX = 0.0, -1.0  # in the place of 1: rows depend on each other; friction leaves no solution, or many


@dataclass(frozen=True)
class Leaning:
    """T without its diagonal, by rows of C: (tangent, normal); carries: 1 for every row that has a force of its own, 0
    for others."""

    T: Mapping[tuple[int, int], Any] = field(default_factory=dict)
    carries: Sequence[Any] = ()


@dataclass(frozen=True)
class Border:
    """S: as it is; rows: L U of m (S T) m, L below the diagonal, where it has 1; inverse: that of the diagonal of U; T:
    by places; shares: the rows of G, None where none says the same as others."""

    S: list[list[Any]]
    rows: list[list[Any]]
    inverse: list[Any]
    mask: list[Any]
    T: Mapping[tuple[int, int], Any]
    shares: list[list[Any]] | None
    sound: Any

    @staticmethod
    def of(S: Sequence[Sequence[Number]], names: Sequence[int], mask: Sequence[Number], leaning: Leaning) -> "Border":
        """S: symmetric; names: which rows of C its rows are."""
        place = {row: n for n, row in enumerate(names)}
        T = {(place[t], place[n]): x for (t, n), x in leaning.T.items()}
        size = range(len(names))
        shares = None
        if T and len(names) - len({t for t, _ in T}) > 1:
            shares = _shares(S, mask, [leaning.carries[row] * (1.0 - m) for row, m in zip(names, mask, strict=True)])
        B = _leant(S, T, shares)
        for i in size:
            for j in size:
                B[i][j] = mask[i] * B[i][j] * mask[j] + (1.0 - mask[i] if i == j else 0.0)
        sound: Any = 1.0
        inverse: list[Any] = []
        for k in size:
            least = SINGULAR * (mask[k] * S[k][k] + (1.0 - mask[k]))
            leans = any(n == k for _, n in T)
            lost = where(B[k][k] < -least, PARADOX, DEPENDENT) if leans else DEPENDENT
            sound = where(B[k][k] > least, sound, where(sound < lost, sound, lost))  # NaN is not
            inverse.append(divide(1.0, B[k][k]))
            for i in size[k + 1 :]:
                B[i][k] = B[i][k] * inverse[k]
                for j in size[k + 1 :]:
                    B[i][j] = B[i][j] - B[i][k] * B[k][j]
        return Border([list(row) for row in S], B, inverse, list(mask), T, shares, sound)

    def solve(self, y: Sequence[Number]) -> list[Any]:
        """lambda with -S lambda = y in the rows in use."""
        size = range(len(self.rows))
        x: list[Any] = [-(m * c) for m, c in zip(self.mask, y, strict=True)]
        for i in size:
            for j in range(i):
                x[i] = x[i] - self.rows[i][j] * x[j]
        for i in reversed(size):
            for j in size[i + 1 :]:
                x[i] = x[i] - self.rows[i][j] * x[j]
            x[i] = x[i] * self.inverse[i]
        return self.reactions(x)

    def reactions(self, x: Sequence[Number]) -> list[Any]:
        """T (1 + G) x: all multipliers from those of the rows in use."""
        found = list(x)
        for i, row in enumerate(self.shares or ()):
            for j, share in enumerate(row):
                found[i] = found[i] + share * x[j]
        x = list(found)
        for (t, n), c in self.T.items():
            found[t] = found[t] + c * x[n]
        return found


def _leant(S: Sequence[Sequence[Number]], T: Mapping[tuple[int, int], Any], shares: list[list[Any]] | None) -> Any:
    """S T (I + G)."""
    B: list[list[Any]] = [list(row) for row in S]
    size = range(len(B))
    for (t, n), x in T.items():
        for i in size:
            B[i][n] = B[i][n] + S[i][t] * x
    if shares is None:
        return B
    leant = [list(row) for row in B]
    for i in size:
        for j in size:
            for k in size:
                B[i][j] = B[i][j] + leant[i][k] * shares[k][j]
    return B


def _shares(S: Sequence[Sequence[Number]], mask: Sequence[Number], extra: Sequence[Number]) -> list[list[Any]]:
    """G: of the `extra` rows that carry beside those of the mask, by sweeps over the pivots of these."""
    size = range(len(S))
    A: list[list[Any]] = [list(row) for row in S]
    for k in size:
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
    return [[extra[i] * mask[j] * (A[min(i, j)][max(i, j)] if i != j else 0.0) for j in size] for i in size]
