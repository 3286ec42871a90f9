"""Projections, from one coarse step with and without them: the nearest state, by solvers that know nothing of ours."""

from typing import Any

import numpy as np
import pytest

from tests.oracles.reference import naive
from tests.oracles.reference.nearest import nearest
from tests.rigs.scenarios import LOOP, PENDULUM, TOP, Twin, scenario, simulate, state_at, twin_of

COARSE = {
    "top": (TOP, 8e-3),
    "pendulum": (PENDULUM, 0.06),
    "loop": (LOOP, 0.1),
}  # steps of Heun that miss by millimetres


def step(name: str, position: str, velocity: str) -> tuple[Any, Twin]:
    mechanism, h = COARSE[name]
    dataset = simulate(mechanism, h, h, method="heun", projection=(position, velocity))
    return dataset, state_at(dataset)


def twin(name: str) -> tuple[Any, Any, Any]:
    mechanism, h = COARSE[name]
    return twin_of(scenario(mechanism, h, h))[0]


@pytest.mark.parametrize("name", COARSE)
def test_positions_go_to_the_papers_minimum(name: str) -> None:
    """In local coordinates |R' - R|^2 is 2 |x|^2 + O(x^4): the minimisers differ by O(x^3), x the correction."""
    _, joints, _ = twin(name)
    _, (r, R, v, w) = step(name, "none", "none")
    _, (new_r, new_R, new_v, new_w) = step(name, "local", "none")
    best_r, best_R = nearest(joints, r, R)
    size = np.sqrt(np.sum((new_r - r) ** 2) + np.sum((new_R - R) ** 2) / 2)
    assert 1e-3 < size < 0.03
    assert np.abs(naive.residual(joints, r, R)).max() > 1e-3
    assert np.abs(naive.residual(joints, new_r, new_R)).max() < 1e-11
    miss = max(np.abs(new_r - best_r).max(), np.abs(new_R - best_R).max())
    assert miss < 0.05 * size**3  # adding up Gauss-Newton steps, or another weight, misses by O(size^2) or O(size)
    np.testing.assert_array_equal(new_v, v)
    np.testing.assert_array_equal(new_w, w)
    np.testing.assert_allclose(new_R @ new_R.transpose(0, 2, 1), np.broadcast_to(np.eye(3), new_R.shape), atol=1e-15)


@pytest.mark.parametrize("name", COARSE)
def test_positions_go_to_the_exact_minimum_in_local_coordinates(name: str) -> None:
    """|x_r|^2 + 2 |x_R|^2 itself: there the naive twin agrees to rounding."""
    _, joints, _ = twin(name)
    _, (r, R, _, _) = step(name, "none", "none")
    tight, loose = 1e-14, 1e-9
    mechanism, h = COARSE[name]
    r_there, R_there, iterations = naive.project_positions(joints, r, R, tight)
    for tolerance, bound in ((tight, 1e-13), (loose, 1e-6)):
        dataset = simulate(mechanism, h, h, method="heun", projection=("local", "none"), tolerance=tolerance)
        new_r, new_R, _, _ = state_at(dataset)
        np.testing.assert_allclose(new_r, r_there, rtol=0, atol=bound)
        np.testing.assert_allclose(new_R, R_there, rtol=0, atol=bound)
        assert 2 <= int(dataset["position_iterations"][-1]) <= iterations
        assert float(dataset["position_violation"][-1]) <= max(tolerance, 4e-15)


@pytest.mark.parametrize("weight", ["mass", "identity"])
@pytest.mark.parametrize("name", COARSE)
def test_velocities_follow_the_closed_formula(name: str, weight: str) -> None:
    """v' = v - W^-1 C^T (C W^-1 C^T)^-1 C v, with C at the projected positions."""
    bodies, joints, _ = twin(name)
    _, (r, R, v, w) = step(name, "local", "none")
    dataset, (same_r, same_R, new_v, new_w) = step(name, "local", weight)
    np.testing.assert_array_equal(same_r, r)
    np.testing.assert_array_equal(same_R, R)
    C, velocities = naive.jacobian(joints, r, R), np.hstack([v, w]).ravel()
    W = naive.mass_matrix(bodies) if weight == "mass" else np.eye(6 * len(bodies))
    G = np.linalg.solve(W, C.T)
    expected = (velocities - G @ np.linalg.solve(C @ G, C @ velocities)).reshape(-1, 6)
    assert np.abs(C @ velocities).max() > 1e-3
    np.testing.assert_allclose(np.hstack([new_v, new_w]), expected, rtol=1e-13, atol=1e-12)
    assert float(dataset["velocity_violation"][-1]) < 1e-11
    assert int(dataset["velocity_iterations"][-1]) == 1


@pytest.mark.parametrize("name", COARSE)
def test_the_two_weights_differ_and_the_mass_weight_costs_less_energy(name: str) -> None:
    bodies, _, _ = twin(name)
    M = naive.mass_matrix(bodies)
    _, (_, _, v, w) = step(name, "local", "none")
    changes = {}
    for weight in ("mass", "identity"):
        _, (_, _, new_v, new_w) = step(name, "local", weight)
        changes[weight] = np.hstack([new_v - v, new_w - w]).ravel()
    assert np.linalg.norm(changes["identity"]) < np.linalg.norm(changes["mass"])
    assert changes["mass"] @ M @ changes["mass"] < changes["identity"] @ M @ changes["identity"]


def test_velocities_alone_are_projected_at_the_unprojected_positions() -> None:
    bodies, joints, _ = twin("pendulum")
    _, (r, R, v, w) = step("pendulum", "none", "none")
    dataset, (same_r, same_R, new_v, new_w) = step("pendulum", "none", "mass")
    np.testing.assert_array_equal(same_r, r)
    np.testing.assert_array_equal(same_R, R)
    expected = naive.project_velocities(bodies, joints, r, R, v, w, "mass")
    np.testing.assert_allclose(np.hstack([new_v, new_w]), np.hstack(expected), rtol=1e-13, atol=1e-12)
    assert int(dataset["position_iterations"][-1]) == 0


def test_a_state_on_the_joints_takes_one_iteration_and_does_not_move_much() -> None:
    """A step so short that it leaves the joints by rounding only."""
    dataset = simulate(PENDULUM, 1e-6, 1e-6)
    assert int(dataset["position_iterations"][-1]) == 1
    free = simulate(PENDULUM, 1e-6, 1e-6, projection=("none", "none"))
    for part, unprojected in zip(state_at(dataset), state_at(free), strict=True):
        np.testing.assert_allclose(part, unprojected, rtol=0, atol=1e-14)
