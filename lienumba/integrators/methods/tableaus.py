"""Explicit Runge-Kutta methods as data."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lienumba.integrators.methods import coefficients as published

Row = tuple[Fraction, ...]


@dataclass(frozen=True)
class Tableau:
    """A (strictly lower rows), b, c of an explicit method, and its order.

    `errors`: for embedded pairs, the weights of one or two estimates of the error in the stages and, last, in F at the
    end of the step; `D`: see `extension`; `more`: rows of the stages behind that one, which only the extension needs;
    `first`: of a commutator-free method, the weights of the first of two exponentials in each stage and at the end, or
    none where there is but one.
    """

    name: str
    order: int
    A: tuple[Row, ...]
    b: Row
    errors: tuple[Row, ...] = ()
    D: tuple[Row, ...] = ()
    more: tuple[Row, ...] = ()
    first: tuple[Row, ...] = ()

    @property
    def c(self) -> Row:
        return tuple(sum(row, Fraction(0)) for row in self.A)

    @property
    def stages(self) -> tuple[Row, ...]:
        """The rows of all stages: those of a step, F at its end, and those of the continuous extension."""
        return (*self.A, self.b, *self.more)

    def exponentials(self, stage: int) -> tuple[Row, ...]:
        """The weights of each exponential of one of the stages."""
        row = self.stages[stage]
        first = self.first[stage] if self.first else ()
        return (first, tuple(a - f for a, f in zip(row, first, strict=True))) if first else (row,)

    def extension(self, s: Any, number: Callable[[Fraction], Any] = Fraction) -> tuple[Any, ...]:
        """The weights of all stages in the continuous extension at the fraction s of a step: nested as in Hairer,
        Norsett and Wanner (1993), section II.6; without D it is Hermite's cubic. number: what coefficients become."""
        stages = range(len(self.stages))
        b = (*self.b, *[Fraction(0)] * (len(stages) - len(self.b)))
        first, last = ([Fraction(i == place) for i in stages] for place in (0, len(self.b)))
        layers = [b, [f - w for f, w in zip(first, b, strict=True)]]
        layers += [[2 * w - f - g for w, f, g in zip(b, first, last, strict=True)]]
        layers += [(*row, *[Fraction(0)] * (len(stages) - len(row))) for row in self.D]
        total = [number(Fraction(0)) for _ in stages]
        for n, layer in reversed(list(enumerate(layers))):
            total = [(s if n % 2 == 0 else 1 - s) * (number(w) + x) for w, x in zip(layer, total, strict=True)]
        return tuple(total)


def _tableau(
    name: str, order: int, A: Sequence[str], b: str, E: Sequence[str] = (), D: Sequence[str] = (),
    more: Sequence[str] = (), first: Sequence[str] = (),
) -> Tableau:  # fmt: skip
    return Tableau(name, order, _rows(A), _row(b), _rows(E), _rows(D), _rows(more), _rows(first))


def _rows(texts: Sequence[str]) -> tuple[Row, ...]:
    return tuple(map(_row, texts))


def _row(text: str) -> Row:
    return tuple(map(Fraction, text.split()))


def _less(b: str, hat: str) -> str:
    """b - hat."""
    return " ".join(str(x - y) for x, y in zip(_row(b), _row(hat), strict=True))


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
        _tableau("bs32", 3, ["", "1/2", "0 3/4"], "2/9 1/3 4/9", ["-5/72 1/12 1/9 -1/8"]),
        _tableau("dp54", 5, published.DP54, published.DP54_B, [published.DP54_E], [published.DP54_D]),
        _tableau("tsit54", 5, published.TSIT54, published.TSIT54_B, [published.TSIT54_E], [published.TSIT54_D]),
        _tableau(
            "dop853", 8, published.DOP853, published.DOP853_B,
            [published.DOP853_E5, _less(published.DOP853_B, published.DOP853_HAT)],
            published.DOP853_D, published.DOP853_MORE,
        ),
    )
}  # fmt: skip
