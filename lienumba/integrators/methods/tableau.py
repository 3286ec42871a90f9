"""A Runge-Kutta method as a record."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lienumba.keys.literature import Reference
from lienumba.keys.registry import Registry
from lienumba.numerics.number import Number

Row = tuple[Fraction, ...]


@dataclass(frozen=True)
class Tableau:
    """A (strictly lower rows), b, c of an explicit method, or of one by collocation, and its order.

    `errors`: for embedded pairs, the weights of one or two estimates of the error in the stages and, last, in F at the
    end of the step; `D`: see `extension`; `more`: rows of the stages behind that one, which only the extension needs;
    `first`: of a commutator-free method, the weights of the first of two exponentials in each stage and at the end, or
    none where there is but one; `flat`: the method that this one is in a vector space; `words`: what a citation says of
    it, with [@key] for each of its `references`; `series`: whether a step is a power series in time, of which the rest
    says nothing but an order that may be another; `damping`: of an implicit method, the diagonal with which the
    estimate of its error is damped; `layers`: of one by collocation, the polynomials that are 1 at one of its nodes;
    `begun`: the same with the start of a step as a node before them; `carries`: whether a step goes on with what the
    one before has left (`generalized_alpha`).
    """

    name: str
    order: int
    words: str
    A: tuple[Row, ...]
    b: Row
    errors: tuple[Row, ...] = ()
    D: tuple[Row, ...] = ()
    more: tuple[Row, ...] = ()
    first: tuple[Row, ...] = ()
    flat: str = ""
    references: tuple[Reference, ...] = ()
    series: bool = False
    damping: Fraction = Fraction(0)
    layers: tuple[Row, ...] = ()
    begun: tuple[Row, ...] = ()
    carries: bool = False

    @classmethod
    def of(
        cls, name: str, order: int, words: str, A: Sequence[str], b: str, *references: Reference,
        errors: Sequence[str] = (), D: Sequence[str] = (), more: Sequence[str] = (), first: Sequence[str] = (),
        flat: str = "", series: bool = False,
    ) -> "Tableau":  # fmt: skip
        """From rows as texts, with the digits that are published."""
        return cls(
            name,
            order,
            words,
            rows(A),
            row(b),
            rows(errors),
            rows(D),
            rows(more),
            rows(first),
            flat,
            references,
            series,
        )

    @property
    def composed(self) -> bool:
        """Whether a step is a product of several exponentials, which need no dexpinv and have no extension."""
        return bool(self.first)

    @property
    def implicit(self) -> bool:
        """Whether stages are equations; the first one is F at the start, which only the estimate of the error reads."""
        return bool(self.layers) or self.carries

    @property
    def estimated(self) -> int:
        """The order of the error of one step, as it is estimated."""
        return len(self.layers) + 1 if self.implicit else self.order

    @property
    def c(self) -> Row:
        return tuple(sum(row, Fraction(0)) for row in self.A)

    @property
    def stages(self) -> tuple[Row, ...]:
        """The rows of all stages: those of a step, F at its end, and those of the continuous extension."""
        return (*self.A, self.b, *self.more)

    def exponentials(self, stage: int) -> tuple[Row, ...]:
        """The weights of each exponential of one of the stages."""
        whole = self.stages[stage]
        first = self.first[stage] if self.first else ()
        return (first, tuple(a - f for a, f in zip(whole, first, strict=True))) if first else (whole,)

    def extension(self, s: Number, number: Callable[[Fraction], Any] = Fraction) -> tuple[Any, ...]:
        """The weights of all stages in the continuous extension at the fraction s of a step: nested as in Hairer,
        Norsett and Wanner (1993), section II.6; without D it is Hermite's cubic; of a collocation its polynomial.
        number: what coefficients become."""
        stages = range(len(self.stages))
        if self.carries:
            return self._between(s, number)
        if self.layers:
            zero = number(Fraction(0))
            return (zero, *self._integrated(self.layers, s, number), zero)
        b = (*self.b, *[Fraction(0)] * (len(stages) - len(self.b)))
        first, last = ([Fraction(i == place) for i in stages] for place in (0, len(self.b)))
        layers = [b, [f - w for f, w in zip(first, b, strict=True)]]
        layers += [[2 * w - f - g for w, f, g in zip(b, first, last, strict=True)]]
        layers += [(*d, *[Fraction(0)] * (len(stages) - len(d))) for d in self.D]
        total = [number(Fraction(0)) for _ in stages]
        for n, layer in reversed(list(enumerate(layers))):
            total = [(s if n % 2 == 0 else 1 - s) * (number(w) + x) for w, x in zip(layer, total, strict=True)]
        return tuple(total)

    @staticmethod
    def _between(s: Number, number: Callable[[Fraction], Any]) -> tuple[Any, ...]:
        """Hermite's cubic of a method that carries on: of the slope at the start, the mean one, that at the end."""
        rest = 1 - s
        return s * rest * rest, s * s * (1 + 2 * rest), -(s * s * rest), number(Fraction(0))

    def places(self, s: Number, number: Callable[[Fraction], Any] = Fraction) -> tuple[Any, ...]:
        """The same for places, which of a collocation are the integral of velocities that are known at the start, too:
        of one order more."""
        if not self.begun:
            return self.extension(s, number)
        return (*self._integrated(self.begun, s, number), number(Fraction(0)))

    def _integrated(self, layers: tuple[Row, ...], s: Number, number: Callable[[Fraction], Any]) -> list[Any]:
        found = []
        for layer in layers:
            total = number(Fraction(0))
            for n, w in reversed(list(enumerate(layer))):
                total = s * (number(w / (n + 1)) + total)
            found.append(total)
        return found


def rows(texts: Sequence[str]) -> tuple[Row, ...]:
    return tuple(map(row, texts))


def row(text: str) -> Row:
    return tuple(map(Fraction, text.split()))


METHODS: Registry[Tableau] = Registry("method", lambda tableau: tableau.name)
