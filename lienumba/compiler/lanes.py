"""Lanes in routines: vectors of W doubles, one lane per run, and masks of W bits.

These functions have a meaning in routines alone (`lienumba.compiler.routines.intrinsics`). Nothing is ever contracted
or reassociated.
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


def splat(x: float) -> Lanes:
    """A float in every lane."""
    _compiled(x)


def choose(mask: Any, x: Lanes | float, y: Lanes | float) -> Lanes:
    """x in the lanes where the mask holds, else y."""
    _compiled(mask, x, y)


def any_lane(mask: Any) -> bool:
    """Whether the mask holds in some lane."""
    _compiled(mask)


def all_lanes(mask: Any) -> bool:
    """Whether the mask holds in every lane."""
    _compiled(mask)


def load(base: Address, row: int) -> Lanes:
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
