"""Explicit Runge-Kutta methods as data."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from lienumba.integrators.coefficients import DOP853, DOP853_B, DP54, DP54_B, TSIT54, TSIT54_B


@dataclass(frozen=True)
class Tableau:
    """A (strictly lower rows), b, c of an explicit method, and its order."""

    name: str
    order: int
    A: tuple[tuple[Fraction, ...], ...]
    b: tuple[Fraction, ...]

    @property
    def c(self) -> tuple[Fraction, ...]:
        return tuple(sum(row, Fraction(0)) for row in self.A)


def _tableau(name: str, order: int, A: Sequence[str], b: str) -> Tableau:
    return Tableau(name, order, tuple(map(_row, A)), _row(b))


def _row(text: str) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, text.split()))


TABLEAUS = {
    tableau.name: tableau
    for tableau in (
        _tableau("euler", 1, [""], "1"),
        _tableau("midpoint", 2, ["", "1/2"], "0 1"),
        _tableau("heun", 2, ["", "1"], "1/2 1/2"),
        _tableau("kutta3", 3, ["", "1/2", "-1 2"], "1/6 2/3 1/6"),
        _tableau("rk4", 4, ["", "1/2", "0 1/2", "0 0 1"], "1/6 1/3 1/3 1/6"),
        _tableau("rk38", 4, ["", "1/3", "-1/3 1", "1 -1 1"], "1/8 3/8 3/8 1/8"),
        _tableau("bs32", 3, ["", "1/2", "0 3/4"], "2/9 1/3 4/9"),
        _tableau("dp54", 5, DP54, DP54_B),
        _tableau("tsit54", 5, TSIT54, TSIT54_B),
        _tableau("dop853", 8, DOP853, DOP853_B),
    )
}
