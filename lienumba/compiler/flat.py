"""Jitted functions as object code, called by address: a process that finds it in the cache does without Numba.

An argument is a whole number, a float, a contiguous array of either, or a named tuple of such. Whole numbers, addresses
and shapes travel in one array of int64, floats in one of float64, in the order of the arguments.
"""

import ctypes
import os
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

import numpy as np

from lienumba.compiler import cache, native

ENTRY = "entry"  # the function's name in the object code: void (whole numbers, floats)
SETTING = "NUMBA_"  # what begins so in the environment may change what Numba compiles
OPTIMISED = 3  # the level of code generation, Numba's own


class Flat:
    """A function of a module that is not imported unless it has to be compiled."""

    def __init__(self, module: str, name: str) -> None:
        self.name = f"{module}.{name}"
        stored = cache.remember(key_of(self.name), lambda: getattr(import_module(module), name).object_code())
        kinds, _, code = stored.partition(b"\n")
        self.kinds = kinds.decode()
        self._engine, addresses = native.load(code, [ENTRY])
        self._call = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 2)(addresses[ENTRY])

    def __call__(self, *arguments: Any) -> None:
        given: list[int] = []
        numbers: list[float] = []
        kinds = _pack(arguments, given, numbers)
        if kinds != self.kinds:
            raise TypeError(f"{self.name} takes {self.kinds}, but was given {kinds}")
        whole, floats = np.array(given, np.int64), np.array(numbers, np.float64)
        self._call(whole.ctypes.data, floats.ctypes.data)


def key_of(name: str) -> str:
    """What decides about the object code of a function, beside what the whole cache knows."""
    settings = sorted(f"{key}={x}" for key, x in os.environ.items() if key.startswith(SETTING))
    return "\0".join((name, *native.cpu(), *settings))


def _pack(arguments: Iterable[Any], given: list[int], numbers: list[float]) -> str:
    """Append the arguments; returns their kinds: "i", "f", and with the number of dimensions "I" and "F" of arrays."""
    kinds = ""
    for x in arguments:
        if isinstance(x, np.ndarray):
            if not x.flags.c_contiguous or x.dtype not in (np.int64, np.float64):
                raise TypeError(f"an array of {x.dtype} with strides {x.strides} is no contiguous one of numbers")
            given += [x.ctypes.data, *x.shape]
            kinds += f"{'I' if x.dtype == np.int64 else 'F'}{x.ndim}"
        elif isinstance(x, tuple):
            kinds += _pack(x, given, numbers)
        elif isinstance(x, float):
            numbers.append(x)
            kinds += "f"
        else:
            given.append(x)
            kinds += "i"
    return kinds


class Jitted:
    """What `Flat` calls, and a decorator: `njit` of a function with this signature, compiled when it is asked for."""

    def __init__(self, signature: Any, **options: Any) -> None:
        self.signature, self.options = signature, options

    def __call__(self, function: Callable[..., None]) -> "Jitted":
        self.function = function
        return self

    def object_code(self) -> bytes:
        """The kinds of the arguments in a line, and behind it the object code."""
        from numba import njit

        from lienumba.compiler.lanes import words

        kinds = self.signature.args
        made = njit(self.signature, no_cpython_wrapper=True, **self.options)(self.function).overloads[kinds]
        text, entry = made.library.get_llvm_str(), _entry(made.target_context, made.fndesc)
        return "".join(map(words, kinds)).encode() + b"\n" + native.emit(text, *native.cpu(), OPTIMISED, entry)


def _entry(context: Any, function: Any) -> str:
    """LLVM text of ENTRY, which calls a function of Numba's."""
    from llvmlite import ir

    from lienumba.compiler.lanes import DOUBLE, INT64, Reader

    module = ir.Module()
    pointers = INT64.as_pointer(), DOUBLE.as_pointer()
    entry = ir.Function(module, ir.FunctionType(ir.VoidType(), pointers), ENTRY)
    builder = ir.IRBuilder(entry.append_basic_block())
    reader, called = Reader(context, builder, *entry.args), context.declare_function(module, function)
    arguments = [reader.next(kind) for kind in function.argtypes]
    context.call_conv.call_function(builder, called, function.restype, function.argtypes, arguments)
    builder.ret_void()
    return str(module)
