"""What the ends of a step say of what is kept of a run: whether anything between them may change it, and what they add.

Plain functions of numbers; whether something is so is 1 or 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from lienumba.integrators.bounds import MONOTONE_RATIO, OSCILLATION_RATIO, by_changes, by_rates
from lienumba.integrators.hysteresis import HYSTERESIS_RTOL, ROOT_RTOL, STAGE_RTOL, settled
from lienumba.mechanics.mechanism.model import COUNT, FIRST, INTEGRAL, LARGEST, LAST, SMALLEST
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, maximum, minimum, where

ALIKE = 1.2  # times another step, or less: about as long
ROUNDING = 4e-15  # of the largest size of a signal: what an extreme is not looked for
STEADY = 5.0 / 3.0  # times another mean rate, or less: about as large


@dataclass(frozen=True)
class Past:
    """What a signal changed by in the last step and in the one before, and how long these two steps and the present
    one were (s), the latest first; 0 s where this says nothing of the present one."""

    changes: tuple[Number, Number]
    lengths: tuple[Number, Number, Number]

    def steady(self, change: Number, yes: Number, no: Number) -> Any:
        """One of two numbers: whether the mean rates of all three steps, about as long, are about as large."""
        now, last, first = self.lengths
        found: Any = yes
        for long, other in ((now, last), (last, first)):
            found = where(long <= ALIKE * other, where(other <= ALIKE * long, found, no), no)
        for large, other in ((change * last, self.changes[0] * now), (self.changes[0] * first, self.changes[1] * last)):
            size, others = absolute(large), absolute(other)
            found = where(size <= STEADY * others, where(others <= STEADY * size, found, no), no)
            found = where(large * other > 0.0, found, no)
        return found


@dataclass(frozen=True)
class Ends:
    """A signal at both ends of a step, what it was before, and its rates at both ends times the length of the step, NaN
    where they are not known; smooth: whether it has no kinks; size: the largest that it has been; turn: the largest
    rate so far times the length of the step."""

    before: Number
    after: Number
    past: Past
    rates: tuple[Number, Number] | None = None
    smooth: bool = False
    size: Number = 0.0
    turn: Number = 0.0

    @property
    def change(self) -> Number:
        return self.after - self.before

    @property
    def most(self) -> Number:
        return maximum(self.before, self.after)

    @property
    def least(self) -> Number:
        return minimum(self.before, self.after)

    @property
    def _rate_ends(self) -> tuple[Number, Number]:
        """The smaller and the larger rate. Of two numbers a NaN is the second, so that each is seen in one of these."""
        assert self.rates is not None, "known"
        p, q = self.rates
        return minimum(q, p), maximum(p, q)

    @property
    def reach(self) -> Number:
        """By how much it may leave what it is at the ends."""
        if self.rates is None:
            return by_changes(self.change, self.past.changes[0])
        return self._if_it_oscillates(self.turn, by_rates(*self._rate_ends, self.change))

    def _if_it_oscillates(self, yes: Number, no: Number) -> Any:
        """One of two numbers: whether it may go through half a period in the step, by its largest rate so far."""
        return where(self.turn > OSCILLATION_RATIO * self.size, yes, no)

    def if_it_crosses(self, yes: Number, no: Number) -> Any:
        """One of two numbers: whether it may be on both sides of 0, for stages that are next to the ends, too, and by
        more than rounding."""
        reach = self.if_it_turns(self.reach, 0.0) + STAGE_RTOL * (self.most - self.least)
        faint = maximum(self.most, -self.least) + reach <= ROOT_RTOL * self.size
        still = where(reach <= 0.0, no, where(faint, no, yes))
        return where(self.least > reach, no, where(self.most < -reach, no, still))

    def if_it_turns(self, yes: Number, no: Number) -> Any:
        """One of two numbers: whether it may turn between the ends. It does not where its rates there are at least half
        of the mean one, and at most twice that, unless it may oscillate. Without
        rates, it does not where the mean ones of three steps are as even: what oscillates half a time in a step is
        never that."""
        if self.rates is None:
            return self.past.steady(self.change, no, yes) if self.smooth else yes
        (low, high), mean = self._rate_ends, self.after - self.before
        few, many = mean * (1.0 / MONOTONE_RATIO), mean * MONOTONE_RATIO
        no = self._if_it_oscillates(yes, no)
        return where(low >= minimum(few, many), where(high <= maximum(few, many), no, yes), yes)


class Known(NamedTuple):
    """What is kept: a value and its time (s), the most that the condition has been since it holds, 0 where it does not,
    whether it is undefined, and the largest size of the condition so far."""

    value: Number
    time: Number
    peak: Number
    undefined: Number
    size: Number

    def settled(self, condition: Number) -> Any:
        return settled(condition, self.peak, self.size)


def matters(
    kind: str, known: Known, value: Ends | None, condition: Ends | None, gain: Number | None,
    bends: Sequence[Ends] = (), turns: Sequence[Ends] = (),
) -> Number:  # fmt: skip
    """Whether what is between the ends may change what is kept of a value while a condition holds; gain: what the step
    itself says that the value integrates to, NaN where it does not; bends, turns: at whose zeros the value, and the
    condition, bends."""
    found: Number = 0.0
    bent, turned = (_any_crosses(every) for every in (bends, turns))
    if condition is not None:
        reach, size = condition.if_it_turns(condition.reach, 0.0), known.size
        as_told = replace(condition, before=known.settled(condition.before), after=known.settled(condition.after))
        band = maximum(HYSTERESIS_RTOL * size - maximum(known.peak, condition.most), 0.0)
        lasts = where(known.peak > 0.0, condition.least + band, as_told.least)
        begins = where(as_told.most > 0.0, as_told.most, condition.most - ROOT_RTOL * size)
        found = _where(turned, 1.0, where(lasts > reach, 0.0, 1.0))
    if kind == INTEGRAL and gain is not None:
        found = where(gain == gain, _where(bent, 1.0, found), 1.0)
    elif kind == FIRST:
        found = where(known.time == known.time, 0.0, 1.0)
    elif kind == COUNT:
        found = where(known.peak > 0.0, found, 1.0)
    elif kind in (LARGEST, SMALLEST):
        assert value is not None, "of something"
        begin, end = (value.before, value.most) if kind == LARGEST else (-value.before, -value.least)
        most = known.value if kind == LARGEST else -known.value
        beyond = value.if_it_turns(end + value.reach, begin)
        found = _where(bent, 1.0, where(beyond <= most + ROUNDING * value.size, found, 1.0))
    if condition is None:
        return found
    never = begins < -reach if condition.rates is None else begins <= -reach
    return _where(turned, found, where(never, 0.0, found))


def _any_crosses(every: Sequence[Ends]) -> Number | None:
    """Whether one of them may be on both sides of 0; None without any."""
    found: Number = 0.0
    for ends in every:
        found = ends.if_it_crosses(1.0, found)
    return found if every else None


def _where(flag: Number | None, yes: Number, no: Number) -> Any:
    return no if flag is None else where(flag > 0.0, yes, no)


def added(
    kind: str, known: Known, value: Number | None, condition: Number | None, gain: Number | None, taken: Number,
    begin: Number, end: Number,
) -> Known:  # fmt: skip
    """What is known behind a step from `begin` to `end` (s) of which the ends say everything, in the lanes in which it
    is `taken`, which is above 0 there; value, condition: at its end, None for what always holds."""
    lasting = taken if condition is None else where(known.settled(condition) > 0.0, taken, 0.0)
    if condition is not None:
        peak = where(lasting > 0.0, maximum(known.peak, known.settled(condition)), 0.0)
        known = known._replace(peak=where(taken > 0.0, peak, known.peak))
    if kind == LAST:
        known = known._replace(time=where(lasting > 0.0, end, known.time))
        if condition is not None:
            known = known._replace(undefined=where(lasting > 0.0, 0.0, known.undefined))
        return known if value is None else known._replace(value=where(lasting > 0.0, value, known.value))
    if kind == INTEGRAL:
        known = known._replace(time=where(lasting > 0.0, known.time + (end - begin), known.time))
        return known if gain is None else known._replace(value=where(lasting > 0.0, known.value + gain, known.value))
    if kind in (LARGEST, SMALLEST) and value is not None:
        new = where(lasting > 0.0, value, known.value)
        better = new > known.value if kind == LARGEST else new < known.value
        return known._replace(value=where(better, new, known.value), time=where(better, end, known.time))
    return known
