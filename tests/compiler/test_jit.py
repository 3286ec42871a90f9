"""Functions of `lienumba.laws` under `@njit`: the bits of the same functions on floats."""

import math

import numba
import pytest

from lienumba import laws
from tests.compiler.evaluation import assert_same_bits

ONE = ("absolute", "acos", "asin", "atan", "ceil", "cos", "cosh", "exp", "floor", "log", "sign", "sin", "sinc", "sinh",
       "sqrt", "tan", "tanh")  # fmt: skip
TWO = ("atan2", "hypot", "maximum", "minimum", "mod")
THREE = ("clip", "where")
NUMBERS = (0.0, -0.0, 0.3, -0.9999, 1.0, 2.5, -3.5, 1e-5, 1e-320, 700.0, -745.5, 1e5, 2.0**52 + 1, math.inf, -math.inf,
           math.nan)  # fmt: skip


def test_every_function_of_laws_is_there():
    kinds = {"Body", "Joint", "Load", "Memory", "Vector", "pi", "deg", "rpm"}
    assert {*ONE, *TWO, *THREE} == {*laws.__all__} - kinds


@pytest.mark.parametrize("names", [ONE[::2], ONE[1::2]])
def test_of_one_number(names):
    source = f"def every(x): return ({', '.join(f'{name}(x)' for name in names)})"
    for x in NUMBERS:
        assert_same_bits(under_njit(source)(x), [getattr(laws, name)(x) for name in names])


def test_of_more_numbers():
    calls = [*(f"{name}(x, y)" for name in TWO), "clip(x, y, 1.5)", "where(x < y, x, 2.0)"]
    source = f"def every(x, y): return ({', '.join(calls)})"
    every, exact = under_njit(source), plain(source)
    for x in NUMBERS:
        for y in (1.0, -0.75, 3e5, math.inf, math.nan):
            assert_same_bits(every(x, y), exact(x, y))


def plain(source):
    names = {name: getattr(laws, name) for name in laws.__all__}
    exec(source, names)
    return names["every"]


_jitted = {}


def under_njit(source):
    if source not in _jitted:
        _jitted[source] = numba.njit(error_model="numpy")(plain(source))
    return _jitted[source]
