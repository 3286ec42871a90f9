"""SE(3) on floats: the axioms, and exp, log, dexp and dexpinv against 4x4 matrices in mpmath at every angle."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.linalg import expm

from lienumba.groups import se3, so3
from tests.groups import oracles
from tests.groups.strategies import angles, checked, rotation_vectors, twists, vectors

EPS = 2.0**-52
FULL_TURN = 2.0 * math.pi
ZERO = (0.0,) * 6


def distance(a, b):
    assert len(a) == len(b)
    return float(np.abs(np.array(a) - np.array(b)).max())


def square(z):
    """The 4x4 matrix of a twist."""
    S = np.zeros((4, 4))
    S[:3, :3], S[:3, 3] = np.reshape(so3.hat(z[3:6]), (3, 3)), z[0:3]
    return S


def of_square(S):
    return (*S[:3, 3], S[2, 1], S[0, 2], S[1, 0])


def homogeneous(a):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.reshape(a[3:12], (3, 3)), a[0:3]
    return T


def exact_exp(z):
    """The motion by a twist in mpmath, a 4x4 matrix: with S^4 = -angle^2 S^2, exp S = 1 + S + b S^2 + d S^3."""
    t = oracles.angle(z[3:6])
    if t < mpmath.mpf(10) ** -20:
        b, d = mpmath.mpf(1) / 2, mpmath.mpf(1) / 6
    else:
        b, d = (1 - mpmath.cos(t)) / t**2, (t - mpmath.sin(t)) / t**3
    S = mpmath.zeros(4)
    hat = oracles.hat(z[3:6])
    for i in range(3):
        S[i, 3] = z[i]
        for j in range(3):
            S[i, j] = hat[i, j]
    return mpmath.eye(4) + S + b * S**2 + d * S**3


def exact_dexp(z, y):
    """(d/dt exp(z + t y)) exp(z)^-1 at t = 0."""
    with mpmath.workdps(oracles.DIGITS):
        a, b, t = oracles.vector(z), oracles.vector(y), mpmath.mpf(10) ** -16
        S = (exact_exp(list(a + t * b)) - exact_exp(list(a - t * b))) / (2 * t) * exact_exp(list(a)) ** -1
        return [float(x) for x in (S[0, 3], S[1, 3], S[2, 3], S[2, 1], S[0, 2], S[1, 0])]


# ---------------------------------------------------------------- the group and its algebra
@checked
@given(twists(), twists(), twists(), vectors)
def test_motions_form_a_group(x, y, z, p):
    a, b, c = se3.exp(x), se3.exp(y), se3.exp(z)
    size = 1.0 + max(map(abs, (*a, *b, *c)))
    assert distance(se3.product(se3.product(a, b), c), se3.product(a, se3.product(b, c))) < 64 * EPS * size
    assert se3.product(a, se3.IDENTITY) == pytest.approx(a, abs=0.0)
    assert distance(se3.product(a, se3.inverse(a)), se3.IDENTITY) < 32 * EPS * size
    assert distance(se3.product(se3.inverse(a), a), se3.IDENTITY) < 32 * EPS * size
    assert np.abs(homogeneous(se3.product(a, b)) - homogeneous(a) @ homogeneous(b)).max() < 32 * EPS * size


@checked
@given(twists(), twists(), twists())
def test_the_bracket_is_the_commutator(x, y, z):
    X, Y = square(x), square(y)
    size = 1e3 * (1.0 + max(map(abs, (*x, *y, *z)))) ** 3
    assert distance(se3.bracket(x, y), of_square(X @ Y - Y @ X)) < EPS * size
    jacobi = [se3.bracket(a, se3.bracket(b, c)) for a, b, c in ((x, y, z), (y, z, x), (z, x, y))]
    assert np.abs(np.sum(jacobi, axis=0)).max() < EPS * size


# ---------------------------------------------------------------- exp and log
@checked
@given(twists())
@example((1.0, 2.0, 3.0, 0.0, 0.0, 0.0))
def test_exp_is_exact_at_every_angle(z):
    with mpmath.workdps(oracles.DIGITS):
        T = exact_exp(list(oracles.vector(z)))
        exact = [float(T[i, 3]) for i in range(3)] + [float(T[i, j]) for i in range(3) for j in range(3)]
    assert distance(se3.exp(z), exact) < 8 * EPS * (1.0 + math.hypot(*z[3:6])) * (1.0 + math.hypot(*z[0:3]))


def test_the_oracle_is_the_matrix_exponential():
    z = (0.3, -2.0, 0.8, 0.7, -1.9, 2.4)
    with mpmath.workdps(30):
        exact = np.array(exact_exp(list(oracles.vector(z))).tolist(), float)
    assert np.abs(exact - expm(square(z))).max() < 1e-14


@checked
@given(twists(), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_exp_of_multiples_is_a_subgroup(z, s, t):
    a, b, both = (se3.exp(tuple(r * c for c in z)) for r in (s, t, s + t))
    assert distance(se3.product(a, b), both) < 64 * EPS * (1.0 + math.hypot(*z[3:6])) * (1.0 + math.hypot(*z[0:3]))


@checked
@given(twists(3.1))
def test_log_inverts_exp_up_to_half_a_turn(z):
    """Beside half a turn the logarithm is as ill-conditioned as the sign of its axis."""
    gap = math.pi - math.hypot(*z[3:6])
    assert distance(se3.log(se3.exp(z)), z) < 64 * EPS * (1.0 + math.hypot(*z[0:3])) / min(gap, 1.0)


@checked
@given(twists(200.0))
def test_exp_of_log_is_the_motion(z):
    a = se3.exp(z)
    assert distance(se3.exp(se3.log(a)), a) < 64 * EPS * (1.0 + math.hypot(*z[0:3]))


# ---------------------------------------------------------------- dexp and its inverse
@checked
@given(twists(20.0), twists())
def test_dexp_is_the_derivative_of_exp(z, y):
    size = (1.0 + math.hypot(*z)) * (1.0 + math.hypot(*y))
    assert distance(se3.dexp(z, y), exact_dexp(z, y)) < 32 * EPS * size**2


@checked
@given(twists(40.0), twists())
def test_dexpinv_inverts_dexp(z, y):
    angle = math.hypot(*z[3:6])
    gap = abs(math.remainder(angle, FULL_TURN)) if angle > math.pi else 1.0
    if gap < 1e-4:
        return  # singular there
    size = (1.0 + math.hypot(*z)) * (1.0 + math.hypot(*y))
    assert distance(se3.dexpinv(z, se3.dexp(z, y)), y) < 32 * EPS * size**2 / gap**2


@pytest.mark.parametrize("order", range(11))
def test_truncated_dexpinv_is_bernoullis_series(order):
    z, y = (0.4, -0.2, 0.9, 0.3, 0.5, -0.2), (1.0, 2.0, -0.7, 0.3, -0.4, 1.1)
    term, total = np.array(y), np.zeros(6)
    for j in range(order + 1):
        total += float(mpmath.bernoulli(j) / mpmath.factorial(j)) * term
        term = np.array(se3.bracket(z, tuple(term)))
    assert distance(se3.dexpinv_truncated(z, y, order), total) < 1e-14
    if order == 10:
        assert distance(se3.dexpinv(z, y), total) < 1e-8


@checked
@given(rotation_vectors(6.0), vectors, vectors)
def test_rotations_are_those_of_so3(u, p, w):
    """What turns is that of SO(3) whatever shifts, and a pure shift adds up."""
    z = (*p, *u)
    assert se3.exp(z)[3:12] == so3.exp(u)
    assert se3.exp((*p, 0.0, 0.0, 0.0)) == (*p, *so3.IDENTITY)
    assert distance(se3.dexpinv(z, (*p, *w))[3:6], so3.dexpinv(u, w)) < 1e-12 * (1.0 + max(map(abs, so3.dexpinv(u, w))))


def test_zero_changes_no_bit():
    y = (0.1, -7.3, 1e-5, 0.3, 2.0, -0.4)
    a = se3.exp(y)
    assert se3.exp(ZERO) == se3.IDENTITY
    assert se3.log(se3.IDENTITY) == ZERO
    assert se3.product(a, se3.exp(ZERO)) == a
    for function in (se3.dexp, se3.dexpinv, lambda z, y: se3.dexpinv_truncated(z, y, 10)):
        assert function(ZERO, y) == y


# ---------------------------------------------------------------- the derivatives of the coefficients
def derivative(f, x):
    """Of f(angle) by angle**2; beside 0, where f is 0/0 and its derivative constant, a little farther out."""
    with mpmath.workdps(150):
        at, h = mpmath.mpf(max(x, 1e-20)), mpmath.mpf(10) ** -40
        ahead, behind = (f(mpmath.sqrt(at + s)) for s in (h, -h))
        return float((ahead - behind) / (2 * h))


@checked
@given(angles(6.0))
@example(0.0)
@example(math.sqrt(2.0))  # where the series end
def test_derivatives_of_the_dexp_coefficients(angle):
    x = angle * angle
    b, d = se3._dexp_derivatives(x)
    assert b == pytest.approx(derivative(lambda t: (1 - mpmath.cos(t)) / t**2, x), abs=EPS / 4)
    assert d == pytest.approx(derivative(lambda t: (t - mpmath.sin(t)) / t**3, x), abs=EPS / 4)


@checked
@given(angles(6.2))
@example(0.0)
@example(1.0)  # where its series ends
@example(6.0)  # where the polynomials of so3 end
def test_derivative_of_the_dexpinv_coefficient(angle):
    x = angle * angle
    exact = derivative(lambda t: (1 - t / 2 * mpmath.cot(t / 2)) / t**2, x)
    assert se3._dexpinv_derivative(x) == pytest.approx(exact, abs=EPS / min(FULL_TURN - angle, 1.0) ** 3 / 2)
