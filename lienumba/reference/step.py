"""Steps of one length: the Munthe-Kaas method (20) and the projections (21), (22), run by run."""

import numpy as np

from lienumba.reference.compiling import compiled, entry
from lienumba.reference.coordinates import constrain, evaluate
from lienumba.reference.dynamics import assemble, balance, load, solve, weigh
from lienumba.reference.mechanism import (
    ALGEBRA,
    NON_FINITE,
    NONE,
    NOT_CONVERGED,
    PLACES,
    ROTATION,
    SINGULAR,
    STATE,
    SUCCESS,
    VALUE,
    VELOCITY,
    Mechanism,
    Method,
    Records,
    Room,
    Run,
)
from lienumba.reference.rotations import dexpinv, dot, matrix, turned, vector

HUGE = 1e300  # a sum of squares below this is finite
ROUNDOFF = 16.0 * 2.0**-52  # violations below this, relative to the mechanism, are roundoff


@compiled
def any_of(flags: np.ndarray, value: int) -> bool:
    """Whether a flag of any run has this value."""
    found = False
    for run in range(flags.size):
        found = found or flags[run] == value
    return found


@compiled
def take(x: np.ndarray, y: np.ndarray, code: np.ndarray) -> None:
    """x = y in the runs that go on; y may have more rows."""
    for i in range(x.shape[0]):
        for run in range(x.shape[1]):
            if code[run] == SUCCESS:
                x[i, run] = y[i, run]


@compiled
def move(x: np.ndarray, u: np.ndarray, y: np.ndarray) -> None:
    """y = x exp(u) (16), (17), in the group of section 2; u (12 k, N): of r, R, v and w of every body."""
    for i in range(u.shape[0] // ALGEBRA):
        to, by = STATE * i, ALGEBRA * i
        for run in range(x.shape[1]):
            R = turned(matrix(x, to + 3, run), vector(u, by + 3, run))
            for c in range(9):
                y[to + 3 + c, run] = R[c]
            for c in range(3):
                y[to + c, run] = x[to + c, run] + u[by + c, run]
                y[to + 12 + c, run] = x[to + 12 + c, run] + u[by + 6 + c, run]
                y[to + 15 + c, run] = x[to + 15 + c, run] + u[by + 9 + c, run]


@compiled
def combine(method: Method, stage: int, slopes: np.ndarray, u: np.ndarray, code: np.ndarray) -> None:
    """u = h sum_j a_ij f*_j of stage i, or with b_j behind the last one; ends runs of which it turns a body too far or
    is not finite."""
    square = np.zeros(u.shape[1])
    for i in range(u.shape[0]):
        for run in range(u.shape[1]):
            u[i, run] = 0.0
        for j in range(stage):
            weight = method.h * (method.b[j] if stage == method.b.size else method.A[stage, j])
            for run in range(u.shape[1]):
                u[i, run] += weight * slopes[j, i, run]
        for run in range(u.shape[1]):
            square[run] += u[i, run] * u[i, run]
    for run in range(u.shape[1]):
        for i in range(u.shape[0] // ALGEBRA):
            w = vector(u, ALGEBRA * i + 3, run)
            if code[run] == SUCCESS and dot(w, w) >= method.largest:
                code[run] = ROTATION
        if code[run] == SUCCESS and not square[run] < HUGE:
            code[run] = NON_FINITE


@compiled
def slope(terms: int, u: np.ndarray, y: np.ndarray, accelerations: np.ndarray, slopes: np.ndarray) -> None:
    """f* = dexp^-1_{-u}(F) with F = (v, w, v', w') at y (15), (19), (A.9)."""
    for i in range(u.shape[0] // ALGEBRA):
        of, to, row = STATE * i, ALGEBRA * i, VELOCITY * i
        for run in range(u.shape[1]):
            w = dexpinv(vector(u, to + 3, run), vector(y, of + 15, run), terms)
            for c in range(3):
                slopes[to + c, run], slopes[to + 3 + c, run] = y[of + 12 + c, run], w[c]
                slopes[to + 6 + c, run] = accelerations[row + c, run]
                slopes[to + 9 + c, run] = accelerations[row + 3 + c, run]


@compiled
def violation(rows: np.ndarray, wanted: np.ndarray, positions: bool, roundoff: float, run: int) -> float:
    """The largest of the rows (m, N) of a run that is more than roundoff; positions: only of those that have one."""
    worst = 0.0
    for row in range(rows.shape[0]):
        size = abs(rows[row, run])
        if not (positions and wanted[row] >= 0):
            if np.isnan(size):
                return np.inf
            worst = max(worst, size if size > roundoff else 0.0)
    return worst


@compiled
def correct(mechanism: Mechanism, room: Room, weight: int, place: int) -> None:
    """Solve (22), W x + C^T mu = 0 and C (x - u) = -Phi, or -psi for velocities, for x in b; place: of x in u."""
    n, used, wanted = room.Q.shape[0], mechanism.constraints.used, mechanism.constraints.wanted
    K, b = room.system.K, room.system.b
    assemble(mechanism.bodies, used, room.rows.C, weight, K)
    for i in range(n):
        for run in range(b.shape[1]):
            b[i, run] = 0.0
    for r in range(used.size):
        row = used[r]
        left_out = weight == PLACES and wanted[row] >= 0  # a row without position leaves x alone
        for run in range(b.shape[1]):
            b[n + r, run] = -room.rows.phi[row, run] if weight == PLACES else -room.rows.psi[row, run]
            K[n + r, n + r, run] = -1.0 if left_out else 0.0
        for i in range(n):
            at = ALGEBRA * (i // VELOCITY) + place + i % VELOCITY
            for run in range(b.shape[1]):
                K[n + r, i, run] = 0.0 if left_out else K[n + r, i, run]
                b[n + r, run] += K[n + r, i, run] * room.u[at, run]
    solve(n, room.system)


@compiled
def project(mechanism: Mechanism, method: Method, numbers: np.ndarray, run: Run, room: Room, weight: int) -> None:
    """(21), (22): move room.y to the nearest r, R with Phi = 0 (weight PLACES), or to the nearest v, w with psi = 0 in
    the norm of M (MASS) or of I (IDENTITY).

    In coordinates R = R^ exp(x_R) about the projected state the paper's |R - R^|^2 is 2 |x_R|^2 and R R^T = I holds, so
    W = diag(I, 2 I). Every iteration solves for the whole correction x, not for its change.
    """
    kind = 0 if weight == PLACES else 1
    wanted, rows = mechanism.constraints.wanted, room.rows
    take(room.hat, room.y, run.code)
    for lane in range(room.y.shape[1]):
        room.pending[lane] = run.code[lane] == SUCCESS
    for i in range(room.u.shape[0]):
        for lane in range(room.y.shape[1]):
            room.u[i, lane] = 0.0
    for iteration in range(method.limit + 1):
        evaluate(mechanism.coordinates, room.y, run.near, room.seen)
        constrain(mechanism.coordinates, mechanism.constraints, numbers, room.seen, rows)
        for lane in range(room.y.shape[1]):
            if room.pending[lane] and iteration > 0:
                found, roundoff = rows.phi if kind == 0 else rows.psi, ROUNDOFF * run.size[lane]
                room.pending[lane] = violation(found, wanted, kind == 0, roundoff, lane) > method.tolerance
                if room.pending[lane] and iteration == method.limit:
                    run.code[lane] = NOT_CONVERGED
        if not any_of(room.pending, 1) or iteration == method.limit:
            return
        correct(mechanism, room, weight, 6 * kind)
        for lane in range(room.y.shape[1]):
            if room.pending[lane]:
                run.iterations[kind, lane] = max(run.iterations[kind, lane], iteration + 1)
        for i in range(room.Q.shape[0]):
            at = ALGEBRA * (i // VELOCITY) + 6 * kind + i % VELOCITY
            for lane in range(room.y.shape[1]):
                room.u[at, lane] = room.system.b[i, lane] if room.pending[lane] else room.u[at, lane]
        move(room.hat, room.u, room.y)


@compiled
def store(used: np.ndarray, run: Run, b: np.ndarray, records: Records, place: int) -> None:
    """Store the state, and b with its accelerations and multipliers, of the runs that go on, at one place of the
    records."""
    n = records.accelerations.shape[1]
    take(records.states[place], run.x, run.code)
    take(records.near[place], run.near, run.code)
    take(records.accelerations[place], b, run.code)
    take(records.iterations[place], run.iterations, run.code)
    for lane in range(b.shape[1]):
        if run.code[lane] == SUCCESS:
            records.work[place, lane] = run.work[lane]
            for row in range(records.multipliers.shape[1]):
                records.multipliers[place, row, lane] = 0.0
            for r in range(used.size):
                records.multipliers[place, used[r], lane] = b[n + r, lane]
        run.iterations[0, lane], run.iterations[1, lane] = 0.0, 0.0


@compiled
def commit(method: Method, run: Run, room: Room) -> None:
    """Take the projected state in the runs that go on."""
    take(run.x, room.y, run.code)
    for lane in range(run.x.shape[1]):
        if run.code[lane] == SUCCESS:
            run.steps[lane] += 1
            for s in range(method.b.size):
                run.work[lane] += method.h * method.b[s] * room.powers[s, lane]


@entry
def march(
    mechanism: Mechanism, method: Method, numbers: np.ndarray, run: Run, room: Room, records: Records, first: int
) -> None:
    """Make the steps (20) behind step `first`, one less than numbers (steps + 1, s + 1, n, 2, N) has; store the outputs
    behind that step, of step 0 also the start. The numbers of a step are at its stages and at its end."""
    bodies, coordinates, constraints, laws = mechanism
    last, stages, place, system = numbers.shape[0] - 1, method.b.size, 0, room.system
    while place < records.steps.size and records.steps[place] < first + (first > 0):
        place += 1
    for n in range(last + 1):
        due = place < records.steps.size and records.steps[place] == first + n
        if not any_of(run.code, SUCCESS) or (n == last and not due):
            return
        for s in range(stages + 1):
            combine(method, s, room.slopes, room.u, run.code)
            move(run.x, room.u, room.y)
            if s == stages:
                break
            evaluate(coordinates, room.y, run.near, room.seen)
            constrain(coordinates, constraints, numbers[n, s], room.seen, room.rows)
            weigh(bodies, numbers[n, s], room.y, room.Q, room.power)
            load(laws, coordinates.table, numbers[n, s], room.y, room.seen, room.Q, room.power)
            assemble(bodies, constraints.used, room.rows.C, 0, system.K)
            balance(constraints, numbers[n, s], room)
            for lane in range(run.x.shape[1]):
                for c in range(run.near.shape[0] if s == 0 else 0):
                    run.near[c, lane] = room.seen[c, VALUE, lane]
            if s == 0 and due:
                store(constraints.used, run, system.b, records, place)
                place += 1
            if n == last:
                return
            slope(method.terms, room.u, room.y, system.b, room.slopes[s])
            for lane in range(run.x.shape[1]):
                room.powers[s, lane] = room.power[lane]
                if run.code[lane] == SUCCESS and system.nonsingular[lane] == 0.0:
                    run.code[lane] = SINGULAR
        for kind in range(2):
            weight = method.positions if kind == 0 else method.velocities
            if weight != NONE and constraints.used.size > 0:
                project(mechanism, method, numbers[n, stages], run, room, weight)
        commit(method, run, room)
