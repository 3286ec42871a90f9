"""What lienumba derives for the satellite is what the paper has: (34), (35), (13), row by row, signs included.

The order is that of (34); within a revolute joint: point, then x and y of the first side against the second's axis;
within a prismatic one: across x, across y, the same two, then y against x.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from lienumba.mechanics.mechanism.model import Driver
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.numerics.expressions import Formula
from tests.facade import GROUND, Joint, Model
from tests.oracles.paper import formulas
from tests.oracles.paper.satellite import SPIN, anywhere, instant, moving, on_the_joints, satellite, skew_satellite
from tests.oracles.reference.naive import exp, hat

MODELS = [satellite(), skew_satellite(1), skew_satellite(2)]
SEEDS = range(5)
CASES = [
    pytest.param(m, state, id=f"{name}-{where}-{seed}")
    for m, name in zip(MODELS, ("paper", "skew1", "skew2"), strict=True)
    for seed in SEEDS
    for where, state in (("anywhere", anywhere(seed)), ("on_the_joints", on_the_joints(m, seed)))
]


def jacobian(m, now, rows=19):
    C = np.zeros((rows, 6 * len(m.bodies)))
    for place, x in constraints.jacobian(m, now).items():
        C[place] = x
    return C


def top(body, point, drivers=()):
    """One body on the ground."""
    joints = () if point is None else (Joint("pivot", "spherical", (GROUND, 0), ((0.3, -0.2, 0.5), point)),)
    return Model((0.0, 0.0, 0.0), (body,), joints, tuple(drivers))


BODY = SimpleNamespace(mass=2.0, inertia=(1.0, 2.0, 2.5, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(("m", "state"), CASES)
def test_the_jacobian_is_34(m, state):
    C, _ = formulas.constraint_matrix(m, state)
    np.testing.assert_allclose(jacobian(m, instant(state)), C, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("m", "state"), CASES)
def test_the_right_hand_side_is_35(m, state):
    _, xi = formulas.constraint_matrix(m, state)
    _, bias = constraints.rate_and_bias(m, instant(state))
    assert [-x for x in bias] == pytest.approx(xi, abs=1e-12)


@pytest.mark.parametrize(("m", "state"), CASES)
def test_the_rates_are_c_times_the_velocities_less_what_is_prescribed(m, state):
    """(11), and R1 w1 - w_g1 for RH."""
    rates, _ = constraints.rate_and_bias(m, instant(state))
    C, _ = formulas.constraint_matrix(m, state)
    u = np.hstack([state[2], state[3]]).ravel()
    assert rates == pytest.approx(C @ u - np.concatenate([np.zeros(16), SPIN]), abs=1e-12)


@pytest.mark.parametrize(("m", "state"), CASES)
def test_the_accelerations_solve_13_with_the_forces_42_to_44(m, state):
    """Off the joints as well, where Runge-Kutta stages lie."""
    C, xi = formulas.constraint_matrix(m, state)
    M, Q = formulas.mass_matrix(m), formulas.forces(m, state)
    K = np.block([[M, C.T], [C, np.zeros((19, 19))]])
    expected = np.linalg.solve(K, np.concatenate([Q, xi]))
    found = dynamics.accelerations(m, kkt.Structure.of(m), instant(state))
    assert [*found.x, *found.mu] == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("m", MODELS)
@pytest.mark.parametrize("seed", SEEDS)
def test_it_has_19_rows_and_5_freedoms(m, seed):
    """C has full rank, and what it leaves free are the base rod's rotation, the elbow's and the slide's motion."""
    r, R, v, w = on_the_joints(m, seed)
    now = instant((r, R, v, w))
    assert [c.rows for c in constraints.constraints_of(m)] == [3, 3, 5, 5, 3]
    assert constraints.residual(m, now) == pytest.approx(np.zeros(19), abs=1e-14)
    rates, _ = constraints.rate_and_bias(m, now)
    assert rates == pytest.approx(np.zeros(19), abs=1e-14)
    C = jacobian(m, now)
    assert np.linalg.matrix_rank(C) == 19
    free = np.array([np.hstack(moving(m, r, R, np.zeros(3), unit)).ravel() for unit in np.eye(5)])
    assert np.linalg.matrix_rank(free) == 5
    np.testing.assert_allclose(C @ free.T, 0.0, atol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_prescribed_velocity_that_varies_adds_its_derivative(seed):
    m = satellite(spin=(Formula("0.3*sin(2*t)"), 0.1, Formula("exp(-t)*t**2")))
    state, t = anywhere(seed), 0.7
    growth = [0.6 * np.cos(2 * t), 0.0, np.exp(-t) * (2 * t - t**2)]
    C, xi = formulas.constraint_matrix(m, state, growth)
    _, bias = constraints.rate_and_bias(m, instant(state, t))
    assert [-x for x in bias] == pytest.approx(xi, abs=1e-12)
    np.testing.assert_allclose(jacobian(m, instant(state, t)), C, rtol=0, atol=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_heavy_top_has_26_to_28(seed):
    """r_b points from the pivot to the mass centre, the joint's point the other way: with the pivot at the origin."""
    r, R, v, w = (part[:1] for part in anywhere(seed))
    arm = np.random.default_rng(seed).standard_normal(3)
    m, now = top(BODY, tuple((-arm).tolist())), instant((r, R, v, w))
    rates, bias = constraints.rate_and_bias(m, now)
    W = hat(w[0])
    assert rates == pytest.approx(-v[0] - R[0] @ hat(arm) @ w[0], abs=1e-13)  # (26)
    assert [-x for x in bias] == pytest.approx(-R[0] @ W @ W @ arm, abs=1e-13)  # (27)
    expected = np.hstack([-np.eye(3), -R[0] @ hat(arm)])  # (28)
    np.testing.assert_allclose(jacobian(m, now, 3), expected, atol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_fixed_point_has_b2_to_b6(seed):
    """(B.3) is printed with the wrong sign before R r~ w'; with (B.5) and (B.6) it reads C v' - xi = 0."""
    r, R, v, w = (part[:1] for part in anywhere(seed))
    p = np.random.default_rng(seed).standard_normal(3)
    m, now = top(BODY, tuple(p.tolist())), instant((r, R, v, w))
    rates, bias = constraints.rate_and_bias(m, now)
    C, xi = formulas.fixed_point(R[0], w[0], p)
    np.testing.assert_allclose(jacobian(m, now, 3), C, atol=1e-14)
    assert [-x for x in bias] == pytest.approx(xi, abs=1e-13)
    assert rates == pytest.approx(-v[0] - R[0] @ hat(w[0]) @ p, abs=1e-13)  # (B.2)
    a, dw = np.random.default_rng(seed + 9).standard_normal((2, 3))
    second = -a + R[0] @ hat(p) @ dw - R[0] @ hat(w[0]) @ hat(w[0]) @ p  # (B.3), corrected
    assert C @ np.concatenate([a, dw]) - xi == pytest.approx(second, abs=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_b3_corrected_is_the_second_derivative(seed):
    """By differences along a motion with constant accelerations."""
    rng = np.random.default_rng(seed)
    p, u, du, v, a = rng.standard_normal((5, 3))
    R = exp(rng.standard_normal(3))
    h = 1e-3

    def phi(t):
        """-r - R(t) p, R(t) = R exp(u t + du t^2/2): w = u and w' = du at t = 0."""
        return -(v * t + a * t**2 / 2) - R @ exp(u * t + du * t**2 / 2) @ p

    differences = (-phi(2 * h) + 16 * phi(h) - 30 * phi(0.0) + 16 * phi(-h) - phi(-2 * h)) / (12 * h * h)
    C, xi = formulas.fixed_point(R, u, p)
    assert C @ np.concatenate([a, du]) - xi == pytest.approx(differences, abs=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("on", [True, False], ids=["on", "off"])
def test_a_prescribed_rotation(seed, on):
    """R = T(t): rows vee(T^T R), E = T^T R, E' = E w~ - W~ E with W the angular velocity of T, which is constant here
    as T = exp(k t) about one axis k."""
    r, R, v, w = (part[:1] for part in anywhere(seed))
    k, t = np.random.default_rng(seed).standard_normal(3), 0.6
    T = exp(k * t)
    if on:
        R, w = T[None], k[None]
    driver = Driver("attitude", "orientation", (0,), tuple(Formula(f"{x!r}*t") for x in k.tolist()))
    m, now = top(BODY, None, [driver]), instant((r, R, v, w), t)
    E, a, b = T.T @ R[0], hat(w[0]), hat(k)
    first = E @ a - b @ E
    second = first @ a - b @ first
    rates, bias = constraints.rate_and_bias(m, now)
    assert constraints.residual(m, now) == pytest.approx(vee(E), abs=1e-13)
    assert rates == pytest.approx(vee(first), abs=1e-13)
    assert bias == pytest.approx(vee(second), abs=1e-12)
    expected = np.hstack([np.zeros((3, 3)), (np.trace(E) * np.eye(3) - E.T) / 2])
    np.testing.assert_allclose(jacobian(m, now, 3), expected, atol=1e-13)
    if on:
        assert [*rates, *bias, *vee(E)] == pytest.approx(np.zeros(9), abs=1e-13)


def vee(A):
    """The vector of A's skew part."""
    S = (A - A.T) / 2
    return np.array([S[2, 1], S[0, 2], S[1, 0]])
