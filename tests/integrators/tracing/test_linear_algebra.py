"""Dense linear algebra of many runs: null spaces, masses, and what roundoff makes of eigenvalues."""

import numpy as np
import pytest

from lienumba.integrators.tracing.linear.algebra import (
    NullSpace,
    accelerations,
    eigenvalues,
    eigenvectors,
    grows,
)


def constraints(runs: int = 5) -> np.ndarray:
    """Three rows of seven coordinates and one that depends on them; the last two coordinates are touched by none."""
    C = np.random.default_rng(2).normal(size=(runs, 4, 7))
    C[:, 3] = 2.0 * C[:, 0] - C[:, 2]
    C[:, :, 5:] = 0.0
    return C


def test_a_null_space_is_one_and_leaves_untouched_coordinates_alone():
    C = constraints()
    space = NullSpace.of(C, 1e-9)
    assert space.rank.tolist() == [3] * 5
    assert (space.independent.sum(axis=1) == 4).all()
    np.testing.assert_allclose(C @ space.basis, 0.0, atol=1e-13)
    np.testing.assert_array_equal(space.basis[:, 5:], np.broadcast_to(np.eye(7)[5:], (5, 2, 7)))
    for basis, independent in zip(space.basis, space.independent, strict=True):
        np.testing.assert_array_equal(basis[independent][:, independent], np.eye(4))
        assert not basis[:, ~independent].any()
    given = space.along(space.independent[0])
    np.testing.assert_allclose(C @ given.basis, 0.0, atol=1e-12)
    b = C[:, :, :2]
    np.testing.assert_allclose(C @ given.dependent(b), b, atol=1e-12)
    assert not given.dependent(b)[:, space.independent[0]].any()


def test_of_equal_columns_the_first_is_independent():
    space = NullSpace.of(np.array([[[1.0, 1.0, 1.0]]]), 1e-9)
    assert space.independent.tolist() == [[True, True, False]]


def test_redundant_rows_have_the_shortest_solutions():
    C = constraints()
    x = np.random.default_rng(3).normal(size=(5, 7))
    b = (C @ x[:, :, None])[:, :, 0]
    inverse = NullSpace.of(C, 1e-9).inverse
    for run in range(5):
        shortest = np.linalg.lstsq(C[run], b[run], rcond=1e-9)[0]
        np.testing.assert_allclose(inverse[run] @ b[run], shortest, atol=1e-12)


def test_a_motion_is_that_of_the_equations_with_multipliers():
    """Without the redundant row these have one solution."""
    C, rng = constraints(), np.random.default_rng(5)
    M, g, x = np.diag(rng.uniform(1.0, 3.0, 7)), rng.normal(size=(5, 7, 1)), rng.normal(size=(5, 7, 1))
    motion, multipliers = NullSpace.of(C, 1e-9).motion(np.broadcast_to(M, (5, 7, 7)), g, C @ x)
    for run in range(5):
        own = C[run, :3]
        whole = np.block([[M, own.T], [own, np.zeros((3, 3))]])
        expected = np.linalg.solve(whole, np.concatenate([g[run], own @ x[run]]))[:7]
        np.testing.assert_allclose(motion[run], expected, atol=1e-12)
        np.testing.assert_allclose(M @ motion[run] + C[run].T @ multipliers[run], g[run], atol=1e-12)


def test_a_run_that_is_not_finite_is_nan_alone():
    C, M = constraints(3), np.broadcast_to(np.diag([1e-9, 1.0, 1e9]), (3, 3, 3)).copy()
    C[1, 0, 0], M[1, 0, 0] = np.nan, np.inf
    b = np.ones((3, 3, 1))
    for found in (NullSpace.of(C, 1e-9).basis, accelerations(M, b), eigenvalues(M, np.zeros(3))):
        assert np.isnan(found[1].real).any()
        assert np.isfinite(found[[0, 2]]).all()
    np.testing.assert_allclose(accelerations(M, b)[0, :, 0], [1e9, 1.0, 1e-9], rtol=1e-14)


def test_without_mass_a_direction_does_not_move():
    M = np.array([[[2.0, 0.0], [0.0, 0.0]]])
    np.testing.assert_allclose(accelerations(M, np.array([[[4.0], [1.0]]]))[0, :, 0], [2.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("stiff", [1.0, 1e6])
def test_a_double_zero_is_zero_and_a_slow_growth_is_growth(stiff: float):
    """A chain without ends, in coordinates turned anyhow, and a slow mode beside it."""
    rng = np.random.default_rng(4)
    K = stiff * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    T = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    chain = np.block([[np.zeros((3, 3)), np.eye(3)], [-K, np.zeros((3, 3))]])
    for growth in (1e-2, -1e-2):
        A = np.zeros((1, 7, 7))
        A[0, :6, :6], A[0, 6, 6] = T @ chain @ T.T, growth
        values = eigenvalues(A, np.zeros(1))
        assert (values == 0.0).sum() == 2
        assert grows(values).sum() == (growth > 0)
    values, vectors = eigenvectors(A, np.zeros(1))
    np.testing.assert_allclose(A @ vectors, vectors * values[:, None, :], atol=1e-6 * stiff)
