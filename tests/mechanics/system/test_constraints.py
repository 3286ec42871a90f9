"""What is derived from the residuals is what the paper derives by hand, and what true motions do."""

from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph
from lienumba.groups import so3
from lienumba.mechanics.system import constraints, dynamics, kkt
from tests.facade import GROUND, Instant, Joint, Model
from tests.groups import oracles
from tests.oracles.reference import naive
from tests.rigs.mechanisms import TOPOLOGIES, D, S, arrays, dense, model, rows, state


def paper_top():
    """The paper's heavy top in a general position: the joint is r = R r_b, with r_b towards the mass centre."""
    arm = np.array([0.2, 1.0, -0.3])
    joint = Joint("pivot", S, (GROUND, 0), ((0.0, 0.0, 0.0), tuple((-arm).tolist())))
    m = Model((0.0, 0.0, -9.81), (SimpleNamespace(mass=15.0, inertia=(1.0, 2.0, 3.0, 0.0, 0.0, 0.0)),), (joint,))
    return m, state(1, 3), arm


def test_the_heavy_top_has_the_papers_equations_25_to_28():
    m, x, arm = paper_top()
    (r,), (R,), (v,), (w,) = arrays(x)
    rate, bias = constraints.rate_and_bias(m, Instant(x))
    wt = naive.hat(w)
    assert constraints.residual(m, Instant(x)) == pytest.approx(-r + R @ arm, abs=1e-14)  # (25)
    assert rate == pytest.approx(-v - R @ naive.hat(arm) @ w, abs=1e-13)  # (26)
    assert [-b for b in bias] == pytest.approx(-R @ wt @ wt @ arm, abs=1e-13)  # the right-hand side of (27)
    C = dense(constraints.jacobian(m, Instant(x)), (3, 6))
    np.testing.assert_allclose(C, np.hstack([-np.eye(3), -R @ naive.hat(arm)]), atol=1e-14)  # (28)


def test_the_heavy_top_solves_the_papers_equation_29():
    m, x, arm = paper_top()
    _, (R,), _, (w,) = arrays(x)
    J, a = np.diag([1.0, 2.0, 3.0]), naive.hat(arm)
    K = np.block([
        [15.0 * np.eye(3), np.zeros((3, 3)), -np.eye(3)],
        [np.zeros((3, 3)), J, a @ R.T],
        [-np.eye(3), -R @ a, np.zeros((3, 3))],
    ])  # fmt: skip
    wt = naive.hat(w)
    right = np.concatenate([[0.0, 0.0, -9.81 * 15.0], -wt @ J @ w, -R @ wt @ wt @ arm])
    solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(x))
    assert [*solution.x, *solution.mu] == pytest.approx(np.linalg.solve(K, right), rel=1e-12, abs=1e-12)


def test_a_spherical_joint_of_two_bodies_has_the_papers_equations_36_to_41():
    m, x = model(2, [(S, 0, 1)], 5), state(2, 5)
    (r1, r2), (R1, R2), (v1, v2), (w1, w2) = arrays(x)
    p, q = (np.array(point) for point in m.joints[0].points)
    h1, h2 = naive.hat(w1), naive.hat(w2)
    rate, bias = constraints.rate_and_bias(m, Instant(x))
    assert constraints.residual(m, Instant(x)) == pytest.approx(r1 + R1 @ p - r2 - R2 @ q, abs=1e-13)
    assert rate == pytest.approx(v1 + R1 @ h1 @ p - v2 - R2 @ h2 @ q, abs=1e-13)
    assert bias == pytest.approx(R1 @ h1 @ h1 @ p - R2 @ h2 @ h2 @ q, abs=1e-13)
    C = np.hstack([np.eye(3), -R1 @ naive.hat(p), -np.eye(3), R2 @ naive.hat(q)])
    np.testing.assert_allclose(dense(constraints.jacobian(m, Instant(x)), (3, 12)), C, atol=1e-14)


def test_a_point_fixed_to_the_ground_has_the_papers_equations_b1_to_b6():
    """(B.3) is printed with the wrong sign before R r~ w'; (B.5) and (B.6) are right."""
    m, x = model(1, [(S, GROUND, 0)], 6), state(1, 6)
    (r,), (R,), (v,), (w,) = arrays(x)
    fixed, p = (np.array(point) for point in m.joints[0].points)
    h = naive.hat(w)
    rate, bias = constraints.rate_and_bias(m, Instant(x))
    assert constraints.residual(m, Instant(x)) == pytest.approx(fixed - r - R @ p, abs=1e-14)
    assert rate == pytest.approx(-v - R @ h @ p, abs=1e-13)
    assert [-b for b in bias] == pytest.approx(R @ h @ h @ p, abs=1e-13)
    C = np.hstack([-np.eye(3), R @ naive.hat(p)])
    np.testing.assert_allclose(dense(constraints.jacobian(m, Instant(x)), (3, 6)), C, atol=1e-14)


@pytest.mark.parametrize("name", TOPOLOGIES)
def test_every_mechanism_agrees_with_the_naive_twin(name):
    k, ends = TOPOLOGIES[name]
    m, x = model(k, ends, 7), state(k, 7)
    r, R, v, w = arrays(x)
    rate, bias = constraints.rate_and_bias(m, Instant(x))
    C = dense(constraints.jacobian(m, Instant(x)), (rows(m), 6 * k))
    assert constraints.residual(m, Instant(x)) == pytest.approx(naive.residual(m.joints, r, R), abs=1e-12)
    np.testing.assert_allclose(C, naive.jacobian(m.joints, r, R), atol=1e-12)
    assert rate == pytest.approx(C @ np.hstack([v, w]).ravel(), abs=1e-12)
    assert [-b for b in bias] == pytest.approx(naive.bias(m.joints, r, R, v, w), abs=1e-11)


def along(x, accelerations, t):
    """The state at time t in mpmath: r + v t + a t^2/2 and R exp(w t + e t^2/2), so that v' = a and w' = e at t = 0."""
    moved = []
    for i, y in enumerate(x):
        a, e = accelerations[6 * i : 6 * i + 3], accelerations[6 * i + 3 : 6 * i + 6]
        u = mpmath.matrix([w * t + c * t * t / 2 for w, c in zip(y[15:18], e, strict=True)])
        R = mpmath.matrix(3, 3)
        R[:, :] = mpmath.matrix([list(y[3:6]), list(y[6:9]), list(y[9:12])]) * oracles.rotation(u)
        r = [p + v * t + c * t * t / 2 for p, v, c in zip(y[0:3], y[12:15], a, strict=True)]
        moved.append((*r, *R, *y[12:18]))
    return tuple(moved)


@pytest.mark.parametrize("kind", [S, D])
@pytest.mark.parametrize("bodies", [(0, 1), (1, 0), (GROUND, 0), (1, GROUND)])
def test_rate_and_bias_are_the_derivatives_along_true_motions(kind, bodies):
    """Phi is differentiated numerically, to 15 digits, along a motion with given velocities and accelerations."""
    m, x = model(2, [(kind, *bodies)], 8), state(2, 8)
    accelerations = np.random.default_rng(8).standard_normal(12).tolist()
    rate, bias = constraints.rate_and_bias(m, Instant(x))
    C = dense(constraints.jacobian(m, Instant(x)), (rows(m), 12))
    second = np.array(bias) + C @ accelerations
    with mpmath.workdps(50):
        h = mpmath.mpf(10) ** -10
        before, at, after = (
            constraints.residual(m, Instant(along(x, accelerations, t))) for t in (-h, mpmath.mpf(0), h)
        )
        for row in range(len(at)):
            assert float((after[row] - before[row]) / (2 * h)) == pytest.approx(rate[row], abs=1e-13)
            second_difference = (after[row] - 2 * at[row] + before[row]) / h**2
            assert float(second_difference) == pytest.approx(second[row], abs=1e-12)


def test_entries_that_are_exactly_zero_are_not_there():
    """What the sparsity of the compiled elimination rests on: a joint at the mass centre leaves no lever."""
    m = Model((0.0, 0.0, -9.81), model(1, []).bodies, (Joint("j", S, (GROUND, 0), ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0))),))
    assert constraints.jacobian(m, Instant(state(1))) == {(0, 0): -1.0, (1, 1): -1.0, (2, 2): -1.0}
    far = model(3, [(S, 0, 2)])
    assert {column // 6 for _, column in constraints.jacobian(far, Instant(state(3)))} == {0, 2}


def test_loads_balance_each_body():
    """m v' = weight + forces and the law of moments about the mass centre, from joint forces and torques alone."""
    m, x = model(4, [(S, GROUND, 0), (S, 0, 1), (D, 2, 1), (D, GROUND, 3), (S, 3, 2)], 9), state(4, 9)
    solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(x))
    force, torque = (np.reshape(y, (-1, 3)) for y in constraints.loads(m, Instant(x), solution.mu))
    _, R, _, w = arrays(x)
    total, moment = np.zeros((4, 3)), np.zeros((4, 3))
    for joint, f, t in zip(m.joints, force, torque, strict=True):
        a, b = joint.bodies
        gap = (
            np.array(constraints.residual(Model(m.gravity, m.bodies, (joint,)), Instant(x)))
            if joint.type == S
            else None
        )
        for i, point, sign in ((a, joint.points[0], -1.0), (b, joint.points[1], 1.0)):
            if i != GROUND:
                total[i] += sign * f
                moment[i] += sign * (np.cross(R[i] @ point, f) + t)
        assert gap is None or np.abs(t).max() < 1e-9  # a spherical joint holds no torque about its point
    a = np.reshape(solution.x, (4, 6))
    for i, b in enumerate(m.bodies):
        J = naive.inertia(b)
        np.testing.assert_allclose(b.mass * a[i, :3], b.mass * np.array(m.gravity) + total[i], atol=1e-9)
        np.testing.assert_allclose(J @ a[i, 3:] + np.cross(w[i], J @ w[i]), R[i].T @ moment[i], atol=1e-9)


def test_rows_on_symbols_are_the_rows_on_floats():
    m, x = model(2, [(S, 0, 1), (D, GROUND, 1)], 4), state(2, 4)
    graph = Graph()
    symbols = tuple(graph.inputs("state", 18, 18 * i) for i in range(2))
    rate, bias = constraints.rate_and_bias(m, Instant(symbols))
    from tests.compiler.evaluation import call

    given = np.repeat(np.array(x).reshape(-1, 1), W, axis=1)
    out = call(Kernel("rows", (*constraints.residual(m, Instant(symbols)), *rate, *bias), 0), state=given)[:, 0]
    on_floats = constraints.rate_and_bias(m, Instant(x))
    assert out == pytest.approx([*constraints.residual(m, Instant(x)), *on_floats[0], *on_floats[1]], abs=1e-12)
    assert so3.dot(x[0][3:6], x[0][3:6]) == pytest.approx(1.0)
