"""Force laws against formulas written down by hand, and against differences of their own energy."""

from math import inf

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph
from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.system import applied_forces, dynamics
from tests.compiler.evaluation import machine_code
from tests.facade import GROUND, Instant
from tests.mechanics.elements.force_cases import FORCES, INTERNAL, SEEDS, START, instant, model, moved, velocities
from tests.rigs.mechanisms import state


def growth_of_energy(m, now, u, per_time=0.0, h=1e-4):
    """The derivative of the potential along u, by fourth-order differences."""
    V = [applied_forces.potential(m, moved(now, u, s * h, per_time * s * h)) for s in (-2, -1, 1, 2)]
    return (V[0] - 8.0 * V[1] + 8.0 * V[2] - V[3]) / (12.0 * h)


# ---------------------------------------------------------------- by hand
def parts(now, i):
    x = np.zeros(18) if i == GROUND else np.array(now.bodies[i])
    R = np.eye(3) if i == GROUND else x[3:12].reshape(3, 3)
    return x[:3], R, x[12:15], x[15:18]


def point(now, i, p):
    """Place and velocity of a point, global frame."""
    r, R, v, w = parts(now, i)
    return r + R @ p, v + R @ np.cross(w, p)


def wrench(now, loads):
    """Q of (body, point in its frame or None, force, torque), the last two in the global frame."""
    Q = np.zeros((len(now.bodies), 6))
    for i, p, force, torque in loads:
        if i != GROUND:
            R = parts(now, i)[1]
            Q[i, :3] += force
            Q[i, 3:] += R.T @ torque + (0.0 if p is None else np.cross(p, R.T @ force))
    return Q.ravel()


def number(force, name, t, default=0.0):
    x = force.numbers.get(name, default)
    return [y(t) if callable(y) else y for y in x] if isinstance(x, tuple) else x(t) if callable(x) else x


def pair(now, force, pull):
    """Opposite forces on both points."""
    (a, b), (p, q) = force.bodies, force.points
    return wrench(now, [(a, p, pull, np.zeros(3)), (b, q, -pull, np.zeros(3))])


def by_hand(m, now):
    """Q of the model's only force: what textbooks say."""
    (force,), t, none = m.forces, now.t, np.zeros(3)
    n = lambda name, default=0.0: number(force, name, t, default)  # noqa: E731
    kind = force.type
    if kind in ("spring_damper", "point_mass_gravity"):
        (x, u), (y, v) = (point(now, i, p) for i, p in zip(force.bodies, force.points, strict=True))
        length = np.linalg.norm(y - x)
        along_it = (y - x) / length
        if kind == "point_mass_gravity":
            return pair(now, force, n("mu") * m.bodies[1].mass / length**2 * along_it)
        free = n("free_length") if force.rest is None else force.rest[0]
        return pair(now, force, (n("stiffness") * (length - free) + n("damping") * (v - u) @ along_it) * along_it)
    if kind in ("force", "torque", "drag"):
        (i,) = force.bodies
        R, p = parts(now, i)[1], force.points[0] if force.points else None
        if kind == "drag":
            u = point(now, i, p)[1]
            return wrench(now, [(i, p, -(n("linear") + n("quadratic") * np.linalg.norm(u)) * u, none)])
        value = R @ n("value") if force.frame == "body" else np.array(n("value"))
        return wrench(now, [(i, p, value, none) if kind == "force" else (i, None, none, value)])
    if kind == "bushing":
        return bushing_by_hand(force, now, n)
    return along_joint(m, force, now, n)


def bushing_by_hand(force, now, n):
    """The torque belongs to the rotation vector u: what works on w works on u' = dexpinv(u, w)."""
    (a, b), (p, q) = force.bodies, force.points
    (x, u), (y, v) = point(now, a, p), point(now, b, q)
    (_, A, _, wa), (_, B, _, wb) = parts(now, a), parts(now, b)
    turn = so3.log(tuple((A.T @ B @ np.reshape(START, (3, 3)).T).ravel()))
    slip = A.T @ (B @ wb - A @ wa)  # of b relative to a, in the frame of a
    rate = np.array(so3.dexpinv(turn, tuple(slip)))
    d, dd = A.T @ (y - x), A.T @ (v - u - np.cross(A @ wa, y - x))
    zero = (0.0, 0.0, 0.0)
    force_on_b = A @ -(np.multiply(n("stiffness", zero), d) + np.multiply(n("damping", zero), dd))
    effort = -(np.multiply(n("rotational_stiffness", zero), turn) + np.multiply(n("rotational_damping", zero), rate))
    to_rate = np.array([so3.dexpinv(turn, tuple(e)) for e in np.eye(3)]).T
    torque = A @ to_rate.T @ effort
    # the force on b acts at its point; on a at the same place
    return wrench(now, [(b, q, force_on_b, torque), (a, tuple(A.T @ (y - parts(now, a)[0])), -force_on_b, -torque)])


def along_joint(m, force, now, n):
    joint = m.joints[0]
    (a, b), (p, q), z = joint.bodies, joint.points, np.array(joint.frames[0][2])
    (x, u), (y, v) = point(now, a, p), point(now, b, q)
    r, A, _, wa = parts(now, a)
    c = joints.coordinate(m, force.coordinate, still(now, joint.bodies))
    axis = A @ z
    if force.coordinate.kind == "displacement":
        rate = axis @ (v - u) + np.cross(A @ wa, axis) @ (y - x)
    else:
        rate = growth_of_angle(m, force, now, velocities(now))
    f = effort_by_hand(force, c, rate, n, now.t)
    if force.coordinate.kind == "displacement":
        at = tuple(A.T @ (y - r))
        return wrench(now, [(b, q, f * axis, np.zeros(3)), (a, at, -f * axis, np.zeros(3))])
    return f * np.array([growth_of_angle(m, force, now, e) for e in np.eye(12)])


def growth_of_angle(m, force, now, u, h=1e-4):
    """Off its axis too."""
    every = [moved(now, u, s * h) for s in (-2, -1, 1, 2)]
    c = [joints.coordinate(m, force.coordinate, still(at, m.joints[0].bodies)) for at in every]
    return (c[0] - 8.0 * c[1] + 8.0 * c[2] - c[3]) / (12.0 * h)


def effort_by_hand(force, c, rate, n, t):
    if force.type == "torsion_spring":
        return -n("stiffness") * (c - n("free_angle")) - n("damping") * rate
    if force.type == "friction":
        return -n("viscous") * rate - n("coulomb") * np.tanh(rate / n("velocity", 1e-3))
    if force.type == "actuator":
        target = n("target")
        target_rate = (number(force, "target", t + 1e-6) - number(force, "target", t - 1e-6)) / 2e-6
        f = n("value") + n("stiffness") * (target - c) + n("damping") * (target_rate - rate)
        return np.clip(f, -n("limit", inf), n("limit", inf))
    f = 0.0
    if c > n("upper", inf):
        f = min(0.0, -n("stiffness") * (c - n("upper")) - n("damping") * rate)
    if c < n("lower", -inf):
        f = max(0.0, n("stiffness") * (n("lower") - c) - n("damping") * rate)
    return f


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", FORCES)
def test_a_force_is_what_textbooks_say(name, seed):
    m, now = model(FORCES[name]), instant(seed)
    Q = np.array(applied_forces.generalized(m, now))
    np.testing.assert_allclose(Q, by_hand(m, now), rtol=1e-9, atol=1e-9 * (1.0 + np.abs(Q).max()))


# ---------------------------------------------------------------- energy
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", FORCES)
def test_forces_work_as_potential_and_power_say(name, seed):
    """Q u = power - dV/dt, in whatever direction the state moves and while the clock runs."""
    m, now = model(FORCES[name]), instant(seed)
    u = velocities(now)
    work = np.dot(applied_forces.generalized(m, now), u)
    expected = applied_forces.power(m, now) - growth_of_energy(m, now, u, per_time=1.0)
    assert work == pytest.approx(expected, rel=1e-8, abs=1e-7)


@pytest.mark.parametrize("name", ["spring", "torsion spring", "bushing", "attraction", "planet", "stop that moves"])
def test_without_dampers_forces_are_slopes_of_the_potential(name):
    m, now = model(FORCES[name]), instant(3)
    slopes = [growth_of_energy(m, now, e) for e in np.eye(12)]
    Q = np.array(applied_forces.generalized(m, now))
    np.testing.assert_allclose(Q, -np.array(slopes), atol=1e-8 * (1.0 + np.abs(Q).max()))


@pytest.mark.parametrize("name", ["spring", "torsion spring", "bushing", "attraction"])
def test_conservative_forces_have_no_power(name):
    assert applied_forces.power(model(FORCES[name]), instant(1)) == 0.0


@pytest.mark.parametrize("name", ["friction", "friction along", "drag"])
def test_what_brakes_takes_energy(name):
    for seed in range(20):
        assert applied_forces.power(model(FORCES[name]), instant(seed)) < 0.0


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", INTERNAL)
def test_what_acts_between_bodies_cancels(name, seed):
    """No force and no moment about the origin is left."""
    m, now = model(FORCES[name]), instant(seed)
    Q = np.array(applied_forces.generalized(m, now)).reshape(2, 6)
    moment = sum(np.cross(parts(now, i)[0], Q[i, :3]) + parts(now, i)[1] @ Q[i, 3:] for i in range(2))
    scale = 1e-12 * (1.0 + np.abs(Q).max())
    np.testing.assert_allclose(Q[0, :3] + Q[1, :3], 0.0, atol=scale)
    np.testing.assert_allclose(moment, 0.0, atol=10.0 * scale)


def test_energy_balance_along_a_motion():
    """Two bodies under all smooth forces at once: kinetic + potential - work stays, to the integrator's tolerance."""
    m = model(*(force for name, force in FORCES.items() if not name.startswith(("stop", "servo at"))))
    graph = Graph()
    now = Instant(tuple(graph.inputs("state", 18, 18 * i) for i in range(2)), graph.input("clock", 0))
    run = machine_code(Kernel("motion", (*dynamics.loads(m, now), applied_forces.power(m, now)), 0))
    inverse = [np.linalg.inv(tensor(b)) for b in m.bodies]

    def slope(t, y):
        result = run(state=np.repeat(y[:-1, None], W, axis=1), clock=np.full((1, W), t))[:, 0]
        slopes = []
        for i, b in enumerate(m.bodies):
            x, Q = y[18 * i : 18 * i + 18], result[6 * i : 6 * i + 6]
            turning = x[3:12].reshape(3, 3) @ np.reshape(so3.hat(tuple(x[15:])), (3, 3))
            slopes += [*x[12:15], *turning.ravel(), *(Q[:3] / b.mass), *(inverse[i] @ Q[3:])]
        return [*slopes, result[-1]]

    def energy(t, y):
        return sum(dynamics.energies(m, Instant(tuple(tuple(x) for x in y[:-1].reshape(2, 18)), t)))

    start = np.append(np.array(state(2, 5)).ravel(), 0.0)
    solution = solve_ivp(slope, (0.0, 0.5), start, method="DOP853", rtol=1e-11, atol=1e-11)
    work, change = solution.y[-1, -1], energy(0.5, solution.y[:, -1]) - energy(0.0, start)
    assert abs(work) > 1.0
    assert change == pytest.approx(work, rel=1e-10)


def tensor(b):
    xx, yy, zz, xy, xz, yz = b.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
