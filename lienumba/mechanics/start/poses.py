"""The bodies of a start in the terms in which it is given: each relative to its base, or to the ground.

Position p (base frame), rotation R_rel, velocities u = (v_rel in the base frame, w_rel in the own body frame):
    r = r_b + R_b p,  R = R_b R_rel,  v = v_b + R_b (w_b x p) + R_b v_rel,  w = R_rel^T w_b + w_rel.
What is free to be solved for is free in these terms, so that a body which moves carries along all that hangs on it.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lienumba.groups import so3
from lienumba.groups.state import State
from lienumba.mechanics.mechanism.model import GROUND, Pose, Start
from lienumba.mechanics.start.least_norm import Entries
from lienumba.numerics.number import Number
from lienumba.numerics.operations import where

ZERO = (0.0, 0.0, 0.0)

Local = tuple[Any, ...]  # p, R_rel: 12 numbers per body
Rates = tuple[Any, ...]  # v_rel, w_rel: 6 numbers per body


class Poses(NamedTuple):
    """bases: of each body (GROUND where it has none); order: bases before the bodies that refer to them.

    Free columns (6 per body) by what they are: shifts and turns of the position, and rates; loose: the shifts that
    start nowhere in particular, because no guess says where.
    """

    bases: tuple[int, ...]
    order: tuple[int, ...]
    local: tuple[Local, ...]
    rates: tuple[Rates, ...]
    loose: frozenset[int]
    shifts: frozenset[int]
    turns: frozenset[int]
    free_rates: frozenset[int]
    roots: tuple[int, ...]  # the body (or GROUND) relative to which each body's rotation is known
    placed: tuple[bool, ...]  # whether position and rotation are known

    @staticmethod
    def of(start: Start, steady: set[int]) -> "Poses":
        """steady: bodies that keep the rotation that they start with, given or not."""
        poses = start.poses
        bases = tuple(GROUND if p.relative_to is None else p.relative_to for p in poses)
        order = _bases_first(bases)
        turning = {i for i, p in enumerate(poses) if p.rotation is None and i not in steady}
        roots, placed = [GROUND] * len(poses), [False] * len(poses)
        for i in order:
            base = bases[i]
            roots[i] = i if i in turning else GROUND if base == GROUND else roots[base]
            on = base == GROUND or placed[base]
            placed[i] = on and poses[i].position is not None and i not in turning
        return Poses(
            bases,
            order,
            tuple((*_first(p, "position", ZERO), *_first(p, "rotation", so3.IDENTITY)) for p in poses),
            tuple((*_first(p, "velocity", ZERO), *_first(p, "angular_velocity", ZERO)) for p in poses),
            _columns({i for i, p in enumerate(poses) if p.position is None and not _guessed(p)}, 0),
            _columns({i for i, p in enumerate(poses) if p.position is None}, 0),
            _columns(turning, 3),
            _columns({i for i, p in enumerate(poses) if p.velocity is None}, 0)
            | _columns({i for i, p in enumerate(poses) if p.angular_velocity is None}, 3),
            tuple(roots),
            tuple(placed),
        )

    def at(self, local: tuple[Local, ...], known: set[int]) -> "Poses":
        """The same, starting there; known: the bodies for which that is somewhere in particular."""
        return self._replace(local=local, loose=self.loose - _columns(known, 0))

    def bodies(self, local: tuple[Local, ...], rates: tuple[Rates, ...] | None = None) -> tuple[Any, ...]:
        """Of every body the 18 numbers of the state; at rest without `rates`. A given number stays as it is."""
        done: list[Any] = [None] * len(local)
        for i in self.order:
            p, R = local[i][0:3], local[i][3:12]
            v, w = (rates[i][0:3], rates[i][3:6]) if rates is not None else (ZERO, ZERO)
            if self.bases[i] == GROUND:
                done[i] = (*p, *R, *v, *w)
                continue
            base = done[self.bases[i]]
            Q, turning = base[3:12], base[15:18]
            r = so3.add(base[0:3], so3.rotate(Q, p))
            if rates is not None:
                v = so3.add(base[12:15], so3.rotate(Q, so3.add(so3.cross(turning, p), v)))
                w = so3.add(so3.rotate_back(R, turning), w)
            done[i] = (*r, *so3.multiply(Q, R), *v, *w)
        return tuple(done)

    def moved(self, local: tuple[Local, ...], x: Sequence[Number], runs: np.ndarray) -> tuple[Local, ...]:
        """These runs (booleans) moved by x: a shift of p and a rotation of R_rel from the right, where free."""
        done = []
        for i, own in enumerate(local):
            p, R = own[0:3], own[3:12]
            if 6 * i in self.shifts:
                p = _where(runs, so3.add(p, _three(x, 6 * i)), p)
            if 6 * i + 3 in self.turns:
                R = _where(runs, so3.multiply(R, so3.exp(_three(x, 6 * i + 3))), R)
            done.append((*p, *R))
        return tuple(done)

    def chosen(self, runs: np.ndarray, new: tuple[Local, ...], old: tuple[Local, ...]) -> tuple[Local, ...]:
        """The new ones in these runs, the old ones elsewhere, bit for bit."""
        free = self.shifts | self.turns
        return tuple(
            (
                *(_where(runs, n[0:3], o[0:3]) if 6 * i in free else o[0:3]),
                *(_where(runs, n[3:12], o[3:12]) if 6 * i + 3 in free else o[3:12]),
            )
            for i, (n, o) in enumerate(zip(new, old, strict=True))
        )

    def columns(self, C: Entries, bodies: Sequence[State], local: tuple[Local, ...], free: frozenset[int]) -> Entries:
        """The free columns of C (global v, body frame w) in the terms of the start."""
        moves = [False] * len(local)
        for i in self.order:
            own = any(c in free for c in range(6 * i, 6 * i + 6))
            moves[i] = own or (self.bases[i] != GROUND and moves[self.bases[i]])
        rows: list[dict[int, list[Any]]] = [{} for _ in local]
        for (row, c), value in C.items():
            if moves[c // 6]:
                rows[c // 6].setdefault(row, [0.0] * 6)[c % 6] = value
        for i in reversed(self.order):
            base = self.bases[i]
            if base == GROUND:
                continue
            p, R = local[i][0:3], local[i][3:12]
            for row, entry in rows[i].items():
                g, turn = (entry[0], entry[1], entry[2]), (entry[3], entry[4], entry[5])
                h = so3.rotate_back(bodies[base][3:12], g)
                if moves[base]:
                    carried = (*g, *so3.add(so3.cross(p, h), so3.rotate(R, turn)))
                    old = rows[base].get(row, [0.0] * 6)
                    rows[base][row] = [x + y for x, y in zip(old, carried, strict=True)]
                rows[i][row] = [*h, *turn]
        return {
            (row, 6 * i + c): x
            for i, own in enumerate(rows)
            for row, entry in own.items()
            for c, x in enumerate(entry)
            if 6 * i + c in free and not (isinstance(x, float) and x == 0.0)
        }


def _first(pose: Pose, name: str, default: Any) -> Any:
    """What is given, else what is guessed, else the default."""
    given, guess = getattr(pose, name), None if pose.guess is None else getattr(pose.guess, name)
    return given if given is not None else guess if guess is not None else default


def _guessed(pose: Pose) -> bool:
    return pose.guess is not None and pose.guess.position is not None


def _bases_first(bases: tuple[int, ...]) -> tuple[int, ...]:
    order: list[int] = []
    while len(order) < len(bases):
        ready = [i for i, b in enumerate(bases) if i not in order and (b == GROUND or b in order)]
        if not ready:
            raise ValueError("relative_to goes around in a circle")
        order += ready
    return tuple(order)


def _columns(bodies: set[int], first: int) -> frozenset[int]:
    return frozenset(6 * i + first + c for i in bodies for c in range(3))


def _three(x: Sequence[Number], first: int) -> Any:
    return (x[first], x[first + 1], x[first + 2])


def _where(runs: np.ndarray, new: Any, old: Any) -> Any:
    return tuple(where(runs, a, b) for a, b in zip(new, old, strict=True))
