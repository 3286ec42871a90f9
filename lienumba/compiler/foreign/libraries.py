"""`lienumba.foreign`: a function of a shared library, as of C, called from laws that are traced.

Its code is known by the digest of the library's file, by its symbol and by its sizes.
"""

import ctypes
import hashlib
import operator
import os
import sys
from _ctypes import CFuncPtr
from dataclasses import replace
from typing import Any

from lienumba.compiler import native
from lienumba.compiler.foreign import wrappers
from lienumba.compiler.foreign.calls import KNOWN, PREFIX, Foreign, Function, flat
from lienumba.errors import BadValueError
from lienumba.laws import Memory

LOAD = "load the library with ctypes.CDLL(path), and name its function"
KEEPS = "keeps states from call to call"

_files: dict[int, str] = {}  # the digest of the file of each library, by where it is loaded


class LibraryFunction(Function):
    """A function of a shared library, see `foreign`."""

    def __init__(self, function: Any, inputs: int, outputs: int, states: int) -> None:
        if not isinstance(function, CFuncPtr):
            raise BadValueError(f"lienumba.foreign takes a function of ctypes, not a {type(function).__name__}", LOAD)
        address = ctypes.cast(function, ctypes.c_void_p).value or 0
        path, base, name = _library(address)
        self.__name__ = str(getattr(function, "__name__", name))
        self.inputs, self.outputs, self.states = inputs, outputs, states
        sizes = f"inputs={inputs}, outputs={outputs}, states={states}"
        self._made_by = f"lienumba.foreign(ctypes.CDLL({path!r}).{self.__name__}, {sizes})"
        self._identity = f"{_digest(path, base)} {self.__name__} {sizes}"
        symbol = PREFIX + hashlib.sha256(self._identity.encode()).hexdigest()[:32]
        text = wrappers.by_lane(symbol, inputs, states, outputs)
        every = KEEPS if states else ""
        self._made = Foreign(symbol, self.__name__, outputs + states, outputs + states == 1, text, True, every)
        native.ADDRESSES[wrappers.address_of(symbol)] = address
        KNOWN[symbol] = self._made

    def __call__(self, *inputs: object, states: object = ()) -> Any:
        """Its outputs, then its next states: symbols of the graph of its arguments, or on floats and arrays of runs
        numbers like them. Where its states are a law's memory, the next ones are written there instead."""
        given, x = flat(self.__name__, inputs), flat(self.__name__, (states,))
        for kind, numbers, size in (("inputs", given, self.inputs), ("states", x, self.states)):
            if len(numbers) != size:
                rule = f"{self.__name__} gets {len(numbers)} {kind}, but has {size}"
                raise BadValueError(rule, f"give it {size}, or write {kind}={len(numbers)} in lienumba.foreign")
        if isinstance(states, Memory):
            return replace(self._made, scalar=self.outputs == 1).called([*given, *x], [states])
        return self._made.called([*given, *x])

    def identity(self) -> str:
        """Return the digest of its library, its symbol and its sizes."""
        return self._identity

    def written(self, name: str) -> str:
        """Return Python code that makes it, under this name."""
        return f"import ctypes\nimport lienumba\n{name} = {self._made_by}\n"


def foreign(function: Any, *, inputs: int, outputs: int, states: int = 0) -> LibraryFunction:
    """Let laws in Python call a function of a shared library, such as flight code or generated code.

    In C it is  ``void step(const double *u, double *x, double *y)``,  and is called for one run at a time: u are its
    inputs, y its outputs, and x its states, which it reads and replaces by the next ones. It is called by several
    threads at a time and must keep nothing else between calls; so it gives the same bits whenever it is called with
    the same numbers, which is checked before runs begin. Where an output or a state is not finite, that run fails
    alone. It has no derivative: a law that calls it, and is not sampled (`every`), excludes `taylor`, implicit methods,
    `linearise` and `modes`; potential energies, joints and equilibria exclude it. With states the law has to be
    sampled.

    Parameters
    ----------
    function : ctypes function
        Of a library, as ``ctypes.CDLL(path).step``. The digest of the library's file is part of the hash of scenarios.
    inputs, outputs, states : int
        How many numbers u, y and x have.

    Returns
    -------
    callable
        For laws. It takes `inputs` numbers, or tuples of numbers, and by name `states`, a tuple of numbers. It returns
        a tuple of the outputs and the next states, or one number if there is only one. If `states` is an array of the
        law's memory, the next ones are written there, and it returns the outputs.

    Raises
    ------
    ValueError
        For what is not a function of a library, and for sizes below 0.
    """
    sizes = {"inputs": inputs, "outputs": outputs, "states": states}
    for name, size in sizes.items():
        if not hasattr(size, "__index__") or operator.index(size) < 0:
            raise BadValueError(f"{name} = {size!r} must be a whole number from 0 on", "count its numbers")
    if not outputs and not states:
        raise BadValueError("a function without outputs and states changes nothing", "give outputs=")
    return LibraryFunction(function, *map(operator.index, sizes.values()))


class _Place(ctypes.Structure):
    """Dl_info of the C library."""

    _fields_ = (
        ("file", ctypes.c_char_p),
        ("base", ctypes.c_void_p),
        ("name", ctypes.c_char_p),
        ("at", ctypes.c_void_p),
    )


def _library(address: int) -> tuple[str, int, str]:
    """Find the file of the library that has this address, where it is loaded, and the symbol there."""
    place = _Place()
    if not ctypes.CDLL(None).dladdr(ctypes.c_void_p(address), ctypes.byref(place)) or not place.file:
        raise BadValueError("the function given to lienumba.foreign is not of a shared library", LOAD)
    return os.path.realpath(os.fsdecode(place.file)), int(place.base or 0), os.fsdecode(place.name or b"")


def _digest(path: str, base: int) -> str:
    """Return the digest of a library's file. A process keeps the code that it has loaded if the file changes."""
    if sys.float_info.min * 0.5 == 0.0:
        rule = "numbers below 2e-308 have become 0, as by the library, which changes the bits of all runs"
        raise BadValueError(rule, "build it without -ffast-math")
    try:
        with open(path, "rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise BadValueError(f"the library {path} cannot be read: {error}", LOAD) from None
    if _files.setdefault(base, digest) != digest:
        rule = f"the library {path} has changed since this process loaded it, and its old code would run"
        raise BadValueError(rule, "start a new process, or give the new library another name")
    return digest
