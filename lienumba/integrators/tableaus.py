"""Explicit Runge-Kutta methods as data."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from lienumba.integrators.coefficients import DOP853, DOP853_B, DP54, DP54_B, TSIT54, TSIT54_B

Row = tuple[Fraction, ...]


@dataclass(frozen=True)
class Tableau:
    """A (strictly lower rows), b, c of an explicit method, and its order.

    first: of a commutator-free method, the weights of the first of two exponentials in each stage and at the end, or
    none where there is but one.
    """

    name: str
    order: int
    A: tuple[Row, ...]
    b: Row
    first: tuple[Row, ...] = ()

    @property
    def c(self) -> Row:
        return tuple(sum(row, Fraction(0)) for row in self.A)

    def exponentials(self, stage: int) -> tuple[Row, ...]:
        """The weights of each exponential of a stage; behind the last stage, of the end."""
        row = (*self.A, self.b)[stage]
        first = self.first[stage] if self.first else ()
        return (first, tuple(a - f for a, f in zip(row, first, strict=True))) if first else (row,)


def _tableau(name: str, order: int, A: Sequence[str], b: str, first: Sequence[str] = ()) -> Tableau:
    return Tableau(name, order, tuple(map(_row, A)), _row(b), tuple(map(_row, first)))


def _row(text: str) -> Row:
    return tuple(map(Fraction, text.split()))


TABLEAUS = {
    tableau.name: tableau
    for tableau in (
        _tableau("euler", 1, [""], "1"),
        _tableau("midpoint", 2, ["", "1/2"], "0 1"),
        _tableau("heun", 2, ["", "1"], "1/2 1/2"),
        _tableau("kutta3", 3, ["", "1/2", "-1 2"], "1/6 2/3 1/6"),
        _tableau("rk4", 4, ["", "1/2", "0 1/2", "0 0 1"], "1/6 1/3 1/3 1/6"),
        _tableau(  # Celledoni, Marthinsen, Owren (2003)
            "cf4",
            4,
            ["", "1/2", "0 1/2", "0 0 1"],
            "1/6 1/3 1/3 1/6",
            first=["", "", "", "1/2 0 0", "1/4 1/6 1/6 -1/12"],
        ),
        _tableau("rk38", 4, ["", "1/3", "-1/3 1", "1 -1 1"], "1/8 3/8 3/8 1/8"),
        _tableau("bs32", 3, ["", "1/2", "0 3/4"], "2/9 1/3 4/9"),
        _tableau("dp54", 5, DP54, DP54_B),
        _tableau("tsit54", 5, TSIT54, TSIT54_B),
        _tableau("dop853", 8, DOP853, DOP853_B),
    )
}
