"""Correlated samples: the matrix comes back, and what is uncorrelated stays as it is."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy import stats

from lienumba.sweep.copula import MatrixError, cholesky, correlated
from lienumba.sweep.normal import inverse
from lienumba.sweep.samplers.streams import uniforms

NAMES = ["a", "b", "c"]
U = {name: uniforms(name, range(40000), 3) for name in NAMES}


def test_the_correlations_come_back_and_each_stays_uniform():
    matrix = [[1, 0.8, -0.3], [0.8, 1, 0.1], [-0.3, 0.1, 1]]
    found = correlated(U, NAMES, matrix)
    np.testing.assert_allclose(np.corrcoef([inverse(found[name]) for name in NAMES]), matrix, atol=4 / np.sqrt(40000))
    for name in NAMES:
        assert stats.kstest(found[name], "uniform").pvalue > 1e-3
    np.testing.assert_array_equal(found["a"], U["a"])


def test_ranks_have_the_correlations_of_a_gaussian_copula():
    found = correlated(U, ["a", "b"], [[1, 0.6], [0.6, 1]])
    expected = 6 / np.pi * np.arcsin(0.3)
    assert stats.spearmanr(found["a"], found["b"]).statistic == pytest.approx(expected, abs=0.02)


def test_what_is_uncorrelated_keeps_its_bits():
    found = correlated(U, NAMES, [[1, 0, 0.5], [0, 1, 0], [0.5, 0, 1]])
    np.testing.assert_array_equal(found["a"], U["a"])
    np.testing.assert_array_equal(found["b"], U["b"])
    assert (found["c"] != U["c"]).any()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_perfect_correlation_is_allowed(sign):
    found = correlated(U, ["a", "b"], [[1, sign], [sign, 1]])
    np.testing.assert_allclose(found["b"], U["a"] if sign > 0 else 1 - U["a"], atol=1e-14)


@settings(max_examples=50)
@example(5, 4, 4582)  # behind a pivot that is nearly none, rounding is large
@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_every_semi_definite_matrix_has_a_factor(size, rank, seed):
    B = np.random.default_rng(seed).normal(size=(size, rank))
    matrix = B @ B.T
    L = np.array(cholesky(matrix.tolist()))
    np.testing.assert_allclose(L @ L.T, matrix, atol=1e-4 * np.abs(matrix).max())
    assert (np.triu(L, 1) == 0).all()


@pytest.mark.parametrize(
    ("matrix", "text"),
    [
        ([[1, 0.5], [0.4, 1]], "is not symmetric: [1][0] is 0.4, but [0][1] is 0.5; give both the same value"),
        ([[1, 0.9, -0.9], [0.9, 1, 0.9], [-0.9, 0.9, 1]], "smallest eigenvalue is -0.8)"),
        ([[0, 1], [1, 0]], "is not positive semi-definite (its smallest eigenvalue is -1)"),
    ],
)
def test_other_matrices_are_refused(matrix, text):
    with pytest.raises(MatrixError) as caught:
        cholesky(matrix)
    assert text in str(caught.value)
