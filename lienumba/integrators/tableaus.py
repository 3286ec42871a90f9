"""Explicit Runge-Kutta methods as data."""

from dataclasses import dataclass
from fractions import Fraction


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


def _tableau(name: str, order: int, A: list[list[str]], b: str) -> Tableau:
    return Tableau(
        name, order, tuple(tuple(Fraction(x) for x in row) for row in A), tuple(Fraction(x) for x in b.split())
    )


TABLEAUS = {
    tableau.name: tableau
    for tableau in (
        _tableau("euler", 1, [[]], "1"),
        _tableau("midpoint", 2, [[], ["1/2"]], "0 1"),
        _tableau("heun", 2, [[], ["1"]], "1/2 1/2"),
        _tableau("kutta3", 3, [[], ["1/2"], ["-1", "2"]], "1/6 2/3 1/6"),
        _tableau("rk4", 4, [[], ["1/2"], ["0", "1/2"], ["0", "0", "1"]], "1/6 1/3 1/3 1/6"),
        _tableau("rk38", 4, [[], ["1/3"], ["-1/3", "1"], ["1", "-1", "1"]], "1/8 3/8 3/8 1/8"),
    )
}
