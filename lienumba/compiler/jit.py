"""Kernels, named operations and the functions of `lienumba.laws` under `@njit`, on floats.

Numba finds `register` through the package's entry point, so a user's own jitted code may call `so3.exp` and the like.
No function calls a mathematics library: the bits are those of the same function on Python floats.
"""

import math
from collections.abc import Callable
from typing import Any

from lienumba.numerics import functions, operations, vector_math
from lienumba.numerics.vector_math import ROUND

# Of the functions of laws, those that are compiled as they are written.
PLAIN = ("acos", "asin", "atan", "ceil", "clip", "cosh", "hypot", "mod", "sign", "sinc", "sinh", "tan")


def register() -> None:
    """Tell Numba of every kernel, those to come included."""
    from numba.core import types
    from numba.extending import intrinsic, overload, register_jitable

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

    @overload(operations.tanh, strict=False)
    def tanh(x: types.Type) -> Any:
        return lambda x: operations.piecewise_tanh(x)

    @overload(functions.floor, strict=False)
    def floor(x: types.Type) -> Any:
        return lambda x: functions.floor_of_number(x)

    @intrinsic
    def exponent(typing: Any, biased: types.Type) -> Any:
        """The double whose exponent is in the last bits of another one: ldexp would be a call of a library."""

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            from llvmlite import ir

            whole, double = ir.IntType(64), ir.DoubleType()
            return builder.bitcast(builder.shl(builder.bitcast(arguments[0], whole), ir.Constant(whole, 52)), double)

        return types.float64(types.float64), code

    @overload(operations.power_of_two, strict=False)
    def power_of_two(n: types.Type) -> Any:
        if scalar(n):
            return lambda n: exponent(n + (ROUND + 1023.0)) if n == n else n

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

    named = (operations.minimum, operations.maximum, operations.absolute, operations.piecewise_tanh)
    of_laws = (functions.FUNCTIONS[name][2] for name in PLAIN)
    for function in (*named, *of_laws, functions.floor_of_number, *operations.KERNELS):
        register_jitable(function)
    operations.ON_NEW_KERNEL.append(register_jitable)
