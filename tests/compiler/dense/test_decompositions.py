"""Decompositions of our own against NumPy's; what is wrong with one run touches no other."""

import numpy as np
import pytest

from lienumba.compiler.dense.decompositions import Rows, eigenvalues, product, solved, symmetric_values, turned

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
    own = symmetric_values(S, first)
    np.testing.assert_allclose(np.sort(own[1, 2:]), np.linalg.eigvalsh(S[1, 2:, 2:]), atol=1e-13)
    assert np.isnan(own[1, :2]).all()


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


def test_a_run_does_not_see_its_neighbours() -> None:
    A = RANDOM.normal(size=(6, 7, 7))
    alone = [(eigenvalues(A[n : n + 1]), Rows.of(A[n : n + 1, :4], 1e-9).Q) for n in range(6)]
    A[2, 3, 3] = np.nan
    A[4, 1, 1] = np.inf
    values, Q = eigenvalues(A), Rows.of(A[:, :4], 1e-9).Q
    x = solved(A, A[:, :, 0], np.zeros(6, np.int64), TINY)
    for n in (0, 1, 3, 5):
        assert values[n].tobytes() == alone[n][0].tobytes()
        assert Q[n].tobytes() == alone[n][1].tobytes()
        assert np.isfinite(x[n]).all()
    assert np.isnan(values[[2, 4]]).all()
    assert not np.isfinite(x[[2, 4]]).all(axis=1).any()
