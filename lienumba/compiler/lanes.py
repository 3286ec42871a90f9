"""Lanes in routines: vectors of W doubles, one lane per run, and masks of W bits.

These functions have a meaning in routines alone (`lienumba.compiler.routines.intrinsics`). Nothing is ever contracted
or reassociated. Lanes are Any to the type checker where == gives masks of them, which it does not believe.
"""

from typing import Any, NoReturn, Protocol

import numpy as np

from lienumba.numerics.number import Number

Address = int  # of a row of lanes
Lanes = Number  # one number per lane


class Mask(Protocol):
    """Some lanes."""

    def __and__(self, other: "Mask", /) -> "Mask": ...
    def __or__(self, other: "Mask", /) -> "Mask": ...


def _compiled(*given: object) -> NoReturn:
    raise NotImplementedError("this has a meaning in compiled routines alone")


def splat(x: float) -> Any:
    """A float in every lane."""
    _compiled(x)


def choose(mask: Mask | bool, x: Lanes | float, y: Lanes | float) -> Any:
    """x in the lanes where the mask holds, else y."""
    _compiled(mask, x, y)


def fma(a: Lanes, b: Lanes, c: Lanes) -> Any:
    """a b + c, rounded once."""
    _compiled(a, b, c)


def any_lane(mask: Mask | bool) -> bool:
    """Whether the mask holds in some lane."""
    _compiled(mask)


def all_lanes(mask: Mask | bool) -> bool:
    """Whether the mask holds in every lane."""
    _compiled(mask)


def load(base: Address, row: int) -> Any:
    """The W doubles of a row of the flat array at address `base`."""
    _compiled(base, row)


def store(base: Address, row: int, value: Lanes) -> None:
    """Write a row of the flat array at address `base`."""
    _compiled(base, row, value)


def call(
    address: Address, state: Address, parameters: Address, clock: Address, extra: Address, out: Address, work: Address
) -> None:
    """Call the kernel at `address` (see `lienumba.compiler.emit`) with six addresses."""
    _compiled(address, state, parameters, clock, extra, out, work)


def matrix(address: Address, rows: int, columns: int) -> np.ndarray:
    """The doubles at an address as an array (rows, columns)."""
    _compiled(address, rows, columns)
