"""The initial state: what is given is held, what is omitted is solved for from the joints.

Works on all runs at once, elementwise (numbers are floats or arrays of shape (runs,)), so that a run's initial state
depends on nothing but its own inputs, on any CPU. Positions move before rotations do: an omitted rotation is the
identity unless the joints force it away. Omitted velocities are those of least kinetic energy.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.groups import so3
from lienumba.mechanics import constraints
from lienumba.mechanics.joints import rows_of, separation
from lienumba.mechanics.model import Model, Pose, map_numbers
from lienumba.mechanics.projection import ROUNDING, placed, position_violation
from lienumba.operations import cos, sqrt, where

DEPENDENT = 1e-12  # a pivot below this fraction of its diagonal belongs to a row that adds nothing
ACCEPTED = 1e-8  # largest violation of an assembled state, relative to the size of its joint, or speed of its points
ITERATIONS = 50
FAR = 10  # iterations that look for the least correction; where it is large they converge slowly, the rest fast
KICKS = (0.0, 0.2, 0.7, 1.5)  # rad: where no way leads from the start, the omitted bodies start again turned and moved


@dataclass(frozen=True)
class Assembly:
    """model: with every distance joint's length; state (runs, k, 18); per row of Phi (runs, m): the violations left
    (m and m/s), and the limits up to which they are accepted.
    """

    model: Model
    state: np.ndarray
    position_violations: np.ndarray
    velocity_violations: np.ndarray
    position_limits: np.ndarray
    velocity_limits: np.ndarray

    @property
    def good(self) -> np.ndarray:
        """Whether each run fulfils its joints (runs,)."""
        position = np.all(self.position_violations <= self.position_limits, axis=1)
        velocity = np.all(self.velocity_violations <= self.velocity_limits, axis=1)
        return position & velocity & np.all(np.isfinite(self.state), axis=(1, 2))


def _stack(rows: list[Any], runs: int) -> np.ndarray:
    """(runs, len(rows)) of numbers."""
    if not rows:
        return np.zeros((runs, 0))
    return np.stack([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rows], axis=1)


def _least(C: dict[tuple[int, int], Any], inverse: dict[tuple[int, int], Any], b: list[Any], size: int) -> list[Any]:
    """The x of least x^T W x with C x = b, or the closest that dependent rows allow; `inverse`: entries of W^-1."""
    by_column: dict[int, dict[int, Any]] = {}
    for (row, c), value in C.items():
        by_column.setdefault(c, {})[row] = value
    left: dict[int, dict[int, Any]] = {}  # column -> row -> (C W^-1)
    for (i, j), w in inverse.items():
        for row, value in by_column.get(i, {}).items():
            target = left.setdefault(j, {})
            target[row] = target.get(row, 0.0) + value * w
    m = len(b)
    S: list[dict[int, Any]] = [{} for _ in range(m)]  # lower triangle by column
    for c, lefts in left.items():
        for i, x in lefts.items():
            for j, y in by_column.get(c, {}).items():
                if i >= j:
                    S[j][i] = S[j].get(i, 0.0) + x * y
    scale = [S[j].get(j, 0.0) for j in range(m)]
    y = list(b)
    kept: list[Any] = []
    for j in range(m):
        pivot = S[j].get(j, 0.0)
        independent = np.asarray(pivot > DEPENDENT * scale[j]) & np.asarray(pivot > 0.0)
        kept.append(where(independent, 1.0 / where(independent, pivot, 1.0), 0.0))
        below = [(i, x) for i, x in S[j].items() if i > j]
        for n, (i, x) in enumerate(below):
            factor = x * kept[j]
            y[i] = y[i] - factor * y[j]
            for i2, x2 in below[n:]:
                high, low = max(i, i2), min(i, i2)
                S[low][high] = S[low].get(high, 0.0) - factor * x2
    for j in reversed(range(m)):
        total = y[j]
        for i, x in S[j].items():
            if i > j:
                total = total - x * y[i]
        y[j] = total * kept[j]
    solution: list[Any] = [0.0] * size
    for c, lefts in left.items():
        for row, x in lefts.items():
            solution[c] = solution[c] + x * y[row]
    return solution


def _inverse_inertia(model: Model, body: int) -> dict[tuple[int, int], Any]:
    xx, yy, zz, xy, xz, yz = model.bodies[body].inertia
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d = xx * a + xy * b + xz * c
    e, f, g = (xx * zz - xz * xz) / d, (xy * xz - xx * yz) / d, (xx * yy - xy * xy) / d
    J = ((a / d, b / d, c / d), (b / d, e, f), (c / d, f, g))
    return {(6 * body + 3 + i, 6 * body + 3 + j): J[i][j] for i in range(3) for j in range(3)}


def _solve_positions(model: Model, start: Any, free: set[int], runs: int) -> Any:
    """Gauss-Newton on the free columns towards the least total correction; converged runs stay where they are."""
    x: list[Any] = [0.0] * (6 * len(model.bodies))
    state = start
    inverse = {(c, c): 1.0 if c % 6 < 3 else 0.5 for c in sorted(free)}
    for n in range(ITERATIONS):
        lost = _open(model, state, runs)
        if not np.any(lost):
            break
        if n >= FAR:
            start, x = state, [0.0] * len(x)
        C = {key: value for key, value in constraints.jacobian(model, state).items() if key[1] in free}
        b = [-phi for phi in constraints.residual(model, state)]
        for (row, c), value in C.items():
            b[row] = b[row] + value * x[c]
        new = _least(C, inverse, b, len(x))
        x = [where(lost, p, q) for p, q in zip(new, x, strict=True)]
        state = _where(lost, placed(start, x), state)
    return state


def _open(model: Model, state: Any, runs: int) -> np.ndarray:
    """Which runs do not fulfil their joints to rounding (runs,)."""
    return ~(np.broadcast_to(np.asarray(position_violation(model, state)), (runs,)) == 0.0)


def _kicked(model: Model, state: Any, free: set[int], angle: float, runs: int) -> Any:
    """The state with the free bodies of the runs that are not assembled turned, and moved by as much of their reach."""
    lost = _open(model, state, runs)
    if angle == 0.0 or not np.any(lost):
        return state
    reach = constraints.largest(constraints.sizes(model, state)[0])
    x: list[Any] = [0.0] * (6 * len(state))
    for c in free:  # directions spread by the golden angle: any fixed ones that no mechanism prefers
        x[c] = (angle * cos(2.399963 * (c + 1))) * (reach if c % 6 < 3 else 1.0)
    return _where(lost, placed(state, x), state)


def _where(lost: np.ndarray, new: Any, old: Any) -> Any:
    """The new state in these runs, the old one in all others, bit for bit."""
    return tuple(tuple(where(lost, p, q) for p, q in zip(a, b, strict=True)) for a, b in zip(new, old, strict=True))


def assemble(model: Model, poses: tuple[Pose, ...], runs: int) -> Assembly:
    """The initial state of every run. Nothing is raised here: violations that are left tell what did not fit."""
    model = map_numbers(model, lambda x, _: np.float64(x) if isinstance(x, float) else x)  # division by 0 gives inf
    zero = (0.0, 0.0, 0.0)
    start = tuple((p.position or zero) + (p.rotation or so3.IDENTITY) + zero + zero for p in poses)
    shifts = {6 * i + c for i, p in enumerate(poses) if p.position is None for c in range(3)}
    turns = {6 * i + c for i, p in enumerate(poses) if p.rotation is None for c in range(3, 6)}
    given = replace(model, joints=tuple(j for j in model.joints if j.type != "distance" or j.length is not None))
    with np.errstate(all="ignore"):
        state = _solve_positions(given, start, shifts, runs) if shifts else start
        for kick in KICKS if shifts or turns else ():
            state = _solve_positions(given, _kicked(given, state, shifts | turns, kick, runs), shifts | turns, runs)
        model = _with_lengths(model, state)
        C = constraints.jacobian(model, state)
        velocities: list[Any] = []
        free: set[int] = set()
        for i, p in enumerate(poses):
            velocities += (p.velocity or zero) + (p.angular_velocity or zero)
            free |= {6 * i + c for c in range(3)} if p.velocity is None else set()
            free |= {6 * i + c for c in range(3, 6)} if p.angular_velocity is None else set()
        held = tuple(body[0:12] + tuple(velocities[6 * i : 6 * i + 6]) for i, body in enumerate(state))
        rates, _ = constraints.rate_and_bias(model, held)
        inverse: dict[tuple[int, int], Any] = {}
        for i, body in enumerate(model.bodies):
            every = {(6 * i + c, 6 * i + c): 1.0 / body.mass for c in range(3)} | _inverse_inertia(model, i)
            inverse |= {key: value for key, value in every.items() if key[0] in free}
        change = _least(
            {key: v for key, v in C.items() if key[1] in free}, inverse, [-rate for rate in rates], len(velocities)
        )
        velocities = [v + x for v, x in zip(velocities, change, strict=True)]
        final = tuple(body[0:12] + tuple(velocities[6 * i : 6 * i + 6]) for i, body in enumerate(state))
        rates, _ = constraints.rate_and_bias(model, final)
        reach, far, speed = constraints.sizes(model, final)
        phi = _stack(constraints.residual(model, final), runs)
        flat = _stack([x for body in final for x in body], runs)
    return Assembly(
        model,
        flat.reshape(runs, len(poses), 18),
        np.abs(phi),
        np.abs(_stack(rates, runs)),
        ACCEPTED * _stack(reach, runs) + ROUNDING * _stack(far, runs),
        ACCEPTED * _stack(speed, runs) + ROUNDING * _stack([constraints.largest(velocities)], runs),
    )


def _with_lengths(model: Model, state: Any) -> Model:
    """A distance joint without a length keeps the distance that its points have at the start."""
    joints = []
    for joint in model.joints:
        if joint.type == "distance" and joint.length is None:
            a, b = (constraints.placement(state, i) for i in joint.bodies)
            d = separation(joint, a, b)
            joint = replace(joint, length=sqrt(so3.dot(d, d)))
        joints.append(joint)
    return replace(model, joints=tuple(joints))


def dependent_joint(model: Model, state: np.ndarray) -> tuple[str, int, int] | None:
    """The first joint whose rows of C depend on those of the joints before it, with rank and rows.

    `state` (k, 18) is that of the first run, which decides for all.
    """
    rows = rows_of(model)
    C = np.zeros((rows[-1].stop if rows else 0, 6 * len(model.bodies)))
    for key, value in constraints.jacobian(model, tuple(tuple(float(x) for x in body) for body in state)).items():
        C[key] = np.asarray(value, float).reshape(-1)[0]
    if not len(C) or np.linalg.matrix_rank(C, tol=1e-9 * np.abs(C).max()) == len(C):
        return None
    for joint, own in zip(model.joints, rows, strict=True):
        rank = int(np.linalg.matrix_rank(C[: own.stop], tol=1e-9 * np.abs(C).max()))
        if rank < own.stop:
            return joint.name, rank, own.stop
    return None
