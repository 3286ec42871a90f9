"""What the constraints of one run amount to at its start: rank, degrees of freedom, rows that say the same.

Dense, in NumPy: nothing here enters a result, only what is reported, refused, or masked. Rows are scaled to length 1
in the metric of the kinetic energy, so that the tolerance means the same whatever the units and masses; a massless body
has the mass of another there.
"""

from typing import NamedTuple

import numpy as np

from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.massless import massless, with_lent_masses
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.system import constraints, dynamics
from lienumba.mechanics.system.projection import placed
from lienumba.mechanics.tolerances import (
    CERTAIN_RANK,
    CONTRADICTION_RTOL,
    DEPENDENCE_RTOL,
    LOOK_AHEAD_STEPS,
    LOOK_AHEAD_TIME,
    LOOK_AHEAD_TURN,
    MET_ATOL,
    MET_RTOL,
    RANK_RTOL,
    START_RANK_RTOL,
)
from lienumba.numerics.number import Vector


class Rank(NamedTuple):
    """redundant: rows that depend on those before them, by joint or driver; shared: the joints and drivers whose
    reactions are not unique; exchangeable: all their rows (indices)."""

    rows: int
    rank: int
    freedom: int
    redundant: dict[str, int]
    shared: tuple[str, ...]
    exchangeable: tuple[int, ...]


def nominal(model: Model, run: int = 0) -> Model:
    """The model of one run: floats only."""

    def number(x: float | np.ndarray, _: bool) -> float:
        if type(x) is float:
            return x
        return float(x) if np.ndim(x) == 0 else float(np.asarray(x)[run])

    return map_numbers(model, number)


def rank_of(model: Model, now: Instant) -> Rank:
    """For one run (floats), whose state fulfils its constraints."""
    C, _ = _scaled(model, now)
    rank, dependences = _dependences(C)
    redundant: dict[str, int] = {}
    shared: list[str] = []
    exchangeable: list[int] = []
    before = 0
    found = _ranks(C, [rows.stop for rows in constraints.rows_of(model)]) if rank < len(C) else []
    for n, (constraint, rows) in enumerate(
        zip(constraints.constraints_of(model), constraints.rows_of(model), strict=True)
    ):
        if np.any(np.abs(dependences[rows]) > DEPENDENCE_RTOL):
            shared.append(constraint.name)
            exchangeable += range(rows.start, rows.stop)
            so_far = before + found[n]
        else:
            so_far = before + constraint.rows
        if so_far - before < constraint.rows:
            redundant[constraint.name] = constraint.rows - (so_far - before)
        before = so_far
    return Rank(len(C), rank, C.shape[1] - rank, redundant, tuple(shared), tuple(exchangeable))


def ranks(model: Model, now: Instant, runs: int) -> np.ndarray:
    """The rank of C in each run (runs,), in the metric of the first one; numbers are floats or arrays (runs,). Masses
    do not enter C: where nothing else differs, one run tells the rank of all."""
    entries = constraints.jacobian(model, now)
    values = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in entries.values()])
    rows, columns = np.array(list(entries)).T
    metric = np.eye(6 * len(model.bodies))
    _unit_masses(nominal(model), metric)
    some = range(runs) if np.any(values != values[:, :1]) else range(1)
    found = []
    for run in some:
        C = np.zeros((sum(c.rows for c in constraints.constraints_of(model)), len(metric)))
        C[rows, columns] = values[:, run]
        C = C @ metric
        lengths = np.linalg.norm(C, axis=1, keepdims=True)
        sizes = np.linalg.svd(C / np.where(lengths == 0.0, 1.0, lengths), compute_uv=False)
        found.append(int(np.sum(sizes > RANK_RTOL * sizes[0])))
    return np.resize(found, runs)


def independent(model: Model) -> Rank:
    """Of rows none of which can depend on others."""
    rows = sum(constraint.rows for constraint in constraints.constraints_of(model))
    return Rank(rows, rows, 6 * len(model.bodies) - rows, {}, (), ())


def _ranks(C: np.ndarray, ends: list[int]) -> list[int]:
    """By how much each block of rows, up to these ends, raises the rank of those before it."""
    basis = np.zeros((0, C.shape[1]))
    added = []
    for start, end in zip([0, *ends], ends, strict=False):
        rest = C[start:end]
        for _ in range(2):  # the second time takes back the rounding of the first
            rest = rest - (rest @ basis.T) @ basis
        _, sizes, directions = np.linalg.svd(rest, full_matrices=False)
        new = int(np.sum(sizes > RANK_RTOL))
        basis = np.concatenate([basis, directions[:new]])
        added.append(new)
    return added


def contradiction(model: Model, now: Instant) -> tuple[str, ...]:
    """The joints and drivers that cannot hold together: C v' = xi has no solution at the start, or Phi = 0,
    C v = -Phi_t or C v' = xi has none a little later; () if all is well."""
    found = _unmet(model, now, _xi(model, now), _sizes(model, now)[2])
    if found or not model.drivers:
        return found
    later = _moved_on(model, now)
    C = _jacobian(model, later)
    growth = -np.array(constraints.time_rate(model, later), float)
    position, velocity, _ = _sizes(model, later)
    found = _unmet(model, later, -np.array(constraints.residual(model, later), float), position)
    found = found or _unmet(model, later, growth, velocity)
    if found:
        return found
    v = np.array([x for body in now.bodies for x in body[12:18]])
    v = v + np.linalg.lstsq(C, growth - C @ v, rcond=RANK_RTOL)[0]
    bodies = tuple((*body[0:12], *v[6 * i : 6 * i + 6].tolist()) for i, body in enumerate(later.bodies))
    later = Instant(bodies, later.t, later.angles)
    return _unmet(model, later, _xi(model, later), _sizes(model, later)[2])


def on_the_way(model: Model, now: Instant, found: Rank) -> Instant | None:
    """A state a little later where the constraints say more than they do now, where their rank is `found`: now they are
    singular. None if not."""
    if found.rank == found.rows:
        return None
    later = _moved_on(model, now)
    return later if found.rank < _dependences(_scaled(model, later)[0])[0] else None


def _sizes(model: Model, now: Instant) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of every row: what its position, velocity and acceleration compare with."""
    reach, far, speed = (np.array(x, float) for x in constraints.sizes(model, now))
    turning = max([abs(x) for body in now.bodies for x in body[15:18]], default=0.0)
    return reach + far, speed, turning * speed


def _xi(model: Model, now: Instant) -> np.ndarray:
    """The right-hand side of C v' = xi."""
    return -np.array(constraints.rate_and_bias(model, now)[1], float)


def _moved_on(model: Model, now: Instant) -> Instant:
    """A little later: positions moved with their velocities and back onto the constraints, as far as that goes."""
    fastest = max([abs(x) for body in now.bodies for x in body[15:18]], default=0.0)
    t = now.t + min(LOOK_AHEAD_TIME, LOOK_AHEAD_TURN / max(fastest, 1.0))
    x = [(t - now.t) * u for body in now.bodies for u in body[12:18]]
    later = Instant(placed(now.bodies, x), t, now.angles)
    for _ in range(LOOK_AHEAD_STEPS):
        C, phi = _jacobian(model, later), np.array(constraints.residual(model, later), float)
        x = np.linalg.lstsq(C, -phi, rcond=START_RANK_RTOL)[0].tolist()
        later = Instant(placed(later.bodies, x), t, now.angles)
    return later


def _unmet(model: Model, now: Instant, b: np.ndarray, sizes: np.ndarray) -> tuple[str, ...]:
    """The joints and drivers in whose rows C x = b contradicts itself; sizes: what b compares with, row by row."""
    C, lengths = _scaled(model, now)
    missed = MET_RTOL * (sizes / lengths).max(initial=0.0)
    b = b / lengths
    _, dependences = _dependences(C)
    left = dependences.T @ b
    if not np.any(np.abs(left) > max(CONTRADICTION_RTOL * np.abs(b).max(initial=0.0), missed, MET_ATOL)):
        return ()
    worst = np.abs(dependences @ left)
    names = []
    for constraint, rows in zip(constraints.constraints_of(model), constraints.rows_of(model), strict=True):
        if worst[rows].max(initial=0.0) > DEPENDENCE_RTOL * worst.max():
            names.append(constraint.name)
    return tuple(names)


def _jacobian(model: Model, now: Instant) -> np.ndarray:
    """C, dense."""
    C = np.zeros((sum(c.rows for c in constraints.constraints_of(model)), 6 * len(model.bodies)))
    for key, value in constraints.jacobian(model, now).items():
        C[key] = value
    return C


def _scaled(model: Model, now: Instant) -> tuple[np.ndarray, np.ndarray]:
    """C M^(-1/2) with rows of length 1, and the lengths that they had."""
    C = _jacobian(model, now)
    _unit_masses(model, C)
    lengths = np.linalg.norm(C, axis=1)
    lengths[lengths == 0.0] = 1.0
    return C / lengths[:, None], lengths


def _unit_masses(model: Model, C: np.ndarray) -> None:
    """The columns of C by velocities u with v = M^(-1/2) u, M being that of the bodies."""
    for i, body in enumerate(with_lent_masses(model).bodies):
        C[:, 6 * i : 6 * i + 3] /= np.sqrt(body.mass)
        turning = slice(6 * i + 3, 6 * i + 6)
        C[:, turning] = np.linalg.solve(np.linalg.cholesky(_tensor(body.inertia)), C[:, turning].T).T


def moving_no_mass(model: Model, now: Instant) -> tuple[str, ...]:
    """The massless bodies that can move while nothing with a mass does, nor a rotor turns; () if there is none."""
    light = massless(model)
    if not light:
        return ()
    C, n = _scaled(model, now)[0], 6 * len(model.bodies)
    _, sizes, directions = np.linalg.svd(C) if C.size else (None, np.zeros(0), np.eye(n))
    free = directions[int(np.sum(sizes > RANK_RTOL)) :]
    M = np.zeros((n, n))
    for (i, j), x in dynamics.mass_matrix(model, now).items():
        M[i, j] = M[j, i] = x
    _unit_masses(model, M)
    M = np.ascontiguousarray(M.T)
    _unit_masses(model, M)
    energies, ways = np.linalg.eigh(free @ M @ free.T)
    moved = np.abs(ways[:, energies < RANK_RTOL].T @ free).max(axis=0, initial=0.0)
    return tuple(model.bodies[i].name for i in light if moved[6 * i : 6 * i + 6].max() > DEPENDENCE_RTOL)


def _tensor(inertia: Vector) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _dependences(C: np.ndarray) -> tuple[int, np.ndarray]:
    """The rank, and an orthonormal basis of the u with u^T C = 0 (rows, rows - rank)."""
    if not C.size:
        return 0, np.eye(len(C))
    if len(C) <= C.shape[1]:
        squares = np.linalg.eigvalsh(C @ C.T)  # of the singular values; this is much cheaper
        if squares[0] > CERTAIN_RANK * squares[-1]:
            return len(C), np.zeros((len(C), 0))
    U, sizes, _ = np.linalg.svd(C)
    rank = int(np.sum(sizes > RANK_RTOL * sizes[0]))
    return rank, U[:, rank:]
