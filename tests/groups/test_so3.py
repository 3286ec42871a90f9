"""SO(3) on floats: the axioms, and exp, log, dexp and dexpinv against mpmath at every angle."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lienumba.groups import so3
from tests.groups import oracles
from tests.groups.strategies import angles, checked, rotation_vectors, vectors

EPS = 2.0**-52
FULL_TURN = 2.0 * math.pi


def matrix(R):
    return np.array(R).reshape(3, 3)


def distance(a, b):
    return float(np.abs(np.array(a) - np.array(b)).max())


# ---------------------------------------------------------------- algebra and matrices
@checked
@given(vectors, vectors, rotation_vectors(), rotation_vectors())
def test_vectors_and_matrices_are_those_of_numpy(a, b, u, w):
    A, B = so3.exp(u), so3.exp(w)
    assert so3.cross(a, b) == pytest.approx(np.cross(a, b), abs=1e-13)
    assert so3.dot(a, b) == pytest.approx(np.dot(a, b), abs=1e-13)
    assert so3.axpy(3.0, a, b) == pytest.approx(3.0 * np.array(a) + b, abs=1e-13)
    assert so3.subtract(so3.add(a, b), b) == pytest.approx(a, abs=1e-14)
    assert so3.rotate(A, a) == pytest.approx(matrix(A) @ a, abs=1e-13)
    assert so3.rotate_back(A, a) == pytest.approx(matrix(A).T @ a, abs=1e-13)
    assert distance(matrix(so3.multiply(A, B)), matrix(A) @ matrix(B)) < 1e-14
    assert distance(matrix(so3.transpose(A)), matrix(A).T) == 0.0
    assert so3.rotate(so3.hat(a), b) == pytest.approx(np.cross(a, b), abs=1e-13)
    assert so3.vee(so3.hat(a)) == pytest.approx(a, abs=0.0)


@checked
@given(rotation_vectors(), rotation_vectors(), rotation_vectors())
@example((0.0, 0.0, 3.5), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
def test_rotations_form_a_group(a, b, c):
    A, B, C = so3.exp(a), so3.exp(b), so3.exp(c)
    assert distance(so3.multiply(so3.multiply(A, B), C), so3.multiply(A, so3.multiply(B, C))) < 8 * EPS
    assert so3.multiply(A, so3.IDENTITY) == pytest.approx(A, abs=0.0)
    assert distance(so3.multiply(A, so3.transpose(A)), so3.IDENTITY) < 16 * EPS  # 13 between 3 and 4 rad
    assert np.linalg.det(matrix(A)) == pytest.approx(1.0, abs=16 * EPS)


# ---------------------------------------------------------------- exp and log
@checked
@given(rotation_vectors(200.0))
@example((1e5, -3e4, 2e3))
@example((0.0, 0.0, 6.0))
@example((0.0, math.nextafter(6.0, 0.0), 0.0))
def test_exp_is_exact_at_every_angle(u):
    assert distance(so3.exp(u), oracles.exp(u)) < 3 * EPS * (1.0 + math.hypot(*u))


def test_the_oracle_is_the_matrix_exponential():
    u = (0.7, -1.9, 2.4)
    with mpmath.workdps(30):
        series = mpmath.expm(oracles.hat(oracles.vector(u)), method="taylor")
        assert mpmath.mnorm(series - oracles.rotation(oracles.vector(u)), 1) < 1e-25


@checked
@given(rotation_vectors(1e-3))
def test_exp_keeps_the_relative_accuracy_of_small_rotations(u):
    """The skew part alone is u, to the last place: no 1 stands beside it."""
    skew = so3.vee(so3.exp(u))
    with mpmath.workdps(oracles.DIGITS):
        R = oracles.rotation(oracles.vector(u))
        exact = [float((R[2, 1] - R[1, 2]) / 2), float((R[0, 2] - R[2, 0]) / 2), float((R[1, 0] - R[0, 1]) / 2)]
    for got, want, other in zip(skew, exact, u, strict=True):
        assert abs(got - want) <= 4 * EPS * abs(other) + 1e-16 * math.hypot(*u) ** 2


@checked
@given(rotation_vectors(math.pi))
def test_log_inverts_exp_up_to_half_a_turn(u):
    v = so3.log(so3.exp(u))
    assert math.hypot(*v) <= math.pi * (1 + EPS)
    if math.pi - math.hypot(*u) < 1e-14:  # either sign is the logarithm there
        v = min(v, so3.scale(-1.0, v), key=lambda w: distance(w, u))
    assert distance(v, u) < 8 * EPS * max(math.hypot(*u), 1e-300) + 4 * EPS * (math.hypot(*u) > 1e-3)


@checked
@given(rotation_vectors(1e3))
def test_exp_of_log_is_the_rotation(u):
    R = so3.exp(u)
    assert distance(so3.exp(so3.log(R)), R) < 8 * EPS


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0.6, 0.8), (0.6, 0, -0.8), (-0.48, 0.6, 0.64)])
def test_log_of_an_exact_half_turn(axis):
    a = np.array(axis, float)
    u = np.array(so3.log(tuple((2.0 * np.outer(a, a) - np.eye(3)).ravel().tolist())))
    assert min(distance(u, math.pi * a), distance(u, -math.pi * a)) < 8 * EPS


# ---------------------------------------------------------------- u = 0 is a no-op
def test_zero_changes_no_bit():
    zero = (0.0, 0.0, 0.0)
    w = (0.1, -7.3, 1e-5)
    R = so3.exp((0.3, -0.2, 0.9))
    assert so3.exp(zero) == so3.IDENTITY
    assert so3.exp((-0.0, 0.0, -0.0)) == so3.IDENTITY
    assert so3.log(so3.IDENTITY) == zero
    assert so3.multiply(R, so3.exp(zero)) == R
    for function in (so3.dexp, so3.dexpinv, lambda u, w: so3.dexpinv_truncated(u, w, 10)):
        assert function(zero, w) == w


# ---------------------------------------------------------------- the coefficients
def _relative(value: float, exact) -> float:
    return float(abs(mpmath.mpf(value) - exact) / abs(exact))


@checked
@given(angles(6.0))
@example(0.0)
@example(math.sqrt(2.0))  # where the series of the second coefficient ends
def testdexp_coefficients_do_not_cancel(angle):
    x = angle * angle
    b, d = so3.dexp_coefficients(x)
    with mpmath.workdps(200):
        exact = oracles.of_square(lambda t: 2 * mpmath.sin(t / 2) ** 2 / t**2, x)
        assert _relative(b, exact) < 16 * EPS * FULL_TURN / (FULL_TURN - angle)  # it has a zero at 2 pi
        assert _relative(d, oracles.of_square(lambda t: (t - mpmath.sin(t)) / t**3, x)) < 8 * EPS


@checked
@given(angles(FULL_TURN))
@example(0.0)
@example(1.0)  # where its series ends
@example(6.0)  # where the polynomials end
@example(FULL_TURN - 1e-3)
@example(FULL_TURN - 1e-9)
def test_dexpinv_coefficient_up_to_a_full_turn(angle):
    """Beside 2 pi it is as ill-conditioned as its own argument, no worse."""
    x = angle * angle
    with mpmath.workdps(200):
        exact = oracles.of_square(lambda t: (1 - t / 2 * mpmath.cot(t / 2)) / t**2, x)
        assert _relative(so3.dexpinv_coefficient(x), exact) < 16 * EPS * (1 + FULL_TURN / (1e-15 + FULL_TURN - angle))


@checked
@given(angles(300.0))
def test_half_angle_is_exact_at_every_angle(angle):
    x = angle * angle
    c, s = so3.half_angle(x)
    with mpmath.workdps(200):
        assert abs(c - oracles.of_square(lambda t: mpmath.cos(t / 2), x)) < EPS * (1.0 + 0.5 * angle)
        assert abs(s - oracles.of_square(lambda t: mpmath.sin(t / 2) / (t / 2), x)) < 2 * EPS


# ---------------------------------------------------------------- dexp and its inverse
@checked
@given(rotation_vectors(20.0), vectors)
def test_dexp_is_the_derivative_of_exp(u, w):
    """d/dt exp(u + t w) = hat(dexp_u(w)) exp(u)."""
    assert distance(so3.dexp(u, w), oracles.trivialised_derivative(u, w)) < 1e-14 * (1.0 + math.hypot(*u)) * 10.0


@checked
@given(rotation_vectors(40.0), vectors)
def test_dexpinv_inverts_dexp(u, w):
    gap = abs(math.remainder(math.hypot(*u), FULL_TURN)) if math.hypot(*u) > math.pi else 1.0
    if gap < 1e-6:
        return  # singular there
    back = so3.dexpinv(u, so3.dexp(u, w))
    assert distance(back, w) < 1e-13 * (1.0 + math.hypot(*u)) ** 2 / gap


def test_dexpinv_explodes_at_a_full_turn_only():
    w = (1.0, 2.0, 3.0)
    assert math.hypot(*so3.dexpinv((0.0, 0.0, FULL_TURN), w)) > 1e14
    assert math.hypot(*so3.dexpinv((0.0, 0.0, 3.0 * math.pi), w)) < 30.0


@pytest.mark.parametrize("order", range(11))
def test_truncated_dexpinv_has_bernoullis_coefficients(order):
    """ad_u rotates the plane across u: with u = (0, 0, 1) the series can be read off."""
    ad = (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)  # ad^j of the x axis
    with mpmath.workdps(30):
        terms = [mpmath.bernoulli(j) / mpmath.factorial(j) for j in range(order + 1)]
        exact = [float(sum(t * ad[j % 4][i] for j, t in enumerate(terms))) for i in (0, 1)]
    got = so3.dexpinv_truncated((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), order)
    assert got == pytest.approx((*exact, 0.0), abs=1e-15)


@pytest.mark.parametrize(("order", "exponent"), [(0, 1), (1, 2), (2, 4), (4, 6), (6, 8), (8, 10)])
def test_truncated_dexpinv_converges_to_the_closed_form(order, exponent):
    u, w = (0.5, -0.3, 0.4), (1.0, 2.0, -0.7)
    errors = []
    for scale in (1.0, 0.5):
        v = so3.scale(scale, u)
        errors.append(distance(so3.dexpinv_truncated(v, w, order), so3.dexpinv(v, w)))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(exponent, abs=0.15)


# ---------------------------------------------------------------- quaternions
@checked
@given(rotation_vectors(), st.floats(1e-3, 1e3), st.sampled_from([1.0, -1.0]))
def test_a_quaternion_of_any_length_and_sign_gives_its_rotation(u, length, sign):
    half = 0.5 * math.hypot(*u)
    axis = so3.scale(1.0 / math.hypot(*u), u) if half > 1e-300 else (1.0, 0.0, 0.0)
    q = tuple(sign * length * x for x in (math.cos(half), *so3.scale(math.sin(half), axis)))
    assert distance(so3.from_quaternion(q), so3.exp(u)) < 8 * EPS * (1.0 + half)


unit = st.sampled_from([0.0, 1.0, -1.0, 1e-9, 0.5]) | st.floats(-1.0, 1.0)


@checked
@given(st.tuples(unit, unit, unit, unit).filter(lambda q: math.hypot(*q) > 1e-3))
@example((0.0, 1.0, 1.0, 0.0))
@example((0.0, 0.0, 0.0, -3.0))
@example((0.0, 1.0, -1.0, 1.0))
@example((1e-17, 0.6, 0.0, 0.8))
def test_quaternions_survive_the_way_through_a_matrix(q):
    """Half turns (w = 0) included: there either sign may come back."""
    unit_q = np.array(q) / math.hypot(*q)
    back = np.array(so3.to_quaternion(so3.from_quaternion(q)))
    assert back[0] >= 0.0
    assert np.linalg.norm(back) == pytest.approx(1.0, abs=4 * EPS)
    assert min(distance(back, unit_q), distance(back, -unit_q)) < 8 * EPS
    if abs(unit_q[0]) > 1e-12:
        assert distance(back, math.copysign(1.0, unit_q[0]) * unit_q) < 8 * EPS
