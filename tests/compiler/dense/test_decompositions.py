"""Decompositions of our own against NumPy's; what is wrong with one run touches no other."""

import mpmath as mp
import numpy as np
import pytest

from lienumba.compiler.dense.decompositions import (
    Rows,
    accelerations,
    beyond_rounding,
    eigenvalues,
    eigenvectors,
    growing,
    product,
    solved,
    symmetric,
    turned,
)

RANDOM = np.random.default_rng(5)
TINY = 1e-12


def test_rows_say_their_rank_and_what_they_leave_free() -> None:
    C = RANDOM.normal(size=(4, 5, 8))
    C[1, 3] = C[1, 0] - 2 * C[1, 1]
    C[2] = 0.0
    C[3, 0] *= 1e5
    rows = Rows.of(C, 1e-9)
    assert rows.rank.tolist() == np.linalg.matrix_rank(C, rtol=1e-9).tolist() == [5, 4, 0, 5]
    np.testing.assert_allclose(product(turned(rows.Q), rows.Q), np.broadcast_to(np.eye(8), (4, 8, 8)), atol=1e-14)
    b = product(C, RANDOM.normal(size=(4, 8)))
    np.testing.assert_allclose(rows.least(b), (np.linalg.pinv(C) @ b[:, :, None])[:, :, 0], atol=1e-10)
    g = product(turned(C), RANDOM.normal(size=(4, 5)))
    mu = rows.multipliers(product(turned(rows.Q), g))
    np.testing.assert_allclose(product(turned(C), mu), g, rtol=1e-9, atol=1e-9)
    assert Rows.of(C, 1e-9, np.array([2, 2, 2, 2])).rank.tolist() == [2, 2, 0, 2]


def test_what_rows_do_not_touch_is_mixed_with_nothing() -> None:
    """Coordinates that stand first, in the middle and last stay as they are, wherever Q has them."""
    C, apart = RANDOM.normal(size=(2, 3, 8)), [0, 3, 7]
    C[:, :, apart] = 0.0
    Q = Rows.of(C, 1e-9).Q
    for column in apart:
        assert (np.sort(np.abs(Q[:, column]), axis=1) == np.eye(8)[7]).all()
    np.testing.assert_allclose(product(C, Q)[:, :, 3:], 0.0, atol=1e-14)


@pytest.mark.parametrize("seed", range(20))
def test_accelerations_of_light_bodies_beside_heavy_ones_are_as_exact(seed: int) -> None:
    """A chain of masses from 1e-9 to 1e9 kg against mpmath; each acceleration is exact beside its own size."""
    rng = np.random.default_rng(seed)
    L = np.tril(rng.uniform(-1.0, 1.0, (6, 6)))
    np.fill_diagonal(L, rng.uniform(1.0, 2.0, 6))
    sizes = 10.0 ** rng.uniform(-9, 9, 6)
    M = np.sqrt(sizes)[:, None] * (L @ L.T) * np.sqrt(sizes)
    b = np.sqrt(sizes) * rng.normal(size=6)
    with mp.workdps(50):
        exact = np.array([float(x) for x in mp.lu_solve(mp.matrix(M.tolist()), mp.matrix(b.tolist()))])
    found = accelerations(M[None], b[None], np.zeros(1, np.int64), TINY)[0]
    np.testing.assert_allclose(found * np.sqrt(sizes), exact * np.sqrt(sizes), atol=1e-12)


def test_systems_are_solved_from_a_row_on_and_dependent_columns_are_0() -> None:
    A, b = RANDOM.normal(size=(3, 6, 6)), RANDOM.normal(size=(3, 6, 2))
    first = np.array([0, 2, 6])
    A[0, :, 4] = A[0, :, 1]
    b[0] = A[0] @ RANDOM.normal(size=(6, 2))
    x = solved(A, b, first, TINY)
    np.testing.assert_allclose(A[0] @ x[0], b[0], atol=1e-10)
    assert not x[0, 4].any() or not x[0, 1].any()
    np.testing.assert_allclose(x[1, 2:], np.linalg.solve(A[1, 2:, 2:], b[1, 2:]), rtol=1e-10)
    assert not x[1, :2].any()
    assert not x[2].any()
    S = A + turned(A)
    own, V = symmetric(S, first)
    np.testing.assert_allclose(np.sort(own[1, 2:]), np.linalg.eigvalsh(S[1, 2:, 2:]), atol=1e-13)
    assert np.isnan(own[1, :2]).all()
    np.testing.assert_allclose(S[1, 2:, 2:] @ V[1, 2:, 2:], V[1, 2:, 2:] * own[1, 2:], atol=1e-13)
    np.testing.assert_allclose(turned(V) @ V, np.broadcast_to(np.eye(6), V.shape), atol=1e-14)
    np.testing.assert_array_equal(V[1, :2], np.eye(6)[:2])


@pytest.mark.parametrize("n", [1, 2, 3, 9, 20])
def test_eigenvalues_are_those_of_numpy(n: int) -> None:
    A = RANDOM.normal(size=(20, n, n))
    A[1], A[2] = 0.0, np.eye(n)
    A[3] *= np.logspace(-8, 8, n)[:, None]
    A[4] = np.roll(np.eye(n), 1, axis=0)  # whose usual shifts go round in circles
    A[5] = -(A[5] @ A[5].T) * 1e9  # stiff
    found, expected = eigenvalues(A), np.linalg.eigvals(A)
    for own, others, matrix in zip(found, expected, A, strict=True):
        left = list(own)
        for x in others:
            nearest = int(np.argmin(np.abs(np.array(left) - x)))
            assert abs(left.pop(nearest) - x) <= 1e-11 * max(np.abs(matrix).max(), 1e-300)


def test_redundant_rows_have_the_least_multipliers() -> None:
    C = RANDOM.normal(size=(2, 4, 6))
    C[:, 3] = C[:, 0] + 0.5 * C[:, 2]
    g = product(turned(C), RANDOM.normal(size=(2, 4, 3)))
    expected = np.linalg.pinv(turned(C)) @ g
    np.testing.assert_allclose(Rows.of(C, 1e-9).least_multipliers(g), expected, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(Rows.of(C, 1e-9).least_multipliers(g[:, :, 1]), expected[:, :, 1], atol=1e-12)


STIFFNESSES = np.diag([1e-4, 1.0, 1e2, 1e8])
MATRICES = {
    "any": RANDOM.normal(size=(12, 12)),
    "scaled": RANDOM.normal(size=(12, 12)) * 10.0 ** (np.arange(12)[:, None] - np.arange(12)),
    "repeated": np.kron(np.eye(3), RANDOM.normal(size=(2, 2))),
    "oscillators": np.block([[np.zeros((4, 4)), np.eye(4)], [-STIFFNESSES, np.zeros((4, 4))]]),
    "triangular": np.triu(RANDOM.normal(size=(7, 7))),
    "zero": np.zeros((5, 5)),
    "number": np.array([[-3.5]]),
    "saddle": np.array([[1.0, 2.0], [2.0, 1.0]]),
}


@pytest.mark.parametrize("A", MATRICES.values(), ids=MATRICES.keys())
def test_eigenvalues_and_vectors_are_those_of_exact_arithmetic(A: np.ndarray) -> None:
    with mp.workdps(40):
        exact = [complex(x) for x in mp.eig(mp.matrix(A.tolist()), left=False, right=False)]
    (values,), (vectors,) = eigenvectors(A[None])
    assert values.tobytes() == eigenvalues(A[None]).tobytes()
    left = list(values)
    for x in exact:
        assert abs(left.pop(int(np.argmin(np.abs(np.array(left) - x)))) - x) <= 1e-11 * abs(x)
    pairs = values.imag > 0.0
    Z = vectors + 1j * np.where(pairs, np.roll(vectors, -1, axis=1), 0.0)
    for value, z in zip(values, Z.T, strict=True):
        if value.imag >= 0.0:
            assert np.linalg.norm(A @ z - value * z) <= 1e-13 * np.linalg.norm(A) * np.linalg.norm(z)
            assert np.linalg.norm(z) > 0.0


def test_a_large_matrix_has_the_eigenvalues_of_its_closed_form() -> None:
    n = 60
    A = 0.5 * np.eye(n) + 1.1 * np.diag(np.ones(n - 1), 1) - np.diag(np.ones(n - 1), -1)
    (values,), (vectors,) = eigenvectors(A[None])
    exact = 2.0 * np.sqrt(1.1) * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))
    np.testing.assert_allclose(values.real, 0.5, rtol=1e-12)
    np.testing.assert_allclose(np.sort(values.imag), np.sort(exact), rtol=1e-12)
    first = np.flatnonzero(values.imag > 0.0)
    Z = vectors[:, first] + 1j * vectors[:, first + 1]
    np.testing.assert_allclose(A @ Z, Z * values[first], atol=1e-12 * np.abs(Z).max())


def test_a_defective_matrix_has_vectors_that_are_finite() -> None:
    A = 2.0 * np.eye(6) + np.diag(np.ones(5), 1)
    A[3:, 3:] = 0.0
    A[3, 4] = A[4, 5] = 1.0
    (values,), (vectors,) = eigenvectors(A[None])
    np.testing.assert_allclose(np.sort(values.real), [0, 0, 0, 2, 2, 2], atol=1e-15)
    unit = vectors / np.linalg.norm(vectors, axis=0)
    np.testing.assert_allclose(A @ unit, unit * values.real, atol=1e-14)


def test_a_run_does_not_see_its_neighbours() -> None:
    A = RANDOM.normal(size=(6, 7, 7))
    alone = [(eigenvectors(A[n : n + 1]), Rows.of(A[n : n + 1, :4], 1e-9).Q) for n in range(6)]
    A[2, 3, 3] = np.nan
    A[4, 1, 1] = np.inf
    (values, vectors), Q = eigenvectors(A), Rows.of(A[:, :4], 1e-9).Q
    x = solved(A, A[:, :, 0], np.zeros(6, np.int64), TINY)
    for n in (0, 1, 3, 5):
        assert (values[n].tobytes(), vectors[n].tobytes()) == tuple(x[0].tobytes() for x in alone[n][0])
        assert Q[n].tobytes() == alone[n][1].tobytes()
        assert np.isfinite(x[n]).all()
    assert np.isnan(values[[2, 4]]).all()
    assert not np.isfinite(x[[2, 4]]).all(axis=1).any()


def turned_by(similar: np.ndarray, seed: int) -> np.ndarray:
    S = np.linalg.qr(np.random.default_rng(seed).normal(size=similar.shape))[0]
    found: np.ndarray = S @ similar @ S.T
    return found


@pytest.mark.parametrize("seed", range(40))
def test_what_drifts_on_a_circle_does_not_grow_by_rounding_and_slow_growth_is_told(seed: int) -> None:
    """i w twice, with one vector: rounding makes of these i w +- sqrt(rounding)."""
    w = 0.5
    circle = np.array([[0.0, -w], [w, 0.0]])
    drifts = np.block([[circle, np.eye(2)], [np.zeros((2, 2)), circle]])
    both = np.block([[drifts, np.zeros((4, 4))], [np.zeros((4, 4)), 10.0 * drifts]])
    slow = np.block([[circle + 3e-7 * np.eye(2), np.zeros((2, 2))], [np.zeros((2, 2)), circle]])
    for matrix, grows in ((drifts, False), (both, False), (slow, True)):
        A = turned_by(matrix, seed)[None]
        found, zero = beyond_rounding(
            A,
            eigenvalues(A),
            slice(0, len(matrix)),
            np.ones(1),
            lambda which, A=A: (np.broadcast_to(np.eye(A.shape[1]), A[which].shape), np.full(A[which].shape, 1e-14)),
        )
        assert growing(found).any() == grows
        assert not zero.any()
