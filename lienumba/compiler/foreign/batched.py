"""`lienumba.batched`: a function of Python that gets arrays of runs, called from sampled laws.

Kernels call it by its address, for the W runs of a block at a time. It always gets W numbers of each argument.
"""

import ctypes
import functools
import hashlib
import operator
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from types import FunctionType
from typing import Any

import numpy as np

from lienumba.compiler import native
from lienumba.compiler.foreign import wrappers
from lienumba.compiler.foreign.calls import KNOWN, PREFIX, TUPLES, Argument, Foreign, PythonFunction
from lienumba.compiler.foreign.identity import names_of
from lienumba.compiler.rows import W
from lienumba.errors import BadValueError

ADDRESSED = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)

_made: Counter[str] = Counter()  # how many functions of a name there are in this process
_kept: list[Any] = []  # what machine code calls


class Batched(PythonFunction):
    """A function of Python that gets arrays of runs, see `batched`."""

    def __init__(self, function: FunctionType, outputs: int) -> None:
        super().__init__(function)
        self.outputs = outputs
        name = f"{function.__module__}.{function.__qualname__}"
        self._name = f"{name} {_made[name]}"
        _made[name] += 1

    def identity(self) -> str:
        """Return a digest of the numbers, texts and arrays of its module that it reads. The scenario has its text."""
        digest = hashlib.sha256()
        for said in _read(self.py_func, set()):
            digest.update(said + b"\0")
        return digest.hexdigest()

    def compiled(self, arguments: Sequence[Argument]) -> Foreign:
        """The function behind an address of this process."""
        said = f"{self._name} {self.outputs} {arguments}"  # of a process; object code says nothing else of the function
        symbol = PREFIX + hashlib.sha256(said.encode()).hexdigest()[:32]
        if symbol not in KNOWN:
            outputs = self.outputs + sum(x.size for x in arguments if x.kind == "array")
            function = ADDRESSED(functools.partial(self._block, arguments, outputs))
            _kept.append(function)
            native.ADDRESSES[wrappers.address_of(symbol)] = ctypes.cast(function, ctypes.c_void_p).value or 0
            called, why = functools.partial(self._runs, arguments), "gets the runs of a block at once"
            text, scalar = wrappers.by_block(symbol), self.outputs == 1
            KNOWN[symbol] = Foreign(symbol, self.__name__, outputs, scalar, text, True, why, called)
        return KNOWN[symbol]

    def _runs(self, arguments: Sequence[Argument], given: np.ndarray) -> np.ndarray:
        """Compute outputs (outputs, runs) of arguments (numbers, runs), W runs at a time. Raises its errors."""
        runs = given.shape[1]
        if runs == W:
            return self._outputs(arguments, given.copy())
        padded = np.pad(given, ((0, 0), (0, -runs % W)), "edge")
        parts = [self._outputs(arguments, padded[:, n : n + W].copy()) for n in range(0, runs, W)]
        return np.concatenate(parts, axis=1)[:, :runs]

    def _outputs(self, arguments: Sequence[Argument], given: np.ndarray) -> np.ndarray:
        """Compute outputs (outputs, W) of arguments (numbers, W); a run with one that is not finite has NaN in all."""
        ends = np.cumsum([x.size for x in arguments])
        parts = [given[end - x.size : end] for x, end in zip(arguments, ends, strict=True)]
        given_as: dict[str, Callable[[np.ndarray], Any]] = {
            "number": operator.itemgetter(0),
            "tuple": tuple,
            "array": np.asarray,
        }
        found = self.py_func(*(given_as[x.kind](rows) for x, rows in zip(arguments, parts, strict=True)))
        listed = found if isinstance(found, TUPLES) or np.ndim(found) == 2 else (found,)
        shapes = [np.shape(x) for x in listed]
        if any(np.iscomplexobj(x) for x in listed):
            raise BadValueError(f"{self.__name__} returns complex numbers", "return real ones")
        if found is None or len(shapes) != self.outputs or not {*shapes} <= {(), (W,)}:
            kind = "nothing" if found is None else f"shapes {shapes}"
            rule = f"{self.__name__} must return {self.outputs} arrays of shape ({W},), but returns {kind}"
            raise BadValueError(rule, "return a number of each output for each run, or correct outputs")
        own = np.empty((self.outputs, W))
        for n, x in enumerate(listed):
            own[n] = x
        values = np.concatenate([own, *(rows for x, rows in zip(arguments, parts, strict=True) if x.kind == "array")])
        finite = np.isfinite(values)
        return values if finite.all() else np.where(finite.all(axis=0), values, np.nan)

    def _block(self, arguments: Sequence[Argument], outputs: int, given: int, found: int, lanes: int) -> None:
        """Evaluate a block of runs for a kernel: given (numbers, lanes) and found (outputs, lanes) are addresses.

        Failed runs get the arguments of a run that has not failed. If the function raises, it is called for each run
        apart, so that the runs in which it raises fail alone.
        """
        left, rows = _numbers(found, outputs, lanes), _numbers(given, sum(x.size for x in arguments), lanes)
        left[:] = np.nan
        good = ~np.isnan(rows).any(axis=0)
        if not good.any():
            return
        whole = good.all()
        filled = rows if whole else np.where(good, rows, rows[:, [good.argmax()]])
        try:
            values = self._runs(arguments, filled)
            left[:] = values if whole else np.where(good, values, np.nan)
        except Exception:
            for lane in np.flatnonzero(good).tolist():
                self._alone(arguments, filled, left, lane)

    def _alone(self, arguments: Sequence[Argument], given: np.ndarray, left: np.ndarray, lane: int) -> None:
        """Call it for one run, in its place among equal ones."""
        try:
            left[:, lane] = self._runs(arguments, np.repeat(given[:, [lane]], given.shape[1], axis=1))[:, lane]
        except Exception as error:
            said = f"{self.__name__} raised {type(error).__name__}: {error}; the run fails"
            with suppress(Warning):
                warnings.warn(said, RuntimeWarning, stacklevel=1)


def batched(function: object = None, /, *, outputs: int = 0) -> Callable[[Callable[..., Any]], Batched]:
    """Let sampled laws call a function of Python that gets arrays of runs, such as a policy network.

    It may use any package. It is called at every sample (`every`) for the eight runs of a block at once, by one thread
    after the other, and must treat each run by itself: the numbers of a run must not depend on the other runs, on their
    order, or on earlier calls. A call with the runs in another order checks this before runs begin. Then a run has the
    same bits for any number of workers. Where it raises, or returns what is not finite, that run fails alone. It has no
    derivative: potential energies, joints and equilibria exclude it.

    Parameters
    ----------
    function : None
        Left out: the decorator needs `outputs`.
    outputs : int
        How many numbers it returns for each run.

    Returns
    -------
    callable
        The decorator, for a function of arrays (8,), or of tuples of them, that returns an array (8,), a tuple of them,
        or an array (outputs, 8). Of a law's memory it gets an array (size, 8), and what it writes there is kept. The
        arrays and numbers of its module that it reads are part of the hash of scenarios.

    Raises
    ------
    ValueError
        For what is not a plain function, and for outputs below 1.
    """
    if not isinstance(outputs, int) or isinstance(outputs, bool) or outputs < 1:
        rule = f"outputs = {outputs!r} must be a whole number from 1 on" if function is None else "outputs is missing"
        raise BadValueError(rule, "write @lienumba.batched(outputs=1)")

    def decorated(function: Callable[..., Any]) -> Batched:
        if not isinstance(function, FunctionType):
            rule = f"lienumba.batched takes a plain function, not a {type(function).__name__}"
            raise BadValueError(rule, "write it with def")
        return Batched(function, outputs)

    return decorated


def _numbers(address: int, rows: int, lanes: int) -> np.ndarray:
    """View numbers in memory as an array (rows, lanes)."""
    return np.ndarray((rows, lanes), np.float64, memoryview((ctypes.c_double * (rows * lanes)).from_address(address)))


def _read(function: FunctionType, seen: set[int]) -> Iterator[bytes]:
    """Yield what a function, and functions of its module that it calls, read of the module."""
    seen.add(id(function))
    for name in sorted(names_of(function)):
        x = function.__globals__.get(name)
        x = getattr(x, "py_func", x)
        if isinstance(x, FunctionType) and x.__globals__ is function.__globals__:
            yield from () if id(x) in seen else _read(x, seen)
        else:
            yield from (name.encode(), *_value(x))


def _value(x: Any) -> Iterator[bytes]:
    """Yield the content of a value; nothing of an object of an unknown type."""
    if isinstance(x, bool | int | float | complex | str | bytes | None):
        yield repr(x).encode()
    elif isinstance(x, np.ndarray | np.generic) and x.dtype != object:
        yield repr((x.dtype.str, x.shape)).encode() + x.tobytes()
    elif isinstance(x, tuple | list | dict):
        for inner in x.items() if isinstance(x, dict) else x:
            yield from _value(inner)
