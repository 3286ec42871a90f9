"""Tables: functions of one number that are known at points, in straight-line code whatever their length; and samples at
equal intervals, which each run has of its own.

A table is a piecewise polynomial. Its numbers lie in memory, row by row: where a piece begins, and its coefficients;
a kernel gets their address as a parameter, so that another table compiles nothing. In front of the first point and
behind the last one the values there are kept, or it is 0, or not a number, which ends a run.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import gather, maximum, minimum, where
from lienumba.numerics.vector_math import round_to_integer

HOLD, LINEAR, CUBIC = "hold", "linear", "cubic"
HELD = 2  # columns: pieces with a value alone
SMOOTH = 3  # columns: pieces with more are cubic, and meet twice differentiably
INTERPOLATIONS = (HOLD, LINEAR, CUBIC)
ZERO, ERROR = 0, "error"
OUTSIDE = (HOLD, ZERO, ERROR)  # what a table is in front of its first point and behind its last one
ON_SAMPLE = 1e-9  # of an interval: so near before a sample it is reached


class Numbers:
    """Numbers in memory, which kernels get by their address."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    @property
    def address(self) -> float:
        """The number whose bits are the address."""
        return float(np.array([self.array.ctypes.data], np.int64).view(np.float64)[0])

    def gather(self, index: Number) -> Any:
        found = self.array[np.asarray(index).astype(np.int64)]
        return float(found) if found.ndim == 0 else found


class RunNumbers(ABC):
    """Numbers in memory that each run has of its own."""

    @abstractmethod
    def part(self, runs: Any) -> "RunNumbers":
        """The numbers of some of the runs (indices or a slice)."""

    @abstractmethod
    def rows(self) -> np.ndarray:
        """(runs, numbers), one run behind the other."""

    @abstractmethod
    def gather(self, index: Number) -> Any:
        """The number of each run at its index."""


@dataclass(frozen=True)
class Table:
    """data: (pieces, columns) of Numbers, or what stands for them in a kernel; knots: where steps have to land, because
    the function or its rate may jump there; first, last: the first and the last point; outside: of `OUTSIDE`, None
    where nothing is said."""

    data: Any
    pieces: int
    columns: int
    knots: tuple[float, ...] = field(compare=False)  # this and what follows are told by the data
    first: float = field(compare=False)
    last: float = field(compare=False)
    outside: str | int | None = field(compare=False)

    @staticmethod
    def of(
        points: Sequence[float], values: Sequence[float], interpolation: str, outside: str | int | None = None
    ) -> "Table":
        """Through these points, which ascend; at least two."""
        x, y = np.array(points, float), np.array(values, float)
        coefficients = {HOLD: _hold, LINEAR: _linear, CUBIC: _cubic}[interpolation](x, y)
        constant = np.zeros(coefficients.shape[1] - 1)
        ends = [0.0, 0.0] if outside == ZERO else [nan, nan] if outside == ERROR else [y[0], y[-1]]
        before, behind = (np.array([x[n], value, *constant]) for n, value in zip((0, -1), ends, strict=True))
        rows = np.vstack([before, np.column_stack([x[:-1], coefficients]), behind])
        knots = (float(x[0]), float(x[-1])) if interpolation == CUBIC else tuple(x.tolist())
        data = Numbers(np.ascontiguousarray(rows).reshape(-1))
        return Table(data, len(rows), rows.shape[1], knots, float(x[0]), float(x[-1]), outside)

    def __call__(self, x: Number, within: Number) -> Any:
        """The value at x, by the piece in which `within` lies."""
        piece = self.columns * self._within(lift(x).a, lift(within).a)
        start, value, *slopes = (gather(self.data, piece + float(n)) for n in range(self.columns))
        d, power = x - start, 1.0
        for c in slopes:
            power = power * d
            value = value + c * power
        return value if slopes else where(d <= d, value, d)  # NaN stays NaN

    def _within(self, x: Number, within: Number) -> Any:
        """The piece of x; where pieces do not meet smoothly, that of `within`. The last point still belongs to what is
        in front of it, but for values that are held."""
        if self.columns == HELD:
            return self._piece(within)
        edge, end = self._piece(within), self.pieces - 1.0
        inside = maximum(minimum(self._piece(x) if self.columns > SMOOTH else edge, end - 1.0), 1.0)
        beyond = within > gather(self.data, self.columns * end)
        return where(edge < 1.0, 0.0, where(beyond, end, inside))

    def _piece(self, x: Number) -> Any:
        """The number of the last piece that begins at or before x, by bisection; 0 if there is none."""
        i: Any = 0.0
        for n in reversed(range((self.pieces - 1).bit_length())):
            next_ = minimum(i + float(2**n), float(self.pieces - 1))
            i = where(gather(self.data, self.columns * next_) <= x, next_, i)
        return i


@dataclass(frozen=True)
class Samples:
    """A function of the time that is known at equal intervals from 0 on: held until the next sample, or linear between
    them. data: of `RunNumbers`, or what stands for them in a kernel; every: the interval in s; last: the number of the
    last sample; knots: where steps have to land."""

    data: Any
    every: Any
    last: Any
    held: bool
    knots: tuple[float, ...] = field(compare=False)

    def __call__(self, x: Number, within: Number) -> Any:
        """The value at x, by the interval in which `within` lies."""
        piece = _floor(lift(within).a / self.every + ON_SAMPLE)
        piece = maximum(minimum(piece, self.last), 0.0)
        value = gather(self.data, piece)
        if self.held:
            return value
        after = gather(self.data, minimum(piece + 1.0, self.last))
        return value + (x / self.every - piece) * (after - value)


def _floor(x: Number) -> Any:
    """The largest whole number that is not above x, below 2**51."""
    nearest = round_to_integer(x)
    return where(nearest > x, nearest - 1.0, nearest)


def _hold(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return y[:-1, None]


def _linear(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.column_stack([y[:-1], np.diff(y) / np.diff(x)])


def _cubic(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The twice differentiable spline whose third derivative does not jump at the second and the last but one point.

    Elementwise, so that no library decides on its bits. The slopes s solve a tridiagonal system.
    """
    n, h = len(x), np.diff(x)
    m = np.diff(y) / h
    if n == 2:
        return np.column_stack([y[:-1], m, 0.0 * m, 0.0 * m])
    if n == 3:
        bend = (m[1] - m[0]) / (x[2] - x[0])
        s = np.array([m[0] - h[0] * bend, m[0] + h[0] * bend, m[1] + h[1] * bend])
    else:
        low, high = np.append(h[1:], x[-1] - x[-3]), np.append(x[2] - x[0], h[:-1])
        middle = np.concatenate([h[1:2], 2.0 * (x[2:] - x[:-2]), h[-2:-1]])
        right = np.zeros(n)
        right[1:-1] = 3.0 * (h[1:] * m[:-1] + h[:-1] * m[1:])
        d = x[2] - x[0]
        right[0] = ((h[0] + 2.0 * d) * h[1] * m[0] + h[0] ** 2 * m[1]) / d
        d = x[-1] - x[-3]
        right[-1] = (h[-1] ** 2 * m[-2] + (2.0 * d + h[-1]) * h[-2] * m[-1]) / d
        s = _tridiagonal(low.tolist(), middle.tolist(), high.tolist(), right.tolist())
    bend = (s[:-1] + s[1:] - 2.0 * m) / h
    return np.column_stack([y[:-1], s[:-1], (m - s[:-1]) / h - bend, bend / h])


def _tridiagonal(low: list[float], middle: list[float], high: list[float], right: list[float]) -> np.ndarray:
    """Thomas' algorithm."""
    for i in range(1, len(middle)):
        factor = low[i - 1] / middle[i - 1]
        middle[i] -= factor * high[i - 1]
        right[i] -= factor * right[i - 1]
    s = [0.0] * len(middle)
    s[-1] = right[-1] / middle[-1]
    for i in reversed(range(len(middle) - 1)):
        s[i] = (right[i] - high[i] * s[i + 1]) / middle[i]
    return np.array(s)
