"""Kernels and named operations under `@njit`, on floats.

Numba finds `register` through the package's entry point, so a user's own jitted code may call `so3.exp` and the like.
"""

import math
from collections.abc import Callable
from typing import Any

from lienumba.numerics import operations, vector_math


def register() -> None:
    """Tell Numba of every kernel, those to come included."""
    from numba.core import types
    from numba.extending import overload, register_jitable

    if operations.ON_NEW_KERNEL:
        return

    def scalar(x: types.Type) -> bool:
        return isinstance(x, types.Number)

    @overload(operations.sqrt, strict=False)
    def sqrt(x: types.Type) -> Any:
        if scalar(x):
            return lambda x: math.sqrt(x)

    def polynomial(operation: Callable[..., object], of_any_number: Callable[..., object]) -> None:
        @overload(operation, strict=False)
        def choose(x: types.Type) -> Any:
            return lambda x: of_any_number(x)

    polynomial(operations.sin, vector_math.sin)
    polynomial(operations.cos, vector_math.cos)
    polynomial(operations.exp, vector_math.exp)
    polynomial(operations.log, vector_math.log)

    @overload(operations.power_of_two, strict=False)
    def power_of_two(n: types.Type) -> Any:
        if scalar(n):
            return lambda n: math.ldexp(1.0, int(n)) if n == n else n

    @overload(operations.atan2, strict=False)
    def atan2(y: types.Type, x: types.Type) -> Any:
        return lambda y, x: vector_math.atan2(y, x)

    @overload(operations.where, strict=False)
    def where(condition: types.Type, x: types.Type, y: types.Type) -> Any:
        if isinstance(condition, types.Boolean):
            return lambda condition, x, y: x if condition else y

    @overload(operations.at_most, strict=False)
    def at_most(x: types.Type, bound: types.Type) -> Any:
        return lambda x, bound: x

    @overload(operations.alike, strict=False)
    def alike(condition: types.Type) -> Any:
        return lambda condition: condition

    for function in (operations.minimum, operations.maximum, operations.absolute, *operations.KERNELS):
        register_jitable(function)
    operations.ON_NEW_KERNEL.append(register_jitable)
