"""Jets carry the first and second derivative; the oracle is mpmath's own Taylor expansion."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups import so3
from lienumba.numerics import operations
from lienumba.numerics.jets import Dual, Jet, lift
from tests.compiler.evaluation import call

OPERATIONS = {
    "x + y": (lambda f, x, y: x + y),
    "x - y": (lambda f, x, y: x - y),
    "x * y": (lambda f, x, y: x * y),
    "x / y": (lambda f, x, y: x / y),
    "-x": (lambda f, x, y: -x),
    "2 - 3 x": (lambda f, x, y: 2.0 - 3.0 * x),
    "x - 0.5": (lambda f, x, y: x - 0.5),
    "0.5 / y": (lambda f, x, y: 0.5 / y),
    "y / 4": (lambda f, x, y: y / 4.0),
    "sqrt(y)": (lambda f, x, y: f.sqrt(y)),
    "sin(x)": (lambda f, x, y: f.sin(x)),
    "cos(x)": (lambda f, x, y: f.cos(x)),
    "exp(x)": (lambda f, x, y: f.exp(x)),
    "atan2(x, y)": (lambda f, x, y: f.atan2(x, y)),
    "atan2(y, x)": (lambda f, x, y: f.atan2(y, x)),
    "atan2(x, -y)": (lambda f, x, y: f.atan2(x, -y)),
    "atan2(0.3, x)": (lambda f, x, y: f.atan2(0.3, x)),
    "together": (lambda f, x, y: f.sin(x * y) / f.sqrt(y + x * x) - f.exp(-y) * f.cos(x / y)),
}

numbers_of_a_jet = st.tuples(*[st.floats(-2.0, 2.0).filter(lambda x: abs(x) > 1e-3)] * 3)


def taylor(function, x, y):
    """Value, first and second derivative at t = 0 along x0 + x1 t + x2 t^2 / 2, and likewise y."""

    def along(t):
        a, b = (c[0] + c[1] * t + c[2] * t**2 / 2 for c in ([mpmath.mpf(n) for n in z] for z in (x, y)))
        return function(mpmath, a, b)

    with mpmath.workdps(40):
        c = mpmath.taylor(along, 0, 2)
        return [float(c[0]), float(c[1]), float(2 * c[2])]


@pytest.mark.parametrize("name", OPERATIONS)
def test_derivatives_are_those_of_mpmath(name):
    function = OPERATIONS[name]

    @settings(derandomize=True, max_examples=25)
    @given(numbers_of_a_jet, numbers_of_a_jet)
    def check(x, y):
        y = (abs(y[0]) + 0.1, *y[1:])
        jet = function(operations, Jet(*x), Jet(*y))
        exact = taylor(function, x, y)
        size = 1.0 + max(map(abs, exact)) + (1.0 / y[0]) ** 3 + 1.0 / (x[0] ** 2 + 0.09)
        assert (jet.a, jet.b, jet.c) == pytest.approx(exact, abs=1e-13 * size)

    check()


def test_a_plain_number_does_not_move():
    assert (lift(3.0).a, lift(3.0).b, lift(3.0).c) == (3.0, 0.0, 0.0)
    jet = Jet(1.0, 2.0, 3.0)
    assert lift(jet) is jet


def test_comparisons_look_at_the_value_and_choices_carry_all_three():
    x, y = Jet(1.0, 5.0, 7.0), Jet(2.0, -5.0, 9.0)
    assert x < y
    assert x <= 1.0
    assert y > 1.5
    assert y >= 2.0
    assert not x > y
    chosen = operations.where(x < y, x, y)
    assert (chosen.a, chosen.b, chosen.c) == (1.0, 5.0, 7.0)
    mixed = operations.maximum(x, 4.0)
    assert (lift(mixed).a, lift(mixed).b) == (4.0, 0.0)
    slope = operations.absolute(-x)
    assert (slope.a, slope.b, slope.c) == (1.0, 5.0, 7.0)


def test_jets_of_arrays_are_jets_of_each_number():
    rng = np.random.default_rng(0)
    x, y = rng.uniform(0.2, 2.0, (2, 3, 20))
    function = OPERATIONS["together"]
    many = function(operations, Jet(*x), Jet(*y))
    for n in range(20):
        one = function(operations, Jet(*x[:, n].tolist()), Jet(*y[:, n].tolist()))
        assert (many.a[n], many.b[n], many.c[n]) == pytest.approx((one.a, one.b, one.c), rel=1e-13)


def test_choices_between_jets_of_arrays_are_made_number_by_number():
    x, y = Jet(np.array([1.0, 3.0]), np.array([5.0, 6.0]), 0.0), Jet(2.0, -5.0, 9.0)
    smaller = operations.minimum(x, y)
    assert smaller.a.tolist() == [1.0, 2.0]
    assert smaller.b.tolist() == [5.0, -5.0]
    assert smaller.c.tolist() == [0.0, 9.0]


def compiled(function, rows):
    """A function of jets of symbols, as compiled code: (3 rows, W) to (3, W)."""
    graph = Graph()
    inputs = graph.inputs("state", 3 * rows)
    jet = lift(function(*(Jet(*inputs[3 * i : 3 * i + 3]) for i in range(rows))))
    kernel = Kernel("jet", (jet.a, jet.b, jet.c), 0)
    return lambda x: call(kernel, state=x)


def test_jets_of_symbols_are_jets_of_numbers():
    x = np.random.default_rng(8).uniform(0.1, 2.0, (6, 8))
    function = OPERATIONS["together"]
    got = compiled(lambda a, b: function(operations, a, b), 2)(x)
    for lane in range(x.shape[1]):
        one = function(operations, Jet(*x[:3, lane].tolist()), Jet(*x[3:, lane].tolist()))
        assert got[:, lane] == pytest.approx((one.a, one.b, one.c), rel=1e-11)


def test_choices_between_jets_of_symbols():
    """The condition is a symbol, what it chooses between are jets."""
    x = np.random.default_rng(1).standard_normal((6, 8))
    got = compiled(operations.maximum, 2)(x)
    np.testing.assert_array_equal(got, np.where(x[0] > x[3], x[:3], x[3:]))


def test_the_derivative_of_a_rotation_is_dexp():
    """exp along u + t w, as jets: its rate is hat(dexp_u(w)) exp(u)."""
    u, w = (0.4, -1.1, 0.7), (0.3, 0.5, -0.2)
    R = so3.exp(tuple(Jet(a, b) for a, b in zip(u, w, strict=True)))
    expected = so3.multiply(so3.hat(so3.dexp(u, w)), so3.exp(u))
    assert [x.b for x in R] == pytest.approx(expected, abs=1e-14)
    angle = operations.sqrt(so3.dot(*[so3.log(R)] * 2))
    assert angle.a == pytest.approx(math.sqrt(so3.dot(u, u)), rel=1e-14)
    assert angle.b == pytest.approx(so3.dot(u, w) / math.sqrt(so3.dot(u, u)), rel=1e-13)


@pytest.mark.parametrize("name", OPERATIONS)
def test_dual_numbers_are_jets_without_the_second_derivative(name):
    """To the bit, beside constants too."""
    function = OPERATIONS[name]
    x, y = np.random.default_rng(5).uniform(0.2, 2.0, (2, 2, 20))
    for make in (lambda z: Jet(*z), lambda z: lift(z[0])):
        jet, dual = function(operations, Jet(*x), make(y)), function(operations, Dual(*x), make(y))
        assert not hasattr(dual, "c") or type(dual) is Jet
        np.testing.assert_array_equal([jet.a, jet.b * np.ones(20)], [dual.a, dual.b * np.ones(20)])


def test_choices_between_dual_numbers():
    x, y = Dual(np.array([1.0, 3.0]), np.array([5.0, 6.0])), Dual(2.0, -5.0)
    smaller = operations.minimum(x, y)
    assert (smaller.a.tolist(), smaller.b.tolist()) == ([1.0, 2.0], [5.0, -5.0])
    away = operations.absolute(Dual(-1.0, 2.0))
    assert (away.a, away.b) == (1.0, -2.0)
