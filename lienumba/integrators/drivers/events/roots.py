"""Bracketing root finder: all lanes at once, on the continuous extension of the current step."""

from typing import NamedTuple

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.events.guards import evaluate
from lienumba.integrators.drivers.events.tolerances import (
    CUT_ACCURACY,
    EXACT_EDGE,
    MAX_EVALUATIONS,
    SHORTEST_SECANT,
    TIME_ULP,
)
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import LENGTH, T
from lienumba.numerics.operations import maximum


@inlined
def finest_fraction(context: Context) -> Lanes:
    """The least fraction of the current step that makes another time."""
    t, length = load(context.at.lanes, T), load(context.at.clock, LENGTH)
    return TIME_ULP * maximum(splat(1.0), (t + length) / length)


@inlined
def _value(context: Context, kernel: int, row: int, fraction: Lanes) -> Lanes:
    """What the kernel writes to this row, at a fraction of the current step."""
    if kernel == layout.EVENTS:
        evaluate(context, fraction)
    else:
        t, length = load(context.at.lanes, T), load(context.at.clock, LENGTH)
        store(context.at.clock, layout.TIME, t)
        between(context.kernels, context.at, fraction)
        store(context.at.clock, layout.TIME, t + fraction * length)
        call(
            context.kernels[kernel],
            context.at.now,
            context.at.parameters,
            context.at.clock,
            0,
            context.at.following,
            context.at.work,
        )
    return load(context.at.following, row)


class Bracket(NamedTuple):
    """Two places, and the values of a function there."""

    begin: Lanes
    end: Lanes
    f_begin: Lanes
    f_end: Lanes


@apart
def find_root(context: Context, kernel: int, row: int, bracket: Bracket, rough: Mask, lanes: Mask) -> Lanes:
    """Find where a function passes 0, directly behind the root, by Chandrupatla's method.

    kernel, row: of the function (see `layout.ORDER`); bracket: by fractions of the current step; rough: where
    `CUT_ACCURACY` will do, if the root is not near an end of the step; else times are as exact as numbers are. Next to
    the root, where the function is roundoff, the other end of the bracket follows by steps that double. Reference:
    T. R. Chandrupatla, Advances in Engineering Software 28 (1997) 145-149.
    """
    begin, end, before, after = bracket
    falls = (before > 0.0) | ((before == 0.0) & (after < 0.0))
    sense = choose(falls, splat(-1.0), splat(1.0))
    low, high, f_low, f_high = begin, end, sense * before, sense * after
    third, f_third = low, f_low  # the end of the bracket that was replaced last
    newest_low, part = splat(1.0), f_low / (f_low - f_high)  # whether the newest value is that of `low`
    part = choose(part > SHORTEST_SECANT, part, 0.5)
    finest = finest_fraction(context)
    least, reach, left = finest, finest, lanes
    for _ in range(MAX_EVALUATIONS):
        if not any_lane(left):
            break
        lower = newest_low == 1.0
        a, b = choose(lower, low, high), choose(lower, high, low)
        x = a + part * (b - a)
        f = sense * _value(context, kernel, row, x)
        behind = f > 0.0
        replaced, f_replaced = choose(behind, high, low), choose(behind, f_high, f_low)
        third, f_third = choose(left, replaced, third), choose(left, f_replaced, f_third)
        high, f_high = choose(left & behind, x, high), choose(left & behind, f, f_high)
        low, f_low = choose(behind, low, choose(left, x, low)), choose(behind, f_low, choose(left, f, f_low))
        newest = choose(behind, splat(0.0), splat(1.0))
        inside = rough & (x > 2.0 * EXACT_EDGE) & (x < 1.0 - 2.0 * EXACT_EDGE)
        least = choose(inside, maximum(finest, splat(CUT_ACCURACY)), finest)
        reach = choose(newest == newest_low, maximum(2.0 * reach, least), least)
        newest_low = choose(left, newest, newest_low)
        left = left & (high - low > least)
        part = choose(left, _part(low, f_low, high, f_high, third, f_third, newest_low == 1.0, reach), part)
    store(context.at.clock, layout.TIME, load(context.at.lanes, T))
    return high


@inlined
def _part(
    low: Lanes, f_low: Lanes, high: Lanes, f_high: Lanes, third: Lanes, f_third: Lanes, lower: Mask, reach: Lanes
) -> Lanes:  # fmt: skip
    """Where to look next, as a part of the way from the newest end of the bracket to the other: by inverse quadratic
    interpolation where three values allow it, else half of the way; reach: how far away from both at least."""
    a, f_a = choose(lower, low, high), choose(lower, f_low, f_high)
    b, f_b = choose(lower, high, low), choose(lower, f_high, f_low)
    across, place = (a - b) / (third - b), (f_a - f_b) / (f_third - f_b)
    smooth = (place * place < across) & ((1.0 - place) * (1.0 - place) < 1.0 - across)
    towards = f_a / (f_b - f_a) * (f_third / (f_b - f_third))
    towards = towards + (third - a) / (b - a) * (f_a / (f_third - f_a)) * (f_b / (f_third - f_b))
    part = choose(smooth, towards, 0.5)
    nearest = reach / (high - low)  # so that the other end comes near, too
    nearest = choose(nearest < 0.5, nearest, 0.5)
    part = choose(part > nearest, part, nearest)
    return choose(part < 1.0 - nearest, part, 1.0 - nearest)
