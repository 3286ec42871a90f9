"""Jets: a number with its first and second derivative in time; dual numbers, with the first alone; derivatives along
several directions in one pass.

They turn a residual into its velocity and acceleration equations, on any kind of number: floats, arrays, symbols.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lienumba.numerics import operations
from lienumba.numerics.number import Condition, Number
from lienumba.numerics.operations import divide


class Jet:
    """value, first and second time derivative."""

    __slots__ = ("a", "b", "c")
    __array_ufunc__ = None
    a: Any
    b: Any
    c: Any

    def __init__(self, a: Number, b: Number = 0.0, c: Number = 0.0) -> None:
        self.a, self.b, self.c = a, b, c

    def _chain(self, f: Number, f1: Number, f2: Number) -> "Jet":
        """f(self), with f1, f2 the derivatives of f at the value."""
        return Jet(f, f1 * self.b, f2 * (self.b * self.b) + f1 * self.c)

    def __add__(self, other: Number) -> "Jet":
        o = lift(other)
        return Jet(self.a + o.a, self.b + o.b, self.c + o.c)

    __radd__ = __add__

    def __sub__(self, other: Number) -> "Jet":
        o = lift(other)
        return Jet(self.a - o.a, self.b - o.b, self.c - o.c)

    def __rsub__(self, other: Number) -> "Jet":
        return lift(other) - self

    def __neg__(self) -> "Jet":
        return Jet(-self.a, -self.b, -self.c)

    def __mul__(self, other: Number) -> "Jet":
        o = lift(other)
        return Jet(
            self.a * o.a, self.b * o.a + self.a * o.b, self.c * o.a + 2.0 * (self.b * o.b) + self.a * o.c
        )  # fmt: skip

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> "Jet":
        o = lift(other)
        q = divide(self.a, o.a)
        dq = divide(self.b - q * o.b, o.a)
        return Jet(q, dq, divide(self.c - 2.0 * (dq * o.b) - q * o.c, o.a))

    def __rtruediv__(self, other: Number) -> "Jet":
        return lift(other) / self

    def __pos__(self) -> "Jet":
        return self

    def __abs__(self) -> Number:
        return operations.absolute(self)

    def __pow__(self, p: Number) -> Number:
        return operations.power(self, p)

    def __lt__(self, other: Number) -> Condition:
        return self.a < lift(other).a

    def __le__(self, other: Number) -> Condition:
        return self.a <= lift(other).a

    def __gt__(self, other: Number) -> Condition:
        return self.a > lift(other).a

    def __ge__(self, other: Number) -> Condition:
        return self.a >= lift(other).a

    def where(self, condition: Condition, x: Number, y: Number) -> "Jet":
        x, y = lift(x), lift(y)
        for number in (x, y):
            if isinstance(number, Dual):
                return number.where(condition, x, y)
        return Jet(*(operations.where(condition, p, q) for p, q in ((x.a, y.a), (x.b, y.b), (x.c, y.c))))

    def sqrt(self) -> "Jet":
        root = operations.sqrt(self.a)
        slope = divide(0.5, root)
        return self._chain(root, slope, divide(-0.5 * slope, self.a))

    def sin(self) -> "Jet":
        s, c = operations.sin(self.a), operations.cos(self.a)
        return self._chain(s, c, -s)

    def cos(self) -> "Jet":
        s, c = operations.sin(self.a), operations.cos(self.a)
        return self._chain(c, -s, -c)

    def exp(self) -> "Jet":
        e = operations.exp(self.a)
        return self._chain(e, e, e)

    def log(self) -> "Jet":
        slope = divide(1.0, self.a)
        return self._chain(operations.log(self.a), slope, -slope * slope)

    def power(self, p: Number) -> Number:
        """p: a number that is not whole, or a jet."""
        if isinstance(p, Jet):
            return operations.exp(p * self.log())
        power = operations.power
        return self._chain(power(self.a, p), p * power(self.a, p - 1.0), (p * (p - 1.0)) * power(self.a, p - 2.0))

    def atan2(self, y: Number, x: Number) -> "Jet":
        y, x = lift(y), lift(x)
        for number in (y, x):
            if isinstance(number, Dual):
                return number.atan2(y, x)
        square = x.a * x.a + y.a * y.a
        rate = divide(x.a * y.b - y.a * x.b, square)
        bend = x.a * y.c - y.a * x.c - 2.0 * (rate * (x.a * x.b + y.a * y.b))
        return Jet(operations.atan2(y.a, x.a), rate, divide(bend, square))


def lift(x: Number) -> Jet:
    return x if isinstance(x, Jet) else Jet(x)


class Dual(Jet):
    """value and first derivative: the same operations as those of a jet, where nobody asks for the second."""

    __slots__ = ()

    def __init__(self, a: Number, b: Number = 0.0) -> None:
        self.a, self.b = a, b

    def _chain(self, f: Number, f1: Number, f2: Number) -> "Dual":
        return Dual(f, f1 * self.b)

    def __add__(self, other: Number) -> "Dual":
        o = lift(other)
        return Dual(self.a + o.a, self.b + o.b)

    __radd__ = __add__

    def __sub__(self, other: Number) -> "Dual":
        o = lift(other)
        return Dual(self.a - o.a, self.b - o.b)

    def __rsub__(self, other: Number) -> "Dual":
        o = lift(other)
        return Dual(o.a - self.a, o.b - self.b)

    def __neg__(self) -> "Dual":
        return Dual(-self.a, -self.b)

    def __mul__(self, other: Number) -> "Dual":
        o = lift(other)
        return Dual(self.a * o.a, self.b * o.a + self.a * o.b)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> "Dual":
        return _quotient(self, lift(other))

    def __rtruediv__(self, other: Number) -> "Dual":
        return _quotient(lift(other), self)

    def where(self, condition: Condition, x: Number, y: Number) -> "Dual":
        x, y = lift(x), lift(y)
        return Dual(operations.where(condition, x.a, y.a), operations.where(condition, x.b, y.b))

    def atan2(self, y: Number, x: Number) -> "Dual":
        y, x = lift(y), lift(x)
        square = x.a * x.a + y.a * y.a
        return Dual(operations.atan2(y.a, x.a), divide(x.a * y.b - y.a * x.b, square))


def _quotient(x: Jet, y: Jet) -> Dual:
    q = divide(x.a, y.a)
    return Dual(q, divide(x.b - q * y.b, y.a))


class Directions:
    """The derivatives of a number along several directions in one pass: one row per direction, one column per run, or
    one column for all of them.

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
