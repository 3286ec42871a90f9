"""In which axes the equations of motion are written: of joints, and of the translations of bodies.

In global axes C changes with every rotation. Another set of equations says the same: the rows of a joint, as a vector,
turned into the axes of one of its bodies, and the velocity and acceleration of a body along its own axes. Then what one
body has in C is constant: its share of C M^-1 C^T follows from parameters alone, and for a body on ground that is all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, View
from lienumba.numerics.number import Number, Vector


@dataclass(frozen=True)
class Axes:
    """rows: by the number of a constraint, in the axes of which body its rows are; moves: by body, along the axes of
    which body it moves. What is not in there is global, as are translations that a rotor couples."""

    rows: dict[int, int] = field(default_factory=dict)
    moves: dict[int, int] = field(default_factory=dict)

    def view(self, constraint: int, now: Instant, ends: tuple[int, ...]) -> View:
        """What the law of a constraint sees, so that its rows come in their axes."""
        base = self.rows.get(constraint)
        if base is None:
            return kinematics.still(now, ends)
        return kinematics.seen_from(kinematics.still(now, (*ends, base)), base)

    def turned(self, constraint: int, now: Instant, rows: Sequence[Number], vector: int) -> list[Any]:
        """What is left of a constraint in global axes, of which so many rows are a vector, in the axes of its rows. A
        law that sees these axes would vanish elsewhere, where R R^T has lost digits."""
        return self._vector_turned(constraint, now, rows, vector, so3.rotate_back)

    def turned_back(self, constraint: int, now: Instant, rows: Sequence[Number], vector: int) -> list[Any]:
        """Multipliers of the rows of a constraint, in global axes."""
        return self._vector_turned(constraint, now, rows, vector, so3.rotate)

    def _vector_turned(
        self, constraint: int, now: Instant, rows: Sequence[Number], vector: int, turn: Callable[[Any, Any], Any]
    ) -> list[Any]:
        base = self.rows.get(constraint)
        if base is None or not vector:
            return list(rows)
        return [*turn(now.motion(base).R, tuple(rows[:vector])), *rows[vector:]]

    def directions(self, constraint: int, now: Instant, body: int) -> Sequence[Vector] | None:
        """Along what a body moves, in the axes of the rows of a constraint; None for these axes themselves."""
        base, along = self.rows.get(constraint), self.moves.get(body)
        if base == along:
            return None
        R = so3.IDENTITY if along is None else now.motion(along).R
        if base is not None:
            R = so3.multiply(so3.transpose(now.motion(base).R), R)
        return R[0::3], R[1::3], R[2::3]

    def into(self, now: Instant, x: Sequence[Number]) -> list[Any]:
        """6 k velocities, accelerations, forces or steps: the translations, global, into these axes."""
        return self._turned(now, x, so3.rotate_back)

    def out_of(self, now: Instant, x: Sequence[Number]) -> list[Any]:
        """And back: translations global."""
        return self._turned(now, x, so3.rotate)

    def _turned(self, now: Instant, x: Sequence[Number], turn: Callable[[Any, Any], Any]) -> list[Any]:
        rows = list(x)
        for i, base in self.moves.items():
            rows[6 * i : 6 * i + 3] = turn(now.motion(base).R, tuple(rows[6 * i : 6 * i + 3]))
        return rows


GLOBAL = Axes()
