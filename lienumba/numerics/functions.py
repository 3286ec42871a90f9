"""The functions that formulas and laws may call, on floats, arrays, jets and symbols."""

from collections.abc import Callable
from functools import reduce
from typing import Any

from lienumba.numerics import vector_math
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, atan2, cos, exp, log, sin, sqrt, tanh, where

LARGEST_FRACTION = 2.0**51  # numbers above have none
NEAR_ZERO = 1e-4  # where two terms of a series are exact


def tan(x: Number) -> Any:
    return sin(x) / cos(x)


def asin(x: Number) -> Any:
    return atan2(x, sqrt((1.0 - x) * (1.0 + x)))


def acos(x: Number) -> Any:
    return atan2(sqrt((1.0 - x) * (1.0 + x)), x)


def atan(x: Number) -> Any:
    return atan2(x, 1.0)


def _clip(x: Number, low: Number, high: Number) -> Any:
    return where(x > high, high, where(x < low, low, x))


def _sign(x: Number) -> Any:
    return where(x > 0.0, 1.0, where(x < 0.0, -1.0, 0.0 * x))


def floor(x: Number) -> Any:
    """The largest whole number that is not above x."""
    return floor_of_number(lift(x).a)


def floor_of_number(x: Number) -> Any:
    """`floor` of what has no derivative."""
    nearest = vector_math.round_to_integer(x)
    below = where(nearest > x, nearest - 1.0, nearest)
    return where(absolute(x) < LARGEST_FRACTION, below, x)


def ceil(x: Number) -> Any:
    """The smallest whole number that is not below x."""
    return -floor(-x)


def mod(x: Number, y: Number) -> Any:
    """What is left of x beside whole multiples of y, with the sign of y."""
    return x - y * floor(x / y)


def _smaller(x: Number, y: Number) -> Any:
    """The smaller of two numbers; NaN where either is."""
    return where(x < y, x, where(y <= x, y, x + y))


def _larger(x: Number, y: Number) -> Any:
    return where(x > y, x, where(y >= x, y, x + y))


def _sinc(x: Number) -> Any:
    near = absolute(x) < NEAR_ZERO
    return where(near, 1.0 - x * x / 6.0, sin(x) / where(near, 1.0, x))


def _cosh(x: Number) -> Any:
    return 0.5 * (exp(x) + exp(-x))


def sinh(x: Number) -> Any:
    return tanh(x) * _cosh(x)


def hypot(x: Number, y: Number) -> Any:
    return sqrt(x * x + y * y)


# name -> (fewest arguments, most arguments, function)
FUNCTIONS: dict[str, tuple[int, int, Callable[..., Any]]] = {
    "sin": (1, 1, sin),
    "cos": (1, 1, cos),
    "tan": (1, 1, tan),
    "asin": (1, 1, asin),
    "acos": (1, 1, acos),
    "atan": (1, 1, atan),
    "atan2": (2, 2, atan2),
    "exp": (1, 1, exp),
    "log": (1, 1, log),
    "sqrt": (1, 1, sqrt),
    "tanh": (1, 1, tanh),
    "abs": (1, 1, absolute),
    "sign": (1, 1, _sign),
    "min": (2, 9, lambda *x: reduce(_smaller, x)),
    "max": (2, 9, lambda *x: reduce(_larger, x)),
    "clip": (3, 3, _clip),
    "floor": (1, 1, floor),
    "ceil": (1, 1, ceil),
    "mod": (2, 2, mod),
    "sinc": (1, 1, _sinc),
    "sinh": (1, 1, sinh),
    "cosh": (1, 1, _cosh),
    "hypot": (2, 2, hypot),
    "where": (3, 3, where),
}
