"""Steps and output times on one exact grid: times are decimals k * every, not sums of rounded steps."""

from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm

TOLERANCE = 1e-9  # relative: how far a ratio may lie from a whole number
MOST_INTERVALS = 200  # of the default output interval


@lru_cache(1024)
def exact(value: float) -> Fraction:
    """A number as its shortest decimal says it: 0.1 is 1/10."""
    return Fraction(Decimal(repr(float(value))))


@lru_cache(1024)
def count(duration: float, step: float) -> int | None:
    """How many steps make up a duration; None if that is no whole number."""
    ratio = exact(duration) / exact(step)
    whole = round(ratio)
    return whole if abs(ratio - whole) <= TOLERANCE * whole else None


def stored_times(end: float, every: float) -> list[float]:
    """The times 0, every, 2 every, ... up to the end, each the double nearest to its exact decimal, none behind the
    end."""
    base = exact(every)
    whole = count(end, every)
    number = int(exact(end) / base) if whole is None else whole
    return [min(index * base.numerator / base.denominator, end) for index in range(number + 1)]


def default_interval(end: float, steps: Sequence[float], ends: Sequence[float] = ()) -> float:
    """The shortest output interval which divides the run into at most MOST_INTERVALS equal ones, each a whole number of
    these steps, as far as they suit each other and all ends, the first one above all; without steps that many."""
    if not steps:
        return float(exact(end) / MOST_INTERVALS)
    number = count(end, steps[0])
    assert number is not None, "checked before"
    common = gcd(number, *(other for s in steps if (other := count(end, s)) and all(count(e, s) for e in ends)))
    divisors = [n for n in range(MOST_INTERVALS, 0, -1) if common % n == 0]
    found = [float(exact(steps[0]) * (number // n)) for n in divisors]
    return next((interval for interval in found if all(count(e, interval) for e in ends)), found[-1])


def nearest_divisor(durations: list[float], step: float) -> float:
    """A step that divides every duration: the nearest one of few digits, or else the nearest one."""
    exacts = [exact(duration) for duration in durations]
    denominator = lcm(*(value.denominator for value in exacts))
    common = Fraction(gcd(*(int(value * denominator) for value in exacts)), denominator)
    nearest = max(1, round(common / exact(step)))
    candidates = [common / k for k in range(max(1, nearest // 2, nearest - 1000), nearest + min(nearest, 1000) + 1)]
    short = [value for value in candidates if exact(float(f"{float(value):.4g}")) == value]
    return float(min(short or [common / nearest], key=lambda value: abs(value - exact(step))))


def nearest_multiple(duration: float, step: float) -> float:
    """The duration nearest to the given one that the step divides."""
    base = exact(step)
    return float(base * max(1, round(exact(duration) / base)))
