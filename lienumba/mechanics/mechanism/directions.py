"""Derivatives along several directions in one pass, where numbers are floats or arrays of shape (runs,)."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lienumba.numerics.number import Condition, Number


class Directions:
    """The derivatives of a number: one row per direction, one column per run, or one column for all of them.

    known: they are floats, whatever the run, as long as no array took part.
    """

    __slots__ = ("known", "rows")
    __array_ufunc__ = None

    def __init__(self, rows: np.ndarray, known: bool) -> None:
        self.rows, self.known = rows, known

    def apart(self) -> list[Any]:
        """The derivative along each direction: a float, or an array of shape (runs,)."""
        return self.rows[:, 0].tolist() if self.known else list(self.rows)

    def __add__(self, other: "Number | Directions") -> "Directions":
        return Directions(self.rows + _rows(other), self.known and _known(other))

    __radd__ = __add__

    def __sub__(self, other: "Number | Directions") -> "Directions":
        return Directions(self.rows - _rows(other), self.known and _known(other))

    def __rsub__(self, other: "Number | Directions") -> "Directions":
        return Directions(_rows(other) - self.rows, self.known and _known(other))

    def __neg__(self) -> "Directions":
        return Directions(-self.rows, self.known)

    def __mul__(self, other: "Number | Directions") -> "Directions":
        return Directions(self.rows * _rows(other), self.known and _known(other))

    __rmul__ = __mul__

    def __truediv__(self, other: "Number | Directions") -> "Directions":
        return Directions(self.rows / _rows(other), self.known and _known(other))

    def where(self, condition: Condition, x: "Number | Directions", y: "Number | Directions") -> "Directions":
        return Directions(np.where(condition, _rows(x), _rows(y)), False)


def seeds(directions: Sequence[Sequence[float]]) -> list[Directions]:
    """The derivatives of each coordinate along these directions."""
    return [Directions(np.array(along, float)[:, None], True) for along in zip(*directions, strict=True)]


def go_together(numbers: Iterable[Number]) -> bool:
    """Whether these are numbers whose derivatives may be taken along several directions at once."""
    return all(isinstance(x, float) or (isinstance(x, np.ndarray) and x.ndim == 1) for x in numbers)


def _rows(x: Number | Directions) -> Any:
    return x.rows if isinstance(x, Directions) else x


def _known(x: Number | Directions) -> bool:
    return x.known if isinstance(x, Directions) else isinstance(x, float | int)
