"""The multipliers of a tree's joints, from accelerations that are known: what a body lacks, its joint gives.

From leaf to root: the force and torque that a body needs beside what acts on it is C^T mu of the joint that ties it to
its parent; the parent feels the reverse.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.mechanics.system import constraints, dynamics, kkt, projection
from lienumba.mechanics.tree.locking import locked
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.number import Number


def multipliers(posture: Posture, accelerations: Sequence[Number], closing: Sequence[Number]) -> list[Any]:
    """Of all rows of C (Terze et al. 2015, eq. 13). accelerations: of the bodies (6 k); closing: the multipliers of the
    rows that close loops, 0 in the other rows."""
    model, now = posture.model, posture.now
    rest = projection.without_reactions(model, now, dynamics.loads(model, now), closing)
    for (i, j), x in dynamics.mass_matrix(model, now).items():
        rest[i] = rest[i] - x * accelerations[j]
        if i != j:
            rest[j] = rest[j] - x * accelerations[i]
    C, rows, mu = constraints.jacobian(model, now), constraints.rows_of(model), list(closing)
    entries: dict[int, dict[tuple[int, int], Any]] = {}
    for (row, column), x in C.items():
        entries.setdefault(row, {})[row, column] = x
    for tie in reversed(posture.tree.ties):
        if tie.joint is None:
            continue
        locks = [x.number for x in locked(model, posture.tree) if posture.locks and x.joint == tie.joint]
        own = [row for n in (tie.joint, *locks) for row in range(rows[n].start, rows[n].stop)]
        of_body = {
            (place, column - 6 * tie.body): x
            for place, row in enumerate(own)
            for (_, column), x in entries.get(row, {}).items()
            if column // 6 == tie.body
        }
        mask = [posture.locks.get(row, 1.0) for row in own]
        given = _least(of_body, mask, rest[6 * tie.body : 6 * tie.body + 6])
        for row, value in zip(own, given, strict=True):
            mu[row] = value
            for (_, column), x in entries.get(row, {}).items():
                rest[column] = rest[column] - x * value
    return mu


def _least(C: kkt.Entries, mask: Sequence[Number], f: Sequence[Number]) -> list[Any]:
    """mu with C^T mu = f, where there is one, and C has full rank in the rows in use."""
    rows = len(mask)
    order = tuple(range(6 + rows))
    structure = kkt.Structure(1, rows, order, alike=tuple((row,) for row in range(rows)))
    return kkt.solve(structure, {(i, i): 1.0 for i in range(6)}, C, f, [0.0] * rows, mask).mu
