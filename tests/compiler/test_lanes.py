"""The vector type under `@njit`: every lane computes what a float would, and nothing of its neighbours."""

import math

import numpy as np
import pytest
from numba import njit

from lienumba.compiler import lanes
from lienumba.compiler.rows import W
from lienumba.numerics import operations
from tests.compiler.evaluation import assert_same_bits, on_lanes
from tests.compiler.interpreter import fma, numbers

BINARY = {
    "x + y": lambda x, y: x + y,
    "x - y": lambda x, y: x - y,
    "x * y": lambda x, y: x * y,
    "x / y": lambda x, y: x / y,
    "2 x": lambda x, y: 2.0 * x,
    "x - 1": lambda x, y: x - 1,
    "1 / y": lambda x, y: 1.0 / y,
    "-x": lambda x, y: -x,
    "x y + x": lambda x, y: x * y + x,
}
CONDITIONS = {
    "<": lambda x, y: x < y,
    "<=": lambda x, y: x <= y,
    ">": lambda x, y: x > y,
    ">=": lambda x, y: x >= y,
    "==": lambda x, y: x == y,
    "!=": lambda x, y: x != y,
    "< 0": lambda x, y: x < 0.0,
    "0 <=": lambda x, y: y >= 0,
    "and": lambda x, y: (x < y) & (y > 1.0),
    "or": lambda x, y: (x < y) | (y > 1.0),
}


def pairs() -> np.ndarray:
    """Ordinary numbers and every pair of special ones, equal ones among them."""
    special = np.array([0.0, -0.0, 1.0, -1.0, 5e-324, 1e308, np.inf, -np.inf, np.nan, 1.5])
    x, y = np.meshgrid(special, special)
    return np.concatenate([numbers(2, 1), np.array([x.ravel(), y.ravel()])], axis=1)


@pytest.mark.parametrize("name", BINARY)
def test_arithmetic_is_that_of_floats(name):
    x = pairs()
    with np.errstate(all="ignore"):
        expected = BINARY[name](*x)
    assert_same_bits(on_lanes(njit(BINARY[name]), (0, 0), 0)(x)[0], expected)


@pytest.mark.parametrize("name", CONDITIONS)
def test_comparisons_and_choices_are_those_of_floats(name):
    condition = njit(CONDITIONS[name])
    x = pairs()
    choose = njit(lambda x, y: operations.where(condition(x, y), x, 7))
    assert_same_bits(on_lanes(choose, (0, 0), 0)(x)[0], np.where(CONDITIONS[name](*x), x[0], 7.0))


def test_a_product_and_a_sum_are_rounded_twice():
    """No contraction into a multiply-add, unless it is asked for by name."""
    a = 1.0 + 2.0**-30
    x = np.tile(np.array([[a], [2.0 - a], [-1.0]]), (1, W))
    twice, once = njit(lambda a, b, c: a * b + c), njit(lambda a, b, c: lanes.fma(a, b, c))
    assert (on_lanes(twice, (0, 0, 0), 0)(x) == 0.0).all()
    assert (on_lanes(once, (0, 0, 0), 0)(x) == -(2.0**-60)).all()


def test_fma_is_rounded_once():
    x = np.concatenate([numbers(3, seed) for seed in range(40)], axis=1)
    got = on_lanes(njit(lambda a, b, c: lanes.fma(a, b, c)), (0, 0, 0), 0)(x)[0]
    assert_same_bits(got, np.array([fma(*column) for column in x.T.tolist()]))
    mixed = on_lanes(njit(lambda a, b, c: lanes.fma(a, 3.0, c)), (0, 0, 0), 0)(x)[0]
    assert_same_bits(mixed, np.array([fma(a, 3.0, c) for a, _, c in x.T.tolist()]))


def test_sqrt_and_powers_of_two():
    x = np.concatenate([np.abs(numbers(1, 5)), np.array([[0.0, -0.0, -1.0, np.inf, np.nan, 5e-324, 2.0, 3.0]])], axis=1)
    with np.errstate(all="ignore"):
        assert_same_bits(on_lanes(operations.sqrt, (0,), 0)(x), np.sqrt(x))
    n = np.array([[-1022.0, -1021.0, -1.0, 0.0, 1.0, 52.0, 1022.0, 1023.0]])
    assert_same_bits(on_lanes(operations.power_of_two, (0,), 0)(n), np.ldexp(1.0, n.astype(int)))


def test_minimum_maximum_absolute():
    x = pairs()
    for function, expected in (
        (operations.minimum, np.where(x[0] < x[1], x[0], x[1])),
        (operations.maximum, np.where(x[0] > x[1], x[0], x[1])),
    ):
        assert_same_bits(on_lanes(function, (0, 0), 0)(x)[0], expected)
    assert_same_bits(on_lanes(operations.absolute, (0,), 0)(x[:1])[0], np.where(x[0] < 0.0, -x[0], x[0]))


@njit
def _some_below(address, bound):
    return lanes.any_lane(lanes.load(address, 0) < bound)


def test_any_lane_sees_each_lane():
    x = np.full(W, 2.0)
    assert not _some_below(x.ctypes.data, 1.0)
    for lane in range(W):
        x[:] = np.nan
        x[lane] = 0.5
        assert _some_below(x.ctypes.data, 1.0)


@njit
def _swap_rows(address):
    first, second = lanes.load(address, 0), lanes.load(address, 1)
    lanes.store(address, 0, second)
    lanes.store(address, 1, first)
    lanes.store(address, 2, lanes.splat(7.0))


def test_rows_of_memory_need_no_alignment():
    memory = np.arange(3.0 * W + 1)
    _swap_rows(memory[1:].ctypes.data)
    assert memory[0] == 0.0
    assert memory[1:].tolist() == [*range(W + 1, 2 * W + 1), *range(1, W + 1), *[7] * W]


@njit
def _loop(address, count):
    total = lanes.splat(0.0)
    x = lanes.load(address, 0)
    for _ in range(count):
        total += x
        total *= 0.5
    lanes.store(address, 0, total)


def test_lanes_live_through_loops():
    x = numbers(1, 9)
    out = x.copy()
    _loop(out.ctypes.data, 5)
    with np.errstate(all="ignore"):
        total = np.zeros_like(x)
        for _ in range(5):
            total = (total + x) * 0.5
    assert_same_bits(out, total)


def test_a_float_stays_a_float():
    """The same jitted function serves floats: math's own results, NaN outside the domain."""
    floats = njit(lambda x: (operations.sqrt(x), operations.sin(x), operations.cos(x), operations.exp(x)))
    for x in (0.3, 2.0, 100.0):
        assert floats(x) == pytest.approx((math.sqrt(x), math.sin(x), math.cos(x), math.exp(x)), rel=1e-15)
    assert math.isnan(floats(-1.0)[0])
    assert math.isnan(floats(math.inf)[1])
    assert floats(1000.0)[3] == math.inf
    for x in (-1.0, math.inf, math.nan, 1000.0, -1000.0):
        plain = (operations.sqrt(x), operations.sin(x), operations.cos(x), operations.exp(x))
        assert_same_bits(np.array(floats(x))[[0, 3]], np.array(plain)[[0, 3]])


@pytest.mark.parametrize("held", [*range(W), W])
def test_all_lanes_are_as_many_as_there_are(held):
    x = np.where(np.arange(W) < held, 1.0, 2.0)[None]
    said = njit(lambda x: operations.where(x == x, 1.0 if lanes.all_lanes(x < 1.5) else 0.0, x))
    assert (on_lanes(said, (0,), 0)(x)[0] == float(held == W)).all()
