"""Rows of contacts that stick or slide, which are solved together once all else is eliminated.

Where a contact slides, its friction follows from its normal force: of its multipliers lambda = T lambda*, with
-mu d in the columns of normals, d being the direction of sliding. So what is left, S lambda = b with S symmetric,
becomes m (S T) m lambda* = m b, m being 1 for rows in use: of what slides the normal alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lienumba.numerics.number import Number
from lienumba.numerics.operations import divide, where

SINGULAR = 1e-12  # a pivot below this fraction of the diagonal counts as zero
DEPENDENT, PARADOX = 0.0, -1.0  # in the place of 1: rows depend on each other; friction leaves no solution, or many

Leaning = Mapping[tuple[int, int], Any]  # T without its diagonal, by rows of C: (tangent, normal)


@dataclass(frozen=True)
class Border:
    """S: as it is; rows: L U of m (S T) m, L below the diagonal, where it has 1; inverse: that of the diagonal of U; T:
    by places."""

    S: list[list[Any]]
    rows: list[list[Any]]
    inverse: list[Any]
    mask: list[Any]
    T: Mapping[tuple[int, int], Any]
    sound: Any

    @staticmethod
    def of(S: Sequence[Sequence[Number]], names: Sequence[int], mask: Sequence[Number], leaning: Leaning) -> "Border":
        """S: symmetric; names: which rows of C its rows are."""
        place = {row: n for n, row in enumerate(names)}
        T = {(place[t], place[n]): x for (t, n), x in leaning.items()}
        size = range(len(names))
        B: list[list[Any]] = [list(row) for row in S]
        for (t, n), x in T.items():
            for i in size:
                B[i][n] = B[i][n] + S[i][t] * x
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
        return Border([list(row) for row in S], B, inverse, list(mask), T, sound)

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
        found = list(x)
        for (t, n), c in self.T.items():
            found[t] = found[t] + c * x[n]
        return found
