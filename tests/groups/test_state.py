"""The state-space group S of one body: a direct product, in which only the rotation is curved."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lienumba.groups import so3, state
from tests.groups.strategies import checked, rotation_vectors, vectors

EPS = 2.0**-52
ZERO = (0.0,) * state.ALGEBRA


@st.composite
def algebra(draw: st.DrawFn, largest: float = 3.0) -> state.Algebra:
    return (*draw(vectors), *draw(rotation_vectors(largest)), *draw(vectors), *draw(vectors))


def elements(largest: float = 30.0) -> st.SearchStrategy[state.State]:
    return algebra(largest).map(state.exp)


def distance(a, b):
    assert len(a) == len(b)
    return float(np.abs(np.array(a) - np.array(b)).max())


def ad(y, times, z):
    for _ in range(times):
        z = state.bracket(y, z)
    return z


@checked
@given(elements(), elements(), elements())
def test_elements_form_a_group(x, y, z):
    assert len(x) == state.ELEMENT
    left, right = state.product(state.product(x, y), z), state.product(x, state.product(y, z))
    assert distance(left, right) < 32 * EPS
    assert state.product(x, state.IDENTITY) == pytest.approx(x, abs=0.0)
    assert state.product(state.IDENTITY, x) == pytest.approx(x, abs=0.0)
    assert distance(state.product(x, state.inverse(x)), state.IDENTITY) < 8 * EPS
    assert distance(state.product(state.inverse(x), x), state.IDENTITY) < 8 * EPS


@checked
@given(elements(), elements())
def test_the_product_is_that_of_its_four_parts(x, y):
    z = state.product(x, y)
    assert z[0:3] == so3.add(x[0:3], y[0:3])
    assert z[3:12] == so3.multiply(x[3:12], y[3:12])
    assert z[12:15] == so3.add(x[12:15], y[12:15])
    assert z[15:18] == so3.add(x[15:18], y[15:18])


@checked
@given(algebra())
def test_exp_and_log(z):
    x = state.exp(z)
    assert x == (*z[0:3], *so3.exp(z[3:6]), *z[6:12])
    assert distance(state.log(x), z) < 16 * EPS
    assert distance(state.product(x, state.exp(tuple(-c for c in z))), state.IDENTITY) < 8 * EPS


@checked
@given(algebra(), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_exp_of_multiples_is_a_subgroup(z, s, t):
    def along(r):
        return state.exp(tuple(r * c for c in z))

    assert distance(state.product(along(s), along(t)), along(s + t)) < 64 * EPS


@checked
@given(algebra(), algebra(), algebra(), st.floats(-3.0, 3.0))
def test_the_bracket_makes_a_lie_algebra(x, y, z, s):
    assert len(state.bracket(x, y)) == state.ALGEBRA
    assert distance(state.bracket(x, y), tuple(-c for c in state.bracket(y, x))) == 0.0
    assert not any(state.bracket(x, x))
    line = tuple(s * a + b for a, b in zip(y, z, strict=True))
    expected = tuple(s * a + b for a, b in zip(state.bracket(x, y), state.bracket(x, z), strict=True))
    assert distance(state.bracket(x, line), expected) < 1e-13
    jacobi = zip(
        state.bracket(x, state.bracket(y, z)),
        state.bracket(y, state.bracket(z, x)),
        state.bracket(z, state.bracket(x, y)),
        strict=True,
    )
    assert max(abs(sum(terms)) for terms in jacobi) < 1e-12


@checked
@given(algebra(), algebra())
def test_the_bracket_is_the_commutator_of_small_motions(y, z):
    """exp(ty) exp(tz) exp(-ty) exp(-tz) = exp(t^2 [y, z] + O(t^3))."""
    t = 1e-5
    a, b = (tuple(t * c for c in v) for v in (y, z))
    a_back, b_back = (tuple(-c for c in v) for v in (a, b))
    x = state.exp(a)
    for v in (b, a_back, b_back):
        x = state.product(x, state.exp(v))
    size = 1.0 + max(map(abs, (*y, *z)))
    assert distance(tuple(c / t**2 for c in state.log(x)), state.bracket(y, z)) < 1e-3 * size**3


@checked
@given(algebra(1.0), algebra())
def test_dexp_and_its_inverse_are_their_series(z, y):
    forward = np.sum([np.array(ad(z, j, y)) / math.factorial(j + 1) for j in range(20)], axis=0)
    assert distance(state.dexp(z, y), forward) < 1e-14 * 10
    assert distance(state.dexpinv_truncated(z, y, 10), state.dexpinv(z, y)) < 1e-8
    second = np.array(y) - np.array(ad(z, 1, y)) / 2 + np.array(ad(z, 2, y)) / 12
    assert distance(state.dexpinv_truncated(z, y, 2), second) < 1e-14 * 10


@checked
@given(algebra(5.0), algebra())
def test_dexpinv_inverts_dexp(z, y):
    assert distance(state.dexpinv(z, state.dexp(z, y)), y) < 1e-12


@checked
@given(algebra(3.0), algebra())
def test_dexp_is_the_derivative_of_exp(z, y):
    """exp(z + t y) = exp(t dexp_z(y)) exp(z) + O(t^2)."""
    t = 1e-5
    ahead, behind = (state.exp(tuple(a + s * t * b for a, b in zip(z, y, strict=True))) for s in (1.0, -1.0))
    motion = state.log(state.product(ahead, state.inverse(behind)))
    size = 1.0 + max(map(abs, y))
    assert distance(tuple(c / (2 * t) for c in motion), state.dexp(z, y)) < 1e-7 * size**3


def test_zero_changes_no_bit():
    y = tuple(0.3 + 0.7 * i for i in range(state.ALGEBRA))
    x = state.exp(y)
    assert state.exp(ZERO) == state.IDENTITY
    assert state.product(x, state.exp(ZERO)) == x
    assert state.log(state.IDENTITY) == ZERO
    for function in (state.dexp, state.dexpinv, lambda z, y: state.dexpinv_truncated(z, y, 10)):
        assert function(ZERO, y) == y
