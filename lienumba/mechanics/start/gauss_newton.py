"""Closing a mechanism at the start: positions by Gauss-Newton, velocities by one linear solution, for all runs at once.

Elementwise: a run that has converged stays where it is, and no run sees another.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.massless import massless
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.start.least_norm import Entries, Least
from lienumba.mechanics.start.poses import Local, Poses, Rates
from lienumba.mechanics.system import constraints, rotors
from lienumba.mechanics.tolerances import ROUNDOFF
from lienumba.mechanics.tree.links import with_ways
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, cos, maximum, where

ACCEPTED = 1e-8  # largest violation of an assembled state, relative to the size of its joint, or speed of its points
SOLVED = 1e-11  # what solving for velocities may leave, relative to the fastest
NEAREST = 1e-15  # m, rad: less is none, also where a joint is in the middle of its bodies and of the world
SLOWEST = 1e-12  # m/s, rad/s: less is none, also where everything else is at rest
EVEN = 1e-6  # of the heaviest body: lighter ones count as such where their own masses lead to no solution
ITERATIONS = 50
FAR = 10  # iterations that look for the least correction; where it is large they converge slowly, the rest fast
PATIENCE = 8  # iterations without a smaller violation than before
LONGEST_TURN = 1.0  # rad, of any body in one iteration
DAMPING = 0.1  # of a violation of 1
SMALL = 1e-6  # of a violation: less is none to wait for where it is damped
SLOW = 0.5  # an accepted state whose violation shrinks no faster than this has met rounding
TAKEN_BACK = 8  # passes in which lent masses are
# rad: where no way leads from the start, bodies start again turned and moved.
KICKS = (0.0, 0.2, 0.7, 1.5, -0.7, 2.5, -1.5, 3.1)
OFTEN = 2  # times that such a way ends in the least violation known, to ALIKE of it: then there is none less
ALIKE = 1e-3
FLIPPED = 1.0  # the violation of what points the other way, where other starts may lead elsewhere


class Closing(NamedTuple):
    """rows: those of the model's constraints that hold on the position level and are known yet."""

    model: Model
    poses: Poses
    angles: dict[Any, Any]
    rows: tuple[int, ...]
    runs: int
    upright: tuple[tuple[int, int], ...] = ()  # joint, axis: which shall point the same way; their sines do not say it

    def positions(self, other: tuple[Local, ...] | None = None) -> tuple[Local, ...]:
        """Positions first, those without a guess before the others; rotations only where that does not do. other: where
        to start again if no way leads from the first start."""
        poses = self.poses
        local = self._closed(poses.local, poses.loose) if poses.loose else poses.local
        if poses.shifts != poses.loose:
            moved = self._closed(local, poses.shifts)
            local = poses.chosen(self._violation(moved)[1], moved, local)
        free = poses.shifts | poses.turns
        best = self._closed(local, free) if poses.turns else local
        if other is not None:
            worst, accepted = self._violation(best)
            if not np.all(accepted):
                again = self._closed(poses.chosen(accepted, best, other), free)
                best = poses.chosen(~accepted & (self._violation(again)[0] < worst), again, best)
        met = np.zeros(self.runs)
        for kick in KICKS:
            worst, accepted = self._violation(best)
            lost = ~accepted & (met < OFTEN)
            if not np.any(lost):
                break
            again = self._closed(poses.moved(local, self._kick(local, free, kick), lost), free, DAMPING)
            reached, _ = self._violation(again)
            met = np.where(lost & (reached < FLIPPED) & (absolute(reached - worst) < ALIKE * worst), met + 1.0, met)
            best = poses.chosen(lost & (reached < worst), again, best)
        every = np.ones(self.runs, bool)
        return poses.chosen(every, best, best)  # arrays, whether or not a run had to move

    def _instant(self, local: tuple[Local, ...]) -> Instant:
        return Instant(self.poses.bodies(local), 0.0, self.angles)

    def _closed(self, local: tuple[Local, ...], free: frozenset[int], damping: float = 0.0) -> tuple[Local, ...]:
        """Gauss-Newton on the free columns towards the least total correction, or damped, which finds its way more
        often where constraints are redundant, and forgets where it came from."""
        poses, size = self.poses, 6 * len(local)
        inverse = {(c, c): 1.0 if c % 6 < 3 else 0.5 for c in sorted(free)}
        start, x = local, [0.0] * size
        before, best = np.full(self.runs, np.inf), np.full(self.runs, np.inf)
        waited = np.zeros(self.runs)
        going = np.ones(self.runs, bool)
        for n in range(ITERATIONS):
            worst, accepted = self._violation(local)
            waited = np.where(worst < (best if damping == 0.0 else (1.0 - SMALL) * best), 0.0, waited + 1.0)
            best = np.minimum(best, worst)
            going = going & (worst != 0.0) & (waited < PATIENCE) & ~(accepted & (worst > SLOW * before))
            if not np.any(going):
                break
            again = accepted | (n >= FAR or damping > 0.0)  # from here on the correction is a small one
            start, x = poses.chosen(again, local, start), [where(again, 0.0, a) for a in x]
            now = self._instant(local)
            C = self._columns(now, local, free)
            b = self._minus_residual(now)
            for (row, c), value in C.items():
                b[row] = b[row] + value * x[c]
            x = _limited(x, Least(C, inverse, len(b), size, damping * np.minimum(worst, 1.0)).change(b))
            local = poses.chosen(going, poses.moved(start, x, going), local)
            before = worst
        return local

    def _columns(self, now: Instant, local: tuple[Local, ...], free: frozenset[int]) -> Entries:
        """C of the rows, numbered from 0, for the free columns."""
        number = {row: n for n, row in enumerate(self.rows)}
        C = {(number[i], c): x for (i, c), x in constraints.jacobian(self.model, now).items() if i in number}
        return self.poses.columns(C, now.bodies, local, free)

    def _minus_residual(self, now: Instant) -> list[Any]:
        phi = constraints.residual(self.model, now)
        return [-phi[row] for row in self.rows]

    def _violation(self, local: tuple[Local, ...]) -> tuple[np.ndarray, np.ndarray]:
        """The largest violation that is more than rounding (runs,), and whether all are accepted."""
        now = self._instant(local)
        phi = constraints.residual(self.model, now)
        reach, far, _ = constraints.sizes(self.model, now)
        worst: Any = 0.0
        accepted: Any = np.ones(self.runs, bool)
        for row in self.rows:
            size = absolute(phi[row])
            rounding = ROUNDOFF * (reach[row] + far[row])
            left = where(size <= rounding, 0.0, where(size > rounding, size, np.inf))  # NaN is the worst
            worst = maximum(worst, left)
            accepted = accepted & (left <= ACCEPTED * reach[row] + rounding + NEAREST)
        for index, axis in self.upright:
            joint, view = self.model.joints[index], still(now, self.model.joints[index].bodies)
            first, second = (joints.direction(joint, side, view[i], axis) for side, i in enumerate(joint.bodies))
            against = so3.dot(first, second) < 0.0
            worst, accepted = where(against, maximum(worst, FLIPPED), worst), accepted & ~np.asarray(against)
        return np.array(np.broadcast_to(np.asarray(worst, float), (self.runs,))), accepted

    def _kick(self, local: tuple[Local, ...], free: frozenset[int], angle: float) -> list[Any]:
        """Turns by an angle and shifts by as much of the joints' reach, in directions that no mechanism prefers."""
        reach = constraints.largest(constraints.sizes(self.model, self._instant(local))[0])
        x: list[Any] = [0.0] * (6 * len(local))
        for c in free:  # directions spread by the golden angle
            x[c] = (angle * cos(2.399963 * (c + 1))) * (reach if c % 6 < 3 else 1.0)
        return x


def _limited(x: Sequence[Number], new: Sequence[Number]) -> list[Any]:
    """The new x, or as much of the way there as turns no body by more than LONGEST_TURN."""
    turn = constraints.largest([b - a for c, (a, b) in enumerate(zip(x, new, strict=True)) if c % 6 >= 3])
    long = turn > LONGEST_TURN
    part = where(long, LONGEST_TURN / where(long, turn, 1.0), 1.0)
    return [where(long, a + part * (b - a), b) for a, b in zip(x, new, strict=True)]


def allowed_distances(model: Model, now: Instant) -> list[Any]:
    """Of every row, how far it may be from holding (m or rad)."""
    reach, far, _ = constraints.sizes(model, now)
    return [ACCEPTED * own + ROUNDOFF * away + NEAREST for own, away in zip(reach, far, strict=True)]


def allowed_rates(model: Model, now: Instant) -> list[Any]:
    """And how far its rate may be from what it shall be (m/s or rad/s)."""
    rest = SOLVED * constraints.largest([x for body in now.bodies for x in body[12:18]]) + SLOWEST
    return [ACCEPTED * speed + rest for speed in constraints.sizes(model, now)[2]]


def velocities(
    model: Model,
    poses: Poses,
    local: tuple[Local, ...],
    metric: Callable[[float], Entries],
    rows: tuple[int, ...],
    moving: tuple[Any, ...] | None = None,
) -> tuple[Any, ...]:
    """The state with velocities that fulfil these rows: `moving` where it does, else changed as little as can be in
    kinetic energy. metric: the inverse mass matrix, with bodies no lighter than a part of the heaviest. Where masses
    are too different for a solution, it is the least change among such bodies."""
    fits: Any = False
    if moving is not None:
        now = Instant(moving)
        speed, fastest = constraints.sizes(model, now)[2], constraints.largest([x for b in moving for x in b[12:18]])
        fits = _fulfilled(model, now, rows, [ROUNDOFF * (own + fastest) for own in speed])
        if np.all(fits):
            return moving
    solved = _least_energy(model, poses, local, metric(0.0), rows)
    now = Instant(solved)
    solves = fits | _fulfilled(model, now, rows, allowed_rates(model, now))
    if not np.all(solves):
        solved = _either(solves, solved, _least_energy(model, poses, local, metric(EVEN), rows))
    return solved if moving is None else _either(fits, moving, solved)


def _fulfilled(model: Model, now: Instant, rows: tuple[int, ...], limits: Sequence[Any]) -> Any:
    """Whether the rates of these rows are within their limits; NaN is not."""
    rates, _ = constraints.rate_and_bias(model, now)
    fits: Any = True
    for row in rows:
        fits = fits & (absolute(rates[row]) <= limits[row])
    return fits


def _either(runs: Any, a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, ...]:
    """The velocities of a in these runs, of b in the others."""
    return tuple(
        (*x[0:12], *(where(runs, u, w) for u, w in zip(x[12:18], y[12:18], strict=True)))
        for x, y in zip(a, b, strict=True)
    )


def _least_energy(
    model: Model, poses: Poses, local: tuple[Local, ...], inverse_mass: Entries, rows: tuple[int, ...]
) -> tuple[Any, ...]:
    """Velocities of the least kinetic energy of their change: that of bodies, whose inverse mass matrix is given, and
    of rotors.

    There a massless body has a small mass that is lent. It resists less and less a motion that begins again and again
    where the last solution has put these bodies.
    """
    free, size = poses.free_rates, 6 * len(local)
    inverse = {key: x for key, x in inverse_mass.items() if key[0] in free and key[1] in free}
    light = {c for i in massless(model) for c in range(6 * i, 6 * i + 6)} & free
    rates: tuple[Rates, ...] = poses.rates
    bodies = poses.bodies(local, rates)
    number = {row: n for n, row in enumerate(rows)}
    holonomic = all(constraint.level == "position" for constraint in constraints.constraints_of(model))
    turning: Entries = {}
    moved: list[Any] = [0.0] * size  # of the light columns, where a pass begins
    passes = TAKEN_BACK if light else 1
    for n in range(passes + 1 if free else 0):  # the last time takes back the rounding of those before
        now = Instant(bodies)
        growth, _ = constraints.rate_and_bias(model, now)
        if n == 0 and all(np.all(np.asarray(growth[row]) == 0.0) for row in rows):
            break
        if n == 0:
            turned = rotors.roots(with_ways(model, bodies), now)
            roots = {(k, c): x for k, row in enumerate(turned) for c, x in row.items()}
            turning = poses.columns(roots, bodies, local, free)
        if n == 0 or not holonomic:
            C = {(number[i], c): x for (i, c), x in constraints.jacobian(model, now).items() if i in number}
            solving = _least(poses.columns(C, bodies, local, free), inverse, len(rows), size, turning)
        change = solving([-growth[row] for row in rows], moved)
        if n < passes - 1:
            moved = [a + b if c in light else 0.0 for c, (a, b) in enumerate(zip(moved, change, strict=True))]
            rates = _changed(poses.rates, moved, frozenset(light))
        else:
            moved = [0.0] * size
            rates = _changed(rates, change, free)
        bodies = poses.bodies(local, rates)
    return bodies


def _changed(rates: tuple[Rates, ...], change: Sequence[Number], free: frozenset[int]) -> tuple[Rates, ...]:
    return tuple(
        tuple(u + change[6 * i + c] if 6 * i + c in free else u for c, u in enumerate(own))
        for i, own in enumerate(rates)
    )


def _least(
    C: Entries, inverse: Entries, rows: int, size: int, roots: Entries
) -> Callable[[Sequence[Number], Sequence[Number]], list[Any]]:
    """`Least` with the squares of `roots` (moved + x) beside x^T W x, of b and moved: each is one more unknown, and one
    more row."""
    every, wide = dict(C), dict(inverse)
    number = {k: n for n, k in enumerate(dict.fromkeys(k for k, _ in roots))}
    for n in number.values():
        every[rows + n, size + n] = -1.0
        wide[size + n, size + n] = 1.0
    for (k, c), x in roots.items():
        every[rows + number[k], c] = x
    found = Least(every, wide, rows + len(number), size + len(number))

    def change(b: Sequence[Number], moved: Sequence[Number]) -> list[Any]:
        sums: list[Any] = [*b, *[0.0] * len(number)]
        for (k, c), x in roots.items():
            sums[rows + number[k]] = sums[rows + number[k]] - x * moved[c]
        return found.change(sums)[:size]

    return change
