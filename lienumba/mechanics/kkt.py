"""[A C^T; C 0] [x; mu] = [f; g] by a sparse L D L^T, executed on whatever the numbers are.

On symbols the elimination unrolls to exactly the operations that its pattern needs. The order of the blocks makes
pivoting unnecessary (`lienumba.mechanics.order`); the smallest pivot tells whether C has lost its rank.
"""

from dataclasses import dataclass
from typing import Any

from lienumba.mechanics.joints import rows_of
from lienumba.mechanics.model import Model
from lienumba.mechanics.order import elimination_order
from lienumba.operations import where

SINGULAR = 1e-12  # a constraint's pivot below this fraction of its diagonal of C A^-1 C^T counts as zero

Entries = dict[tuple[int, int], Any]


@dataclass(frozen=True)
class Structure:
    """The shape of a mechanism's KKT matrix. `order`: the variables (6 k velocities, then m rows) as eliminated."""

    bodies: int
    rows: int
    order: tuple[int, ...]

    @staticmethod
    def of(model: Model) -> "Structure":
        k, rows = len(model.bodies), rows_of(model)
        order: list[int] = []
        ends: list[tuple[tuple[int, ...], int]] = [
            (joint.bodies, r.stop - r.start) for joint, r in zip(model.joints, rows, strict=True)
        ]
        for block in elimination_order(k, ends):
            if block < k:
                order += range(6 * block, 6 * block + 6)
            else:
                order += range(6 * k + rows[block - k].start, 6 * k + rows[block - k].stop)
        return Structure(k, rows[-1].stop if rows else 0, tuple(order))


@dataclass(frozen=True)
class Solution:
    """x (6 k), mu (m), and `sound`: 1, or 0 where a constraint depends on the others."""

    x: list[Any]
    mu: list[Any]
    sound: Any


def solve(structure: Structure, A: Entries, C: Entries, f: list[Any], g: list[Any]) -> Solution:
    """`A`: block diagonal, symmetric and positive definite, entries (i, j) with i >= j; `C`: entries (row, column)."""
    n = 6 * structure.bodies
    size = n + structure.rows
    place = {variable: position for position, variable in enumerate(structure.order)}
    by_bodies: list[Any] = [0.0] * size  # the diagonal, kept in two sums for the constraint rows: what the bodies
    by_joints: list[Any] = [0.0] * size  # contribute, which is the scale, and what other constraints take away
    column: list[dict[int, Any]] = [{} for _ in range(size)]
    for (i, j), value in [*A.items(), *(((n + row, c), x) for (row, c), x in C.items())]:
        low, high = sorted((place[i], place[j]))
        if low == high:
            by_bodies[low] = value
        else:
            column[low][high] = value
    y = [(f[v] if v < n else g[v - n]) for v in structure.order]
    inverse: list[Any] = [None] * size
    sound: Any = 1.0
    for j in range(size):
        is_joint = structure.order[j] >= n
        pivot = by_bodies[j] + by_joints[j]
        if is_joint:
            sound = where(SINGULAR * by_bodies[j] - pivot > 0.0, sound, 0.0)  # NaN is not
        inverse[j] = 1.0 / pivot
        entries = sorted(column[j].items())
        factors = [(i, value * inverse[j]) for i, value in entries]
        diagonal = by_joints if is_joint else by_bodies
        for a, (i, value) in enumerate(entries):
            for i2, factor in factors[a:]:
                if i2 == i:
                    diagonal[i] = diagonal[i] - factor * value
                else:
                    column[i][i2] = column[i].get(i2, 0.0) - factor * value
        for i, factor in factors:
            y[i] = y[i] - factor * y[j]
        column[j] = dict(factors)
    for j in reversed(range(size)):
        y[j] = y[j] * inverse[j]
        for i, factor in column[j].items():
            y[j] = y[j] - factor * y[i]
    solved = [y[place[v]] for v in range(size)]
    return Solution(solved[:n], solved[n:], sound)
