"""The named operations of kernels: what a number can do beside `+ - * /`.

A kernel is a plain function of numbers. The same source runs on floats, on NumPy arrays (one value per run), on
the compiler's jets and symbols, and on floats or lanes under `@njit`. Outside its domain an operation is NaN, never
an exception. sin, cos, exp and atan2 are the polynomials of `lienumba.numerics.vector_math` on every kind of number, so
that a result never depends on a mathematics library and the CPU that it looks for.
"""

import math
from collections.abc import Callable
from types import ModuleType
from typing import Any, Protocol, TypeGuard, TypeVar

import numpy as np

from lienumba.numerics.number import Condition, Number

Kernel = Callable[..., object]
F = TypeVar("F", bound=Kernel)

HOLDS = 1e-300  # the margin of a condition that holds where both sides are equal, or by rounding are not
KERNELS: list[Kernel] = []
ON_NEW_KERNEL: list[Callable[[Kernel], object]] = []


def kernel(function: F) -> F:
    """Mark a plain function as a kernel, so that Numba may call it from jitted code."""
    KERNELS.append(function)
    for tell in ON_NEW_KERNEL:
        tell(function)
    return function


def _is_float(x: object) -> TypeGuard[float]:
    return isinstance(x, float | int)


def _array(x: Number) -> Any:
    """A number that is neither a float nor brings operations of its own."""
    return x


def sqrt(x: Number) -> Any:
    if _is_float(x):
        return math.sqrt(x) if x >= 0.0 else math.nan
    return x.sqrt() if hasattr(x, "sqrt") else _array(x) ** 0.5


def sin(x: Number) -> Any:
    return x.sin() if hasattr(x, "sin") else vector_math().sin(x)


def cos(x: Number) -> Any:
    return x.cos() if hasattr(x, "cos") else vector_math().cos(x)


def exp(x: Number) -> Any:
    return x.exp() if hasattr(x, "exp") else vector_math().exp(x)


def log(x: Number) -> Any:
    return x.log() if hasattr(x, "log") else vector_math().log(x)


def atan2(y: Number, x: Number) -> Any:
    for number in (y, x):
        if hasattr(number, "atan2"):
            return number.atan2(y, x)
    return vector_math().atan2(y, x)


def tanh(x: Number) -> Any:
    return x.tanh() if hasattr(x, "tanh") else piecewise_tanh(x)


def piecewise_tanh(x: Number) -> Any:
    """By its continued fraction near 0, else from exp(-2 |x|): accurate beside 0, and never too large."""
    y = x * x
    near = x / (1.0 + y / (3.0 + y / (5.0 + y / (7.0 + y / (9.0 + y / (11.0 + y / 13.0))))))
    e = exp(-2.0 * absolute(x))
    far = (1.0 - e) / (1.0 + e)
    return where(y < 0.25, near, where(x < 0.0, -far, far))


def vector_math() -> ModuleType:
    """The polynomials; they stand on this module."""
    from lienumba.numerics import vector_math

    return vector_math


def power_of_two(n: Number) -> Any:
    """2**n for an integral n in [-1022, 1023], exactly."""
    if _is_float(n):
        return math.ldexp(1.0, int(n)) if math.isfinite(n) else math.nan
    if hasattr(n, "power_of_two"):
        return n.power_of_two()
    return np.where(np.isnan(_array(n)), np.nan, np.ldexp(1.0, np.nan_to_num(_array(n)).astype(np.int64)))


def where(condition: Condition, x: Number, y: Number) -> Any:
    """x where the condition holds, else y; both are evaluated, neither may raise."""
    if isinstance(condition, bool):
        return x if condition else y
    for number in (x, y, condition):
        if hasattr(number, "where"):
            return number.where(condition, x, y)
    return np.where(condition, _array(x), _array(y))


def minimum(x: Number, y: Number) -> Any:
    """The smaller of two numbers; y where either is NaN."""
    return where(x < y, x, y)


def maximum(x: Number, y: Number) -> Any:
    """The larger of two numbers; y where either is NaN."""
    return where(x > y, x, y)


def is_zero(x: Number) -> bool:
    """Whether a number is zero by its structure."""
    return isinstance(x, float) and x == 0.0


def divide(x: Number, y: Number) -> Any:
    """x / y; infinite or NaN where y is 0."""
    if _is_float(x) and _is_float(y) and y == 0.0:
        return math.nan if x == 0.0 or math.isnan(x) else math.copysign(math.inf, x) * math.copysign(1.0, y)
    return x / y


def power(x: Number, p: Number) -> Any:
    """x**p: repeated multiplication where p is a whole number known beforehand, else exp(p log x)."""
    if not _is_float(p) or not float(p).is_integer():
        if hasattr(x, "power"):
            return x.power(p)
        return sqrt(x) if _is_float(p) and p == 0.5 else exp(p * log(x))
    result: Number = 1.0
    factor, n = x, abs(int(p))
    while n:
        result = result * factor if n % 2 else result
        factor, n = factor * factor, n // 2
    return result if p >= 0 else divide(1.0, result)


def absolute(x: Number) -> Any:
    return where(x < 0.0, -x, x)


class Numbers(Protocol):
    """Numbers in memory: an array, or the address of one."""

    def gather(self, index: Number) -> Number: ...


def gather(numbers: Numbers, index: Number) -> Any:
    """The entry of numbers in memory at an index, which is a whole number and lies within."""
    return numbers.gather(index)


def at_most(x: Number, bound: float) -> Any:
    """x itself, which the caller promises to be <= bound: the compiler drops the branches this rules out."""
    return x.at_most(bound) if hasattr(x, "at_most") else x


def alike(condition: Condition) -> Any:
    """The condition itself, which the caller promises to choose among forms of one number alone: where it changes,
    nothing has a kink."""
    return condition.alike() if hasattr(condition, "alike") else condition
