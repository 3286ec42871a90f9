"""`lienumba.jit`: a function that Numba compiles, called from laws that are traced.

What it does is known by its bytecode, by the values that it reads and by the versions of Numba and lienumba. So its
text is found in the cache, and later processes import no Numba.
"""

import functools
import hashlib
import inspect
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.metadata import version
from types import FunctionType
from typing import Any

from lienumba.compiler import cache, native
from lienumba.compiler.foreign.calls import KNOWN, PREFIX, Argument, Foreign, PythonFunction
from lienumba.compiler.foreign.identity import identity
from lienumba.errors import BadValueError

SOURCES = ("compiler/foreign", "compiler/jit.py", "groups", "numerics")  # of lienumba, that decide about a text


class Jitted(PythonFunction):
    """A function that Numba compiles, see `jit`."""

    def identity(self) -> str:
        """What it does: its bytecode, all that it reads, and Numba's version."""
        return f"{identity(self.py_func)} {_numba()}"

    def compiled(self, arguments: Sequence[Argument]) -> Foreign:
        """The compiled function for such arguments."""
        said = self.identity(), repr(arguments), _sources(), *native.cpu()
        symbol = PREFIX + hashlib.sha256("\0".join(said).encode()).hexdigest()[:32]
        if symbol not in KNOWN:
            KNOWN[symbol] = Foreign(**json.loads(cache.remember(symbol, lambda: self._made(symbol, arguments))))
        return KNOWN[symbol]

    def _made(self, symbol: str, arguments: Sequence[Argument]) -> bytes:
        from lienumba.compiler.foreign import blocks

        return json.dumps(asdict(blocks.compiled(self.py_func, symbol, arguments))).encode()


def jit(function: Callable[..., Any]) -> Jitted:
    """Let Numba compile a function that laws in Python call.

    The function may branch on its numbers, loop, and read numbers, tuples and arrays of its module. It is called for
    one run at a time; where it raises, or returns what is not finite, that run fails alone. Mathematics comes from
    `lienumba.laws`: libraries (`math.sin`, `np.exp`, `%`) and allocated memory (`np.zeros`) are refused. It has no
    derivative: a law that calls it, and is not sampled (`every`), excludes `taylor`, implicit methods, `linearise`
    and `modes`; potential energies, joints and equilibria exclude it.

    Parameters
    ----------
    function : callable
        A plain function of numbers and tuples of numbers (a `Vector` arrives as a tuple of three). An array of the
        law's memory arrives as an array, and what it writes there is kept. It returns a number, or a tuple of numbers.

    Returns
    -------
    callable
        For laws; on floats and arrays it returns floats and arrays, NaN where it fails. Its calls raise ValueError for
        what cannot be compiled.

    Raises
    ------
    ValueError
        For what is not a plain function.
    """
    if not isinstance(function, FunctionType):
        rule = f"lienumba.jit takes a plain function, not a {type(function).__name__}"
        raise BadValueError(rule, "write it with def")
    if function.__qualname__.rpartition(".")[0].rpartition(".")[2] not in ("", "<locals>"):
        rule = f"lienumba.jit takes a plain function, not the method {function.__qualname__}"
        raise BadValueError(rule, "write it outside of the class")
    for x in inspect.signature(function).parameters.values():
        if x.kind not in (x.POSITIONAL_ONLY, x.POSITIONAL_OR_KEYWORD):
            raise BadValueError(f"{function.__name__} takes {x}", "name each argument, and give it in its place")
    return Jitted(function)


@functools.cache
def _numba() -> str:
    """Numba's version, which is not imported for that."""
    return f"numba {version('numba')}"


@functools.cache
def _sources() -> str:
    """A digest of SOURCES."""
    places = (cache.PACKAGE / name for name in SOURCES)
    files = sorted(path for place in places for path in ([place] if place.is_file() else place.rglob("*.py")))
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in files)).hexdigest()
