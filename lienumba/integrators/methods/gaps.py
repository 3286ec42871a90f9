"""Where a gap closes: the first time in a step at which a number that a law compares with another one passes it."""

from collections.abc import Callable

from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, minimum, where

SAMPLES = 8  # parts of a step, at whose ends the signs are looked at
ROOTS = 6  # false positions
NEARER = 0.125  # of a part: how far beside the least value the second parabola is laid
Gap = Callable[[Number], Number]


def crossing(gap: Gap, h: Number, beyond: Number) -> tuple[Number, Number]:
    """Between 0 and h, and where a step is to end for it: at most `beyond` behind; 2 h if there is none. Two within a
    part of the step are found where the gap is least between them.

    By false positions (Illinois) from where the sign is another one. Where these end early, a step is to end where the
    gap has closed: from there it is sought again.
    """
    times = [(n / SAMPLES) * h for n in range(SAMPLES + 1)]
    values = [gap(t) for t in times]
    sign = where(values[0] < 0.0, -1.0, 1.0)
    values = [sign * x for x in values]

    def upright(t: Number) -> Number:
        return sign * gap(t)

    (low, at_low), (high, at_high) = (0.0 * h, values[0]), _least(upright, h, times, values)
    for n in range(SAMPLES, 0, -1):  # the first one counts
        passed = values[n] < 0.0
        low, at_low = where(passed, times[n - 1], low), where(passed, values[n - 1], at_low)
        high, at_high = where(passed, times[n], high), where(passed, values[n], at_high)
    first = _root(upright, (low, at_low), (high, at_high))
    directly = first + beyond
    end = where(upright(directly) < 0.0, directly, where(high < h - beyond, high, directly))
    return where(at_high < 0.0, first, 2.0 * h), where(at_high < 0.0, end, 2.0 * h)


def _least(gap: Gap, h: Number, times: list[Number], values: list[Number]) -> tuple[Number, Number]:
    """Where the gap is least, and how large it is there: by two parabolas."""
    part = h * (1.0 / SAMPLES)
    at, size = times[1], values[1]
    before, after = values[0], values[2]
    for n in range(2, SAMPLES):
        nearer = values[n] < size
        at, size = where(nearer, times[n], at), where(nearer, values[n], size)
        before, after = where(nearer, values[n - 1], before), where(nearer, values[n + 1], after)
    for width in (part, NEARER * part):
        at = minimum(maximum(at + width * _vertex(before, size, after), 0.0 * h), h)
        size, before, after = gap(at), gap(at - NEARER * part), gap(at + NEARER * part)
    return at, size


def _vertex(before: Number, size: Number, after: Number) -> Number:
    """Of the parabola through three points at -1, 0 and 1; 0 if it opens downwards, and within these."""
    curved = before - 2.0 * size + after
    found = 0.5 * (before - after) / where(curved > 0.0, curved, 1.0)
    return where(curved > 0.0, minimum(maximum(found, -1.0), 1.0), 0.0)


def _root(gap: Gap, low: tuple[Number, Number], high: tuple[Number, Number]) -> Number:
    """Of a gap that is closed at `high`, and open at `low`."""
    (begin, at_begin), (end, at_end) = low, high
    side: Number = 0.0
    for n in range(ROOTS):
        middle = (begin * at_end - end * at_begin) / (at_end - at_begin)
        if n == ROOTS - 1:
            break
        at_middle = gap(middle)
        behind = at_middle < 0.0
        at_begin = where(behind, where(side > 0.0, 0.5 * at_begin, at_begin), at_middle)
        at_end = where(behind, at_middle, where(side < 0.0, 0.5 * at_end, at_end))
        begin, end = where(behind, begin, middle), where(behind, middle, end)
        side = where(behind, 1.0, -1.0)
    return middle
