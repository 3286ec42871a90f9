"""Routines as object code, called by address; kept in the cache, where later processes find it.

An argument is a whole number, a float, a contiguous array of either, or a named tuple of such. Whole numbers, addresses
and shapes travel in one array of int64, floats in one of float64, in the order of the arguments.
"""

import ctypes
import functools
from collections.abc import Iterable
from importlib import import_module
from types import FunctionType
from typing import Any, cast, get_type_hints

import numpy as np

from lienumba.compiler import cache, native
from lienumba.compiler.routines.marks import ENTRY

PASSES = 2  # over LLVM text with loops: of more no loop gets faster


class Flat:
    """A routine that is called with arguments of Python's.

    stored: the kinds of its arguments in a line, and behind it the object code; address: of the function with the
    arguments of ENTRY.
    """

    def __init__(self, name: str, stored: bytes) -> None:
        kinds, _, code = stored.partition(b"\n")
        self.name, self.kinds = name, kinds.decode()
        self._engine, addresses = native.load(code, [ENTRY])
        self.address = addresses[ENTRY]
        self._call = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 2)(self.address)

    def __call__(self, *arguments: Any) -> None:
        whole, floats = self.packed(*arguments)
        self._call(whole.ctypes.data, floats.ctypes.data)

    def packed(self, *arguments: Any) -> tuple[np.ndarray, np.ndarray]:
        """The arguments as the function reads them: int64, float64."""
        given: list[int] = []
        numbers: list[float] = []
        kinds = _pack(arguments, given, numbers)
        if kinds != self.kinds:
            raise TypeError(f"{self.name} takes {self.kinds}, but was given {kinds}")
        return np.array(given, np.int64), np.array(numbers, np.float64)


def kept(module: str, name: str) -> Flat:
    """A routine of a module that is not imported unless it has to be compiled."""
    whole = f"{module}.{name}"
    return Flat(whole, cache.remember(key_of(whole), lambda: object_code(getattr(import_module(module), name))))


def compiled(routine: FunctionType) -> Flat:
    """A routine that is compiled now."""
    return Flat(routine.__qualname__, object_code(routine))


def plain(module: str, name: str) -> FunctionType:
    """A routine of a module as a plain Python function on the same memory, with the same bits: to be stepped through,
    and measured for coverage. Some thousand times slower."""
    routine = getattr(import_module(module), name)
    hints = get_type_hints(routine)
    hints.pop("return", None)

    @functools.wraps(routine)
    def run(*arguments: Any) -> None:
        with np.errstate(all="ignore"):
            routine(*map(_named, hints.values(), arguments))

    return cast(FunctionType, run)


def _named(hint: Any, given: Any) -> Any:
    """An argument, in the named tuples that a routine asks for."""
    if not hasattr(hint, "_fields"):
        return given
    return hint(*map(_named, get_type_hints(hint).values(), given))


def key_of(name: str) -> str:
    """What decides about the object code of a routine, beside what the whole cache knows."""
    return "\0".join((name, *native.cpu(), str(native.LEVEL), str(PASSES)))


def object_code(routine: FunctionType) -> bytes:
    """The kinds of the arguments in a line, and behind it the object code."""
    from lienumba.compiler.routines.program import text_of

    kinds, text = text_of(routine)
    return kinds.encode() + b"\n" + native.emit(text, *native.cpu(), passes=PASSES)


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
