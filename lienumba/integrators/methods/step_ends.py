"""What the ends of a step say of what is kept of a run: whether anything between them may change it, and what they add.

Plain functions of numbers; whether something is so is 1 or 0.
"""

from dataclasses import dataclass
from typing import NamedTuple

from lienumba.mechanics.mechanism.model import COUNT, FIRST, INTEGRAL, LARGEST, LAST, SMALLEST
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, maximum, minimum, where

FARTHEST = 4.0  # times what a signal changes by in two steps: inside of them it goes no farther
EVEN = 2.0  # times another rate, or less: about as large


@dataclass(frozen=True)
class Ends:
    """A signal at both ends of a step, what it changed by in the step before, and its rates at both ends times the
    length of the step, NaN where they are not known."""

    before: Number
    after: Number
    changed: Number
    rates: tuple[Number, Number] | None = None

    @property
    def change(self) -> Number:
        return absolute(self.after - self.before)

    @property
    def reach(self) -> Number:
        """By how much it may leave what it is at the ends: the cubic through them does so by 4/27 of its rates."""
        if self.rates is None:
            return FARTHEST * (self.change + self.changed)
        return absolute(self.rates[0]) + absolute(self.rates[1]) + self.change

    @property
    def turns(self) -> Number:
        """Whether it may turn between the ends. It does not where its rates there are at least half of the mean one,
        and at most twice that: what oscillates once in a step is never so even."""
        if self.rates is None:
            return 1.0
        (p, q), mean = self.rates, self.after - self.before
        few, many = mean / EVEN, mean * EVEN
        rises = where(p >= few, where(q >= few, where(p <= many, where(q <= many, 0.0, 1.0), 1.0), 1.0), 1.0)
        return where(p <= few, where(q <= few, where(p >= many, where(q >= many, 0.0, rises), rises), rises), rises)


class Known(NamedTuple):
    """What is kept: a value and its time (s), whether the condition held at the last end, whether it is undefined."""

    value: Number
    time: Number
    true: Number
    undefined: Number


def matters(kind: str, known: Known, value: Ends | None, condition: Ends | None, gain: Number | None) -> Number:
    """Whether what is between the ends may change what is kept of a value while a condition holds; gain: what the step
    itself says that the value integrates to, NaN where it does not."""
    found: Number = 0.0
    never: Number = 0.0
    if condition is not None:
        a, b, reach = condition.before, condition.after, condition.reach
        never = where(a <= -reach, where(b <= -reach, where(a < 0.0, 1.0, 0.0), 0.0), 0.0)
        never = maximum(never, where(a <= 0.0, where(b <= 0.0, 1.0 - condition.turns, 0.0), 0.0))
        found = where(a > reach, where(b > reach, 0.0, 1.0), 1.0)
        found = where(a > 0.0, where(b > 0.0, minimum(found, condition.turns), found), found)
    if kind == INTEGRAL and gain is not None:
        found = where(gain == gain, found, 1.0)
    elif kind == FIRST:
        found = where(known.time == known.time, 0.0, 1.0)
    elif kind == COUNT:
        found = maximum(found, 1.0 - known.true)
    elif kind in (LARGEST, SMALLEST):
        assert value is not None, "of something"
        sign = -1.0 if kind == SMALLEST else 1.0
        most, a, b = sign * known.value, sign * value.before, sign * value.after
        inside = where(a <= most, maximum(found, value.turns), 1.0)
        found = where(a <= most - value.reach, where(b <= most - value.reach, found, inside), inside)
    return found if condition is None else where(never > 0.0, 0.0, found)


def added(
    kind: str, known: Known, value: Number | None, holds: Number | None, gain: Number | None, taken: Number,
    begin: Number, end: Number,
) -> Known:  # fmt: skip
    """What is known behind a step from `begin` to `end` (s) of which the ends say everything, in the lanes in which it
    is `taken`, which is above 0 there; value: at its end; holds: whether the condition does there, None for always."""
    lasting = taken
    if holds is not None:
        known = known._replace(true=where(taken > 0.0, holds, known.true))
        lasting = where(holds > 0.0, taken, 0.0)
    if kind == LAST:
        known = known._replace(time=where(lasting > 0.0, end, known.time))
        if holds is not None:
            known = known._replace(undefined=where(lasting > 0.0, 0.0, known.undefined))
        return known if value is None else known._replace(value=where(lasting > 0.0, value, known.value))
    if kind == INTEGRAL:
        known = known._replace(time=known.time + where(lasting > 0.0, end - begin, 0.0))
        return known if gain is None else known._replace(value=known.value + where(lasting > 0.0, gain, 0.0))
    if kind in (LARGEST, SMALLEST) and value is not None:
        sign = -1.0 if kind == SMALLEST else 1.0
        better = where(sign * value > sign * known.value, lasting, 0.0)
        return known._replace(value=where(better > 0.0, value, known.value), time=where(better > 0.0, end, known.time))
    return known
