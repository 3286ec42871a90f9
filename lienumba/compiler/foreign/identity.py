"""What a function for Numba does, as a digest: its bytecode, and the values that it reads, which Numba freezes."""

import dis
import hashlib
import sys
from collections.abc import Iterator
from functools import cache
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from lienumba import laws
from lienumba.errors import BadValueError

LIBRARIES = {"builtins", "lienumba", "numba", "numpy", *sys.stdlib_module_names}  # known by their versions
UNSURE = {  # functions of mathematics libraries
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "erf", "erfc", "exp", "exp2",
    "expm1", "gamma", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "power", "sin", "sinh", "tan", "tanh",
}  # fmt: skip
FLAGS = 0xFF  # of a code: what arguments it takes, not how its annotations are read
REMEDY = "let it read numbers, tuples, texts, arrays and functions only, or make it an argument"


def identity(function: FunctionType) -> str:
    """The digest. Raises BadValueError for a value that is not known, and for functions that Numba has compiled."""
    digest = hashlib.sha256()
    for text in _function(function, {id(function)}):
        digest.update(text + b"\0")
    return digest.hexdigest()


def names_of(function: FunctionType) -> tuple[str, ...]:
    """The names of the globals that a function reads."""
    return _code(function.__code__)[0]


def _function(function: FunctionType, seen: set[int]) -> Iterator[bytes]:
    names, attributes, code = _code(function.__code__)
    yield code
    read = {name: function.__globals__[name] for name in names if name in function.__globals__}
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    read |= {name: cell.cell_contents for name, cell in cells}
    read |= {f"default {n}": x for n, x in enumerate(function.__defaults__ or ())}
    for name, x in sorted(read.items()):
        yield name.encode()
        yield from _value(f"{function.__name__} reads {name}", x, attributes, seen)


def _value(place: str, x: Any, names: tuple[str, ...], seen: set[int]) -> Iterator[bytes]:
    """What a value says; names: what may be read of it, if it is a module."""
    function = getattr(x, "py_func", x)
    if hasattr(x, "targetoptions") and not _of_library(function.__module__ or ""):
        rule = f"{place}, which numba compiles without checks of indices"
        raise BadValueError(rule, "decorate it with lienumba.jit")
    if isinstance(x, bool | int | float | complex | str | bytes | None):
        yield repr((type(x).__name__, x)).encode()
    elif isinstance(x, tuple):
        yield f"tuple of {len(x)}".encode()
        for inner in x:
            yield from _value(place, inner, names, seen)
    elif isinstance(x, np.ndarray | np.generic) and x.dtype != object:
        yield repr((x.dtype.descr, x.shape, x.flags.f_contiguous)).encode() + x.tobytes()
    elif isinstance(function, ModuleType) and function.__name__ in ("math", "numpy"):
        for name in names:
            _refuse_library(place, name)
        yield function.__name__.encode()
    elif isinstance(function, ModuleType) and not _of_library(function.__name__):
        for name in names:
            if hasattr(function, name):
                yield from _value(f"{place}.{name}", getattr(function, name), names, seen)
    elif isinstance(function, FunctionType) and not _of_library(function.__module__ or ""):
        if id(function) not in seen:
            seen.add(id(function))
            yield from _function(function, seen)
    elif isinstance(function, ModuleType | FunctionType | BuiltinFunctionType | type | np.ufunc):
        if isinstance(function, BuiltinFunctionType | np.ufunc):
            _refuse_library(place, function.__name__)
        yield f"{getattr(function, '__module__', '')}.{function.__name__}".encode()
    else:
        raise BadValueError(f"{place}, a {type(x).__name__}, which is not known", REMEDY)


def _refuse_library(place: str, name: str) -> None:
    """Refuse a function whose bits are up to the mathematics library, and to what LLVM makes of it beforehand."""
    plain = name.replace("arc", "a")
    if plain in UNSURE:
        instead = plain if plain in laws.__all__ else "exp and log"
        raise BadValueError(
            f"{place} for {name}, whose bits differ between machines", f"take {instead} of lienumba.laws"
        )


def _of_library(module: str) -> bool:
    return module.partition(".")[0] in LIBRARIES


@cache
def _code(code: CodeType) -> tuple[tuple[str, ...], tuple[str, ...], bytes]:
    """The names of the globals and of the attributes that a code reads, and all that it says but for its lines."""
    names, attributes, said = set[str](), set[str](), []
    for inner in _codes(code):
        for x in dis.get_instructions(inner):
            if x.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
                names.add(x.argval)
            elif x.opname in ("LOAD_ATTR", "LOAD_METHOD"):
                attributes.add(x.argval)
        constants = [repr((type(x).__name__, x)) for x in inner.co_consts if not isinstance(x, CodeType)]
        counts = inner.co_argcount, inner.co_kwonlyargcount, inner.co_flags & FLAGS
        table = getattr(inner, "co_exceptiontable", b"")
        said.append((inner.co_code, table, counts, inner.co_names, inner.co_varnames, inner.co_freevars, constants))
    return tuple(names), tuple(sorted(attributes)), repr(said).encode()


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A code and all codes inside it."""
    yield code
    for x in code.co_consts:
        if isinstance(x, CodeType):
            yield from _codes(x)
