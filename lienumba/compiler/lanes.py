"""Lanes in routines: vectors of W doubles, one lane per run, and masks of W bits.

The compiler of routines has its own meaning of these functions (`lienumba.compiler.routines.intrinsics`); here is the
same in NumPy, so that a driver also runs as plain Python, under a debugger or a measurement of coverage
(`lienumba.compiler.flat.plain`). Nothing is ever contracted or reassociated. Lanes are Any to the type checker where ==
gives masks of them, which it does not believe.
"""

import ctypes
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from lienumba.compiler.rows import ROW, W
from lienumba.numerics.number import Number

Address = int  # of a row of lanes
Lanes = Number  # one number per lane
_KERNEL = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)


class Mask(Protocol):
    """Some lanes."""

    def __and__(self, other: "Mask", /) -> "Mask": ...
    def __or__(self, other: "Mask", /) -> "Mask": ...


class _Values(np.ndarray[Any, Any]):
    """W doubles as a value: `+=` makes a new one."""

    def __iadd__(self, other: Any, /) -> Any:  # type: ignore[misc]
        return self + other


def splat(x: float) -> Any:
    """A float in every lane."""
    return np.full(W, float(x)).view(_Values)


def choose(mask: Mask | bool, x: Lanes | float, y: Lanes | float) -> Any:
    """x in the lanes where the mask holds, else y."""
    given: tuple[Any, ...] = (mask, x, y)
    return np.where(*given).view(_Values)


def fma(a: Lanes, b: Lanes, c: Lanes) -> Any:
    """a b + c, rounded once: in compiled routines alone."""
    raise NotImplementedError("NumPy rounds twice")


def any_lane(mask: Mask | bool) -> bool:
    """Whether the mask holds in some lane."""
    return bool(np.any(mask))  # type: ignore[arg-type]


def all_lanes(mask: Mask | bool) -> bool:
    """Whether the mask holds in every lane."""
    return bool(np.all(mask))  # type: ignore[arg-type]


def load(base: Address, row: int) -> Any:
    """The W doubles of a row of the flat array at address `base`."""
    return matrix(base + ROW * row, 1, W)[0].copy().view(_Values)


def store(base: Address, row: int, value: Lanes) -> None:
    """Write a row of the flat array at address `base`."""
    matrix(base + ROW * row, 1, W)[0] = value


def call(
    address: Address, state: Address, parameters: Address, clock: Address, extra: Address, out: Address, work: Address
) -> None:
    """Call the kernel at `address` (see `lienumba.compiler.emit`) with six addresses."""
    _function(int(address))(*map(int, (state, parameters, clock, extra, out, work)))


def matrix(address: Address, rows: int, columns: int) -> np.ndarray:
    """The doubles at an address as an array (rows, columns)."""
    numbers = (ctypes.c_double * (rows * columns)).from_address(int(address))
    found: np.ndarray = np.ctypeslib.as_array(numbers).reshape(rows, columns)
    return found


@lru_cache(maxsize=1024)
def _function(address: int) -> Any:
    return _KERNEL(address)
