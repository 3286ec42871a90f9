"""The equations of motion (13) with Q of (23), (24), (42) and (43), solved as one dense linear system."""

import numpy as np

from lienumba.reference.compiling import compiled
from lienumba.reference.mechanism import (
    DAMPING,
    EFFORT,
    GLOBAL,
    GRADIENT,
    HIGH,
    LOAD,
    LOW,
    MASS,
    PUSH,
    RATE,
    STATE,
    STIFFNESS,
    TARGET,
    VALUE,
    VELOCITY,
    Bodies,
    Constraints,
    Laws,
    Room,
    System,
)
from lienumba.reference.rotations import ZERO, Vec3, cross, dot, matrix, rotate, rotate_back, vector

SMALLEST_PIVOT = 1e-12  # relative to the diagonal of C M^-1 C^T: of a row that depends on the others but for roundoff


@compiled
def momentum(inertia: np.ndarray, w: Vec3, run: int) -> Vec3:
    """J w; inertia (3, 3, N)."""
    return (
        inertia[0, 0, run] * w[0] + inertia[0, 1, run] * w[1] + inertia[0, 2, run] * w[2],
        inertia[1, 0, run] * w[0] + inertia[1, 1, run] * w[1] + inertia[1, 2, run] * w[2],
        inertia[2, 0, run] * w[0] + inertia[2, 1, run] * w[1] + inertia[2, 2, run] * w[2],
    )


@compiled
def weigh(bodies: Bodies, numbers: np.ndarray, x: np.ndarray, Q: np.ndarray, power: np.ndarray) -> None:
    """Q (6 k, N) of weights and gyroscopic torques, and the power of a gravity that varies."""
    for run in range(x.shape[1]):
        power[run] = 0.0
    for i in range(bodies.masses.shape[0]):
        for run in range(x.shape[1]):
            m, w = bodies.masses[i, run], vector(x, STATE * i + 15, run)
            torque = cross(momentum(bodies.inertia[i], w, run), w)
            for c in range(3):
                Q[VELOCITY * i + c, run], Q[VELOCITY * i + 3 + c, run] = m * numbers[c, 0, run], torque[c]
                power[run] -= m * numbers[c, 1, run] * x[STATE * i + c, run]


@compiled
def effort(numbers: np.ndarray, first: int, potential: bool, c: float, rate: float, run: int) -> tuple[float, float]:
    """F = load + k (target - c) + d (target' - c') within its limits, and its power; of a spring-damper d damps c'
    and k (target - c)^2 / 2 is potential energy, of which the power has what changes it at rest."""
    k, d = numbers[first + STIFFNESS, 0, run], numbers[first + DAMPING, 0, run]
    stretch, target1 = numbers[first + TARGET, 0, run] - c, numbers[first + TARGET, 1, run]
    if potential:
        change = 0.5 * numbers[first + STIFFNESS, 1, run] * stretch + k * target1
        return k * stretch - d * rate, stretch * change - d * rate * rate
    F = numbers[first + LOAD, 0, run] + k * stretch + d * (target1 - rate)
    F = max(numbers[first + LOW, 0, run], min(numbers[first + HIGH, 0, run], F))
    return F, F * rate


@compiled
def load(
    laws: Laws, table: np.ndarray, numbers: np.ndarray, x: np.ndarray, seen: np.ndarray, Q: np.ndarray,
    power: np.ndarray,
) -> None:  # fmt: skip
    """Add the force laws to Q and to the power; table: of the coordinates."""
    for n in range(laws.table.shape[0]):
        kind, where, flag, first = laws.table[n, 0], laws.table[n, 1], laws.table[n, 2], laws.table[n, 3]
        for run in range(x.shape[1]):
            if kind == EFFORT:
                F, work = effort(numbers, first, flag != 0, seen[where, VALUE, run], seen[where, RATE, run], run)
                power[run] += work
                for i in range(2 * VELOCITY):
                    row = VELOCITY * table[where, 1 + i // VELOCITY] + i % VELOCITY
                    if row < Q.shape[0]:  # not of the ground
                        Q[row, run] += F * seen[where, GRADIENT + i, run]
            else:
                R, p = matrix(x, STATE * where + 3, run), vector(laws.points[n], 0, run)
                F = numbers[first, 0, run], numbers[first + 1, 0, run], numbers[first + 2, 0, run]
                if flag == GLOBAL:
                    F = rotate_back(R, F)
                torque, force = (cross(p, F), rotate(R, F)) if kind == PUSH else (F, ZERO)
                power[run] += dot(force, vector(x, STATE * where + 12, run))
                power[run] += dot(torque, vector(x, STATE * where + 15, run))
                for c in range(3):
                    Q[VELOCITY * where + c, run] += force[c]
                    Q[VELOCITY * where + 3 + c, run] += torque[c]


@compiled
def assemble(bodies: Bodies, used: np.ndarray, C: np.ndarray, weight: int, K: np.ndarray) -> None:
    """The lower triangle of K = [A C^T; C 0] with the rows in use: A = M (30), (33) for the weight MASS, else
    diag(I, weight I), which is I for IDENTITY and diag(I, 2 I) for PLACES."""
    k = bodies.masses.shape[0]
    n = VELOCITY * k
    for i in range(K.shape[0]):
        for j in range(i + 1):
            for run in range(C.shape[2]):
                K[i, j, run] = 0.0
    for r in range(used.size):
        for j in range(n):
            for run in range(C.shape[2]):
                K[n + r, j, run] = C[used[r], j, run]
    for i in range(k):
        for c in range(3):
            for run in range(C.shape[2]):
                K[6 * i + c, 6 * i + c, run] = bodies.masses[i, run] if weight == MASS else 1.0
                for d in range(c + 1):
                    J = bodies.inertia[i, c, d, run]
                    K[6 * i + 3 + c, 6 * i + 3 + d, run] = J if weight == MASS else float(weight * (c == d))


@compiled
def solve(n: int, system: System) -> None:
    """Overwrite b by the solution of K b' = b, by L D L^T without pivoting: A (n, n), positive definite, comes first. A
    pivot of a constraint that is nothing but roundoff makes a run singular."""
    K, b, scale, size = system.K, system.b, system.scale, system.b.shape[0]
    factor = np.empty(b.shape[1])
    for run in range(b.shape[1]):
        system.nonsingular[run] = 1.0
    for j in range(size):
        for run in range(b.shape[1]):
            for i in range(n, size if j == n else n):
                scale[i, run] = K[i, i, run]
            if j >= n and not K[j, j, run] < SMALLEST_PIVOT * scale[j, run]:  # both are negative
                system.nonsingular[run] = 0.0
            scale[j, run] = 1.0 / K[j, j, run]
        for i in range(j + 1, size):
            for run in range(b.shape[1]):
                factor[run] = K[i, j, run] * scale[j, run]
                b[i, run] -= factor[run] * b[j, run]
            for c in range(j + 1, i + 1):
                for run in range(b.shape[1]):
                    K[i, c, run] -= factor[run] * K[c, j, run]
    for j in range(size - 1, -1, -1):
        for i in range(j + 1, size):
            for run in range(b.shape[1]):
                b[j, run] -= K[i, j, run] * b[i, run]
        for run in range(b.shape[1]):
            b[j, run] *= scale[j, run]


@compiled
def balance(constraints: Constraints, numbers: np.ndarray, room: Room) -> None:
    """Solve (13) with K assembled: v' and w' of all bodies and lambda of the rows in use go to b, and the power of
    drivers, M v' = Q - C^T lambda, to that of the loads."""
    n, used = room.Q.shape[0], constraints.used
    for i in range(n):
        for run in range(room.Q.shape[1]):
            room.system.b[i, run] = room.Q[i, run]
    for r in range(used.size):
        for run in range(room.Q.shape[1]):
            room.system.b[n + r, run] = room.rows.xi[used[r], run]
    solve(n, room.system)
    for r in range(used.size):
        number = constraints.wanted[used[r]]
        for run in range(room.Q.shape[1]):
            if number >= 0:
                room.power[run] -= room.system.b[n + r, run] * numbers[number, 0, run]
