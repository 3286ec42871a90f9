"""Any mechanism: what is derived from the residuals, the elimination, and the balance of power, at random states."""

from functools import cache

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.drivers import DRIVERS
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import at_time
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.tolerances import WEAK_PIVOT
from lienumba.numerics.expressions import Formula
from tests.facade import JOINTS, Instant
from tests.rigs.mechanisms import dense
from tests.rigs.random_mechanisms import RATES, TOPOLOGIES, WAVES, mechanism

SEEDS = range(24)
STENCIL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}  # the first derivative to eighth order
EPSILON = np.finfo(float).eps


def after(now, dt, u, a=None, dt_clock=None):
    """The state that moves with velocities u, growing at a; its clock with it or by itself."""
    a = np.zeros_like(u) if a is None else a
    bodies = []
    for x, v, e in zip(now.bodies, u.reshape(-1, 6), a.reshape(-1, 6), strict=True):
        shift = dt * v + 0.5 * dt * dt * e
        R = so3.multiply(x[3:12], so3.exp(tuple(shift[3:].tolist())))
        bodies.append((*(np.array(x[:3]) + shift[:3]).tolist(), *R, *(v + dt * e).tolist()))
    return Instant(tuple(bodies), now.t + (dt if dt_clock is None else dt_clock), now.angles)


def slope(function, h=4e-3):
    """Of function(dt) at 0."""
    return sum(c * (np.array(function(s * h)) - np.array(function(-s * h))) for s, c in STENCIL.items()) / h


def velocities(now):
    return np.array([x[12:18] for x in now.bodies]).ravel()


def matrix(model, now):
    rows = sum(c.rows for c in constraints.constraints_of(model))
    return dense(constraints.jacobian(model, now), (rows, 6 * len(model.bodies)))


def positions(model, now):
    """Phi of every row, that of rate drivers by the integral of their rate; 0 on the velocity level."""
    phi = constraints.residual(model, now)
    for driver, rows in zip(model.drivers, constraints.rows_of(model)[len(model.joints) :], strict=True):
        if driver.motion == "rate":
            integral = Formula(WAVES[RATES.index(driver.value[0].text)])
            where = joints.coordinate(model, driver.coordinate, still(now, driver.bodies))
            phi[rows.start] = where - integral(now.t)
    return phi


def quasi_velocities(model, now):
    """psi of every row on the velocity level, by hand; 0 elsewhere."""
    psi = np.zeros(sum(c.rows for c in constraints.constraints_of(model)))
    for driver, rows in zip(model.drivers, constraints.rows_of(model)[len(model.joints) :], strict=True):
        if driver.motion == "angular_velocity":
            x = np.array(now.bodies[driver.bodies[0]])
            w = x[15:18] if driver.frame == "body" else x[3:12].reshape(3, 3) @ x[15:18]
            psi[rows] = w - [at_time(value, now.t) for value in driver.value]
    return psi


def close(a, b, factor=1.0):
    scale = 1.0 + max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0))
    np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-11 * factor * scale)


@cache
def cases(topology):
    return [mechanism(topology, seed) for seed in SEEDS]


def test_there_is_one_of_everything():
    every = [model for topology in TOPOLOGIES for model, _ in cases(topology)]
    assert {j.type for m in every for j in m.joints} == set(JOINTS) - {"coupler", "python"}
    assert {d.motion for m in every for d in m.drivers} >= {
        motion for kind in DRIVERS.values() for motion in kind.motions
    }
    assert {d.coordinate.kind for m in every for d in m.drivers if d.coordinate} == {"angle", "displacement"}
    ties = {tuple(c.kind for c in j.coordinates) for m in every for j in m.joints if j.type == "gear"}
    assert len(ties) == 4
    assert {name for name, kind in JOINTS.items() if kind.coordinate_kinds} >= {
        m.joints[d.coordinate.joint].type for m in every for d in m.drivers if d.coordinate
    }


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_the_jacobian_is_the_slope_of_the_residuals(topology):
    """Along any velocities while the clock stands, and of the clock while all bodies stand."""
    rng = np.random.default_rng(1)
    for model, now in cases(topology):
        C = matrix(model, now)
        levels = [c.level for c in constraints.constraints_of(model) for _ in range(c.rows)]
        on_velocities = np.array(levels) == "velocity"
        for _ in range(2):
            u = rng.standard_normal(C.shape[1])
            expected = slope(lambda dt: positions(model, after(now, dt, u, dt_clock=0.0)))  # noqa: B023
            psi = [quasi_velocities(model, after(now, 0.0, s * u)) for s in (1.0, 0.0)]
            expected[on_velocities] = (psi[0] - psi[1])[on_velocities]
            close(C @ u, expected)
        still_there = np.zeros(C.shape[1])
        expected = slope(lambda dt: positions(model, after(now, 0.0, still_there, dt_clock=dt)))  # noqa: B023
        expected[on_velocities] = quasi_velocities(model, after(now, 0.0, still_there))[on_velocities]
        close(constraints.time_rate(model, now), expected)


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_rate_and_bias_are_those_of_the_jacobian(topology):
    """rate = C v + Phi_t, and xi = -bias is what is left of its slope where no velocity changes."""
    for model, now in cases(topology):
        u = velocities(now)
        rate, bias = constraints.rate_and_bias(model, now)

        def by_jacobian(dt):
            at = after(now, dt, u)  # noqa: B023
            return matrix(model, at) @ u + constraints.time_rate(model, at)  # noqa: B023

        close(rate, by_jacobian(0.0), 0.01)
        close(bias, slope(by_jacobian), 10.0)


def inertia(model, now):
    n = 6 * len(model.bodies)
    M = dense(dynamics.mass_matrix(model, now), (n, n))
    return M + np.tril(M, -1).T


def scaled_system(model, now):
    """K of the KKT equations with unit diagonal of M and rows of length 1 in that scale, the scaling, and C scaled."""
    M, C = inertia(model, now), matrix(model, now)
    columns = 1.0 / np.sqrt(np.diag(M))
    lengths = np.linalg.norm(C * columns, axis=1)
    D = np.concatenate([columns, 1.0 / np.where(lengths > 0.0, lengths, 1.0)])
    K = np.block([[M, C.T], [C, np.zeros((len(C), len(C)))]])
    return K * D * D[:, None], D


def refined(K, b):
    """Dense, with the residuals in extended precision."""
    x, wide = np.linalg.solve(K, b), K.astype(np.longdouble)
    for _ in range(4):
        x = x + np.linalg.solve(K, (b - wide @ x).astype(float))
    return x


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_the_elimination_is_as_accurate_as_the_system_allows(topology):
    """Against a dense solution, for random right-hand sides: rounding times the condition number."""
    rng, tried = np.random.default_rng(2), 0
    for seed, (model, now) in enumerate(cases(topology)):
        K, D = scaled_system(model, now)
        condition, n = np.linalg.cond(K), 6 * len(model.bodies)
        if condition > 1e10:
            continue
        f, g = rng.standard_normal(n) / D[:n], rng.standard_normal(len(D) - n) / D[n:]
        M, C = dynamics.mass_matrix(model, now), constraints.jacobian(model, now)
        got = kkt.solve(kkt.Structure.of(model), M, C, f.tolist(), g.tolist())
        assert got.nonsingular > 0.0
        if got.margin < WEAK_PIVOT:
            continue
        tried += 1
        exact = refined(K, np.concatenate([f, g]) * D)
        error = np.linalg.norm(np.array([*got.x, *got.mu]) / D - exact) / np.linalg.norm(exact)
        assert error < 4.0 * EPSILON * condition, f"{topology} {seed}: {error:.1e}, condition {condition:.1e}"
    assert tried > 0.3 * len(SEEDS)


def compatible(model, now):
    """The state with velocities that the constraints allow."""
    C = matrix(model, now)
    wanted = -np.array(constraints.time_rate(model, now))
    u = velocities(now)
    u = u + np.linalg.lstsq(C, wanted - C @ u, rcond=None)[0]
    return after(now, 0.0, u)


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_energy_grows_by_what_works_on_the_system(topology):
    """Loads, drivers, and a gravity that varies, along the motion with the accelerations of the elimination."""
    tried = worked = 0
    for seed, (model, now) in enumerate(cases(topology)):
        if np.linalg.cond(scaled_system(model, now)[0]) > 1e6:
            continue
        now = compatible(model, now)
        solution = dynamics.accelerations(model, kkt.Structure.of(model), now)
        if solution.margin < WEAK_PIVOT:
            continue
        tried += 1
        u, a = velocities(now), np.array(solution.x)
        growth = slope(lambda dt: sum(dynamics.energies(model, after(now, dt, u, a))), 1e-3)  # noqa: B023
        power = dynamics.power(model, now, solution.mu)
        driven = [mu * rate for mu, rate in zip(solution.mu, constraints.time_rate(model, now), strict=True)]
        worked += any(driven)
        kinetic = [abs(weight * v * e) for weight, v, e in zip(np.diag(inertia(model, now)), u, a, strict=True)]
        size = abs(power) + sum(map(abs, driven)) + sum(kinetic)
        assert abs(growth - power) < 1e-9 * size, f"{topology} {seed}: {growth} instead of {power}"
    assert tried > 0.3 * len(SEEDS)
    assert worked > 0.04 * len(SEEDS)
