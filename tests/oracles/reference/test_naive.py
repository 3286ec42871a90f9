"""The naive twin itself, against finite differences, SciPy, the paper's numbers and the exact heavy top."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from tests.oracles.reference import naive
from tests.oracles.reference.lagrange_top import motion

TOP = [SimpleNamespace(mass=15.0, inertia=(0.234375, 0.46875, 0.234375, 0.0, 0.0, 0.0))]
PIVOT = [SimpleNamespace(type="spherical", bodies=(-1, 0), points=((0, 0, 0), (0, -1, 0)), numbers={})]
GRAVITY = (0.0, 0.0, -9.81)
RK4 = ([[], [1 / 2], [0, 1 / 2], [0, 0, 1]], [1 / 6, 1 / 3, 1 / 3, 1 / 6])


def system(seed=0):
    """Three bodies, a loop of two spherical joints and a rod, a rod to ground: inconsistent on purpose."""
    rng = np.random.default_rng(seed)
    bodies = []
    for _ in range(3):
        X = rng.standard_normal((3, 3))
        J = X @ X.T + 3 * np.eye(3)
        tensor = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
        bodies.append(SimpleNamespace(mass=rng.uniform(1, 3), inertia=tensor))
    ends = [
        ("spherical", 0, 1),
        ("spherical", 1, 2),
        ("distance", 2, 0),
        ("distance", -1, 0),
        ("distance", 1, -1),
    ]
    joints = [
        SimpleNamespace(
            type=kind, bodies=(a, b), points=tuple(rng.standard_normal((2, 3))), numbers={"length": rng.uniform(1, 3)}
        )
        for kind, a, b in ends
    ]
    r, v, w = rng.standard_normal((3, 3, 3))
    return bodies, joints, (r, Rotation.random(3, random_state=seed).as_matrix(), v, w)


def flow(state, accelerations, t):
    """The state moved for a short time along its velocities and accelerations."""
    r, R, v, w = state
    a, e = accelerations[:, :3], accelerations[:, 3:]
    turn = w * t + e * t**2 / 2 - np.cross(w, e) * t**3 / 12  # Magnus, to the order that the tests look at
    turned = np.array([Ri @ expm(naive.hat(ui)) for Ri, ui in zip(R, turn, strict=True)])
    return r + v * t + a * t**2 / 2, turned, v + a * t, w + e * t


# ---------------------------------------------------------------- the group
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-5, 1e-3, 0.3, 0.7, 2.0, 3.1415, 5.0])
def test_exp_and_dexpinv(angle):
    u = angle * np.array([0.6, -0.48, 0.64])
    w = np.array([0.3, -1.2, 0.5])
    np.testing.assert_allclose(naive.exp(u), expm(naive.hat(u)), atol=4e-15)
    powers = [np.linalg.matrix_power(-naive.hat(u), j) for j in range(60)]
    dexp = sum(p / float(np.prod(np.arange(1.0, j + 2))) for j, p in enumerate(powers))  # (A.2), the sign corrected
    np.testing.assert_allclose(dexp @ naive.dexpinv(u, w), w, atol=1e-13)
    if angle < 0.7:
        np.testing.assert_allclose(naive.dexpinv_truncated(u, w, 20), naive.dexpinv(u, w), atol=1e-15)


def test_truncation_leaves_the_next_term():
    u, w = np.array([0.02, -0.01, 0.015]), np.array([0.3, -1.2, 0.5])
    exact = naive.dexpinv(u, w)
    expected = [np.linalg.norm(u), np.linalg.norm(u) ** 2, np.linalg.norm(u) ** 4, np.linalg.norm(u) ** 4]
    for n, size in enumerate(expected):
        error = np.linalg.norm(naive.dexpinv_truncated(u, w, n) - exact)
        assert 1e-4 * size < error < size * np.linalg.norm(w)


# ---------------------------------------------------------------- constraints and dynamics
@pytest.mark.parametrize("seed", range(4))
def test_jacobian_and_bias_are_the_derivatives_of_the_residual(seed):
    bodies, joints, state = system(seed)
    accelerations, _ = naive.accelerations(bodies, joints, GRAVITY, *state)

    def residual(t):
        return naive.residual(joints, *flow(state, accelerations, t)[:2])

    h = 1e-3
    rate = (residual(-2 * h) - 8 * residual(-h) + 8 * residual(h) - residual(2 * h)) / (12 * h)
    C = naive.jacobian(joints, *state[:2])
    velocities = np.hstack(state[2:]).ravel()
    np.testing.assert_allclose(C @ velocities, rate, atol=1e-8)
    second = (residual(h) - 2 * residual(0.0) + residual(-h)) / h**2
    assert C.shape == (9, 18)
    assert np.abs(C @ velocities).max() > 0.1
    np.testing.assert_allclose(second, 0.0, atol=2e-4)  # so are C vdot = xi and its sign
    np.testing.assert_allclose(C @ accelerations.ravel(), naive.bias(joints, *state), atol=1e-12)


def test_the_papers_matrices_of_the_heavy_top():
    rng = np.random.default_rng(1)
    R, w, r_b = Rotation.random(random_state=1).as_matrix(), rng.standard_normal(3), np.array([0.0, 1.0, 0.0])
    r, v = rng.standard_normal(3), rng.standard_normal(3)
    np.testing.assert_allclose(naive.residual(PIVOT, r[None], R[None]), -r + R @ r_b)  # (25)
    C = np.hstack([-np.eye(3), -R @ naive.hat(r_b)])
    np.testing.assert_allclose(naive.jacobian(PIVOT, r[None], R[None]), C)  # (28)
    xi = naive.bias(PIVOT, r[None], R[None], v[None], w[None])
    np.testing.assert_allclose(xi, -R @ naive.hat(w) @ naive.hat(w) @ r_b)  # (27)
    J = np.diag(TOP[0].inertia[:3])
    vdot, force = naive.accelerations(TOP, PIVOT, GRAVITY, r[None], R[None], v[None], w[None])
    np.testing.assert_allclose(15 * vdot[0, :3] - force, 15 * np.array(GRAVITY), atol=1e-12)  # (23)
    np.testing.assert_allclose(J @ vdot[0, 3:] + naive.hat(r_b) @ R.T @ force, -np.cross(w, J @ w), atol=1e-12)  # (24)


def test_a_free_body_falls():
    vdot, multipliers = naive.accelerations(
        TOP, [], GRAVITY, *(np.zeros((1, 3)), np.eye(3)[None]), *np.zeros((2, 1, 3))
    )
    np.testing.assert_allclose(vdot, [[0, 0, -9.81, 0, 0, 0]])
    assert multipliers.shape == (0,)


def test_the_order_of_the_tensors_elements():
    body = SimpleNamespace(mass=2.0, inertia=(4.0, 5.0, 6.0, 0.1, 0.2, 0.3))
    J = np.array([[4.0, 0.1, 0.2], [0.1, 5.0, 0.3], [0.2, 0.3, 6.0]])
    np.testing.assert_array_equal(naive.mass_matrix([body]), np.diag([2.0, 2, 2, 0, 0, 0]) + np.pad(J, (3, 0)))


def test_constraint_forces_do_no_work():
    bodies, joints, (r, R, v, w) = near(2, 0.0)
    v, w = naive.project_velocities(bodies, joints, r, R, v, w)
    vdot, _ = naive.accelerations(bodies, joints, GRAVITY, r, R, v, w)
    power = np.hstack([v, w]).ravel() @ naive.mass_matrix(bodies) @ vdot.ravel()
    falling = sum(body.mass * np.dot(GRAVITY, vi) for body, vi in zip(bodies, v, strict=True))
    assert power == pytest.approx(falling, rel=1e-10)


# ---------------------------------------------------------------- integration
def top_errors(h, end, truncation=None, tableau=RK4):
    """Differences of r and omega from the exact motion at `end`, without projection; and the final state."""
    state = (
        np.array([[0.0, 1.0, 0.0]]),
        np.eye(3)[None],
        np.array([[4.61538, 0.0, 0.0]]),
        np.array([[0.0, 150.0, -4.61538]]),
    )
    for _ in range(round(end / h)):
        state = naive.step(TOP, PIVOT, GRAVITY, state, h, *tableau, truncation)
    (exact,) = motion([end])
    return np.abs(state[0][0] - exact.r).max(), np.abs(state[3][0] - exact.omega).max(), state


@pytest.mark.parametrize(
    ("tableau", "order", "truncation", "h"),
    [
        (([[]], [1]), 1, None, 2e-5),
        (([[], [1 / 2]], [0, 1]), 2, 0, 2e-4),
        (([[], [1 / 2], [-1, 2]], [1 / 6, 2 / 3, 1 / 6]), 3, 1, 4e-4),
        (RK4, 4, 2, 1e-3),
        (RK4, 4, None, 1e-3),
        (([[], [1 / 3], [-1 / 3, 1], [1, -1, 1]], [1 / 8, 3 / 8, 3 / 8, 1 / 8]), 4, None, 1e-3),
    ],
)
def test_order_of_convergence(tableau, order, truncation, h):
    coarse, fine = (top_errors(step, 0.02, truncation, tableau) for step in (h, h / 2))
    for k in (0, 1):
        assert np.log2(coarse[k] / fine[k]) == pytest.approx(order, abs=0.2)


def test_the_papers_velocity_violation():
    """Section 7.1 reports the relative error (31) of 7.196e-8 for h = 1e-4 after 2 s; it grows as h^4."""
    _, _, (r, R, v, w) = top_errors(2e-3, 2.0)
    r_b = np.array([0.0, 1.0, 0.0])
    con = R[0] @ naive.hat(r_b) @ w[0]
    error = np.linalg.norm(-v[0] - con) / np.linalg.norm(con)
    assert error == pytest.approx(7.196e-8 * 20**4, rel=0.15)
    np.testing.assert_allclose(R[0] @ R[0].T, np.eye(3), atol=1e-12)
    assert np.linalg.norm(r[0] - R[0] @ r_b) > 1e-5


def test_a_mechanism_agrees_with_scipy():
    bodies, joints, (r, R, v, w) = system(3)
    state = (r, R, v, w)
    for _ in range(20):
        state = naive.step(bodies, joints, GRAVITY, state, 2.5e-3, *RK4)

    def rate(_, y):
        r, R, v, w = (
            y[:9].reshape(3, 3),
            y[9:36].reshape(3, 3, 3),
            y[36:45].reshape(3, 3),
            y[45:].reshape(3, 3),
        )
        vdot, _ = naive.accelerations(bodies, joints, GRAVITY, r, R, v, w)
        turning = np.array([Ri @ naive.hat(wi) for Ri, wi in zip(R, w, strict=True)])
        return np.concatenate([v.ravel(), turning.ravel(), vdot[:, :3].ravel(), vdot[:, 3:].ravel()])

    start = np.concatenate([part.ravel() for part in (r, R, v, w)])
    y = solve_ivp(rate, (0, 0.05), start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(np.concatenate([part.ravel() for part in state]), y, atol=1e-9)


# ---------------------------------------------------------------- projection
def near(seed, size=3e-3):
    """The mechanism with joints that fit its configuration, and this configuration pushed off by `size`."""
    bodies, joints, (r, R, v, w) = system(seed)
    for joint in joints:
        if joint.type == "spherical":
            shift = naive.separation(joint, r, R) @ R[joint.bodies[1]]
            joint.points = (joint.points[0], joint.points[1] + shift)
        else:
            joint.numbers["length"] = np.linalg.norm(naive.separation(joint, r, R))
    push = size * np.random.default_rng(seed).standard_normal((3, 12))
    push[:, 6:] = 0
    return bodies, joints, naive.moved((r, R, v, w), push)


@pytest.mark.parametrize("seed", [2])
def test_positions_are_projected_to_the_papers_minimum(seed):
    """Against a general optimiser on the twelve numbers of each body, with R R^T = I as in (21), (22)."""
    _, joints, (r, R, _, _) = near(seed)
    assert np.abs(naive.residual(joints, r, R)).max() > 1e-4
    found_r, found_R, iterations = naive.project_positions(joints, r, R)
    assert np.abs(naive.residual(joints, found_r, found_R)).max() < 1e-13
    assert 1 < iterations < 10
    upper = np.triu_indices(3)

    def split(y):
        return y[:9].reshape(3, 3), y[9:].reshape(3, 3, 3)

    def constraints(y):
        r, R = split(y)
        return np.concatenate([naive.residual(joints, r, R), *((Ri @ Ri.T - np.eye(3))[upper] for Ri in R)])

    hat = np.concatenate([r.ravel(), R.ravel()])
    scale = 1e4  # of the order of 1 / |y - hat|^2, for the optimiser's tolerance
    best = minimize(
        lambda y: scale * np.sum((y - hat) ** 2), hat, jac=lambda y: 2 * scale * (y - hat), method="SLSQP",
        constraints={"type": "eq", "fun": constraints}, options={"ftol": 1e-16, "maxiter": 200},
    )  # fmt: skip
    best_r, best_R = split(best.x)
    np.testing.assert_allclose(found_r, best_r, atol=1e-7)
    np.testing.assert_allclose(found_R, best_R, atol=1e-7)


def test_a_point_already_on_the_constraints_stays():
    _, joints, (r, R, _, _) = near(2, 0.0)
    same_r, same_R, iterations = naive.project_positions(joints, r, R, 1e-12)
    assert iterations == 0
    np.testing.assert_array_equal(same_r, r)
    np.testing.assert_allclose(same_R, R, atol=1e-15)


@pytest.mark.parametrize("weight", ["mass", "identity"])
def test_velocities_are_projected_to_the_nearest(weight):
    bodies, joints, (r, R, v, w) = near(2, 0.0)
    new_v, new_w = naive.project_velocities(bodies, joints, r, R, v, w, weight)
    C = naive.jacobian(joints, r, R)
    W = naive.mass_matrix(bodies) if weight == "mass" else np.eye(18)
    correction = np.hstack([new_v - v, new_w - w]).ravel()
    np.testing.assert_allclose(C @ np.hstack([new_v, new_w]).ravel(), 0, atol=1e-12)
    _, _, Vt = np.linalg.svd(C)
    np.testing.assert_allclose(Vt[len(C) :] @ W @ correction, 0, atol=1e-12)  # W-orthogonal to every free motion
    assert np.abs(correction).max() > 0.1
