"""Guard functions: their values inside the current step, by how much they cross zero, and whether they may.

An event has one guard function, which is above 0 where its condition holds. A stop, a contact or a dry joint has two
(`switched.turning`). Open, the first one is above 0 where the gap has closed, and the second is the rate of the gap.
Closed, the first one is above 0 where the contact pulls (of a dry joint it is 0), and the second one where friction
exceeds its limit, or sliding reverses.
"""

from typing import Any

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.bounds import MONOTONE_RATIO, OSCILLATION_RATIO, by_changes, by_rates
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.certificates import BEYOND
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.events.acting import follow
from lienumba.integrators.drivers.events.tolerances import (
    CLOSED_GAP_RTOL,
    CONTACT_ROUNDOFF,
    GUARD_ROUNDOFF,
    RESOLVED_GROWTH,
)
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.hysteresis import HYSTERESIS_RTOL, ROOT_RTOL
from lienumba.integrators.layout import (
    BILATERAL,
    CHANGED,
    END_RATE,
    EXTENT,
    FRICTION,
    LENGTH,
    OFF,
    OPENS,
    RATE,
    RESOLVED,
    SIZE,
    SLIDE,
    SLIDES,
    STICK,
    STRODE,
    SWIFTEST,
    SWITCH_FIRST,
    SWITCH_KIND,
    UNILATERAL,
    T,
)
from lienumba.numerics.operations import absolute, maximum, minimum


@inlined
def evaluate(context: Context, fraction: Lanes) -> None:
    """Evaluate all guard functions at a fraction of the current step, to `following`."""
    t, length = load(context.at.lanes, T), load(context.at.clock, LENGTH)
    store(context.at.clock, layout.TIME, t)
    if context.kernels[layout.WATCH] != 0:
        store(context.at.clock, layout.FRACTION, fraction)
        call(
            context.kernels[layout.WATCH],
            context.at.state,
            context.at.parameters,
            context.at.clock,
            context.at.slopes,
            context.at.following,
            context.at.work,
        )
        return
    between(context.kernels, context.at, fraction)
    store(context.at.clock, layout.TIME, t + fraction * length)
    call(
        context.kernels[layout.EVENTS],
        context.at.now,
        context.at.parameters,
        context.at.clock,
        0,
        context.at.following,
        context.at.work,
    )


@inlined
def start_value(context: Context, n: int) -> Any:
    """The nth guard function at the start of the step."""
    return load(context.at.conditions, n)


@inlined
def end_value(context: Context, n: int) -> Any:
    """The nth guard function at the end of the step."""
    return load(context.at.conditions, layout.conditions(context.sizes) + n)


@inlined
def time_row(context: Context, n: int) -> int:
    """The row of the time (s) at which the nth guard function crosses zero."""
    return 2 * layout.conditions(context.sizes) + n


@inlined
def contact_of(context: Context, n: int) -> int:
    """The switched constraint to which the nth guard function belongs."""
    return (n - context.sizes.events) // layout.CONDITIONS


@inlined
def kind_of(context: Context, n: int) -> int:
    return context.plan.switches[contact_of(context, n), SWITCH_KIND]


@inlined
def opens(context: Context, n: int) -> bool:
    """Whether a guard function of a contact is the first one of its two."""
    return (n - context.sizes.events) % layout.CONDITIONS == OPENS


@apart
def threshold(context: Context, n: int, true: Mask) -> Any:
    """By how much the nth guard function has to be on the other side of 0, in the lanes in which it is above 0 and in
    the others: more than roundoff, and where it falls more than the hysteresis band."""
    if n >= context.sizes.events:
        contact = contact_of(context, n)
        mode = load(context.at.state, layout.on_row(context.sizes) + contact)
        force = BEYOND * load(context.at.change, layout.change_forces(context.sizes) + contact)
        if opens(context, n):
            return choose(mode == OFF, splat(CLOSED_GAP_RTOL), force)
        return choose(
            mode == SLIDE,
            CONTACT_ROUNDOFF * load(context.at.change, layout.change_speeds(context.sizes) + contact),
            force,
        )
    largest = load(context.at.conditions, layout.peak_row(context.sizes) + EXTENT * context.sizes.events + n)
    return maximum(largest * choose(true, splat(HYSTERESIS_RTOL), splat(ROOT_RTOL)), splat(GUARD_ROUNDOFF))


@apart
def end_rates(context: Context, n: int) -> tuple[Lanes, Lanes]:
    """The rates (1/s) of the nth guard function at the start and at the end of the step, NaN where they are not known.
    Of contacts those of open gaps are."""
    sizes = context.sizes
    if n < sizes.events:
        peaks = layout.peak_row(sizes) + n
        return load(context.at.conditions, peaks + RATE * sizes.events), load(
            context.at.conditions, peaks + END_RATE * sizes.events
        )
    if not opens(context, n):
        return splat(np.nan), splat(np.nan)
    contact, other = contact_of(context, n), n + SLIDES - OPENS
    size = load(context.at.change, layout.border_numbers(sizes) + layout.CONTACT_NUMBERS * contact + SIZE)
    size = choose(load(context.at.state, layout.on_row(sizes) + contact) == OFF, size, splat(np.nan))
    return -start_value(context, other) / size, -end_value(context, other) / size


@apart
def is_force(context: Context, n: int) -> Lanes:
    """1 where the nth guard function compares a contact force, or friction, with what it may be, else 0."""
    if n < context.sizes.events or kind_of(context, n) == BILATERAL:
        return splat(0.0)
    kind, contact = kind_of(context, n), contact_of(context, n)
    mode = load(context.at.new, layout.on_row(context.sizes) + contact)
    if kind == UNILATERAL:
        return choose(
            mode == STICK, splat(1.0), choose(mode == SLIDE, splat(1.0 if opens(context, n) else 0.0), splat(0.0))
        )
    used = load(context.at.new, layout.mask_row(context.sizes) + context.plan.switches[contact, SWITCH_FIRST])
    sticks = choose((mode == STICK) & (used != 0.0), splat(1.0), 0.0)
    return splat(0.0) if opens(context, n) else sticks


@inlined
def _is_sampled(context: Context, n: int) -> Lanes:
    """1 where the nth guard function may be asked for between the ends of a step at which it has one sign, else 0."""
    if n < context.sizes.events:
        return splat(1.0)
    mode = load(context.at.new, layout.on_row(context.sizes) + contact_of(context, n))
    if kind_of(context, n) == UNILATERAL and opens(context, n):
        return choose(mode == OFF, splat(1.0), is_force(context, n))
    if kind_of(context, n) == FRICTION and not opens(context, n):
        return choose(mode == SLIDE, splat(1.0), is_force(context, n))
    return is_force(context, n)


@apart
def oscillates(context: Context, n: int) -> Mask:
    """Where the step may be longer than half a period of the guard function of an event, by its largest rate so far."""
    if n >= context.sizes.events:
        return splat(0.0) > 1.0
    peaks = context.at.conditions + ROW * (layout.peak_row(context.sizes) + n)
    fastest = load(context.at.clock, LENGTH) * load(peaks, SWIFTEST * context.sizes.events)
    return fastest > OSCILLATION_RATIO * load(peaks, EXTENT * context.sizes.events)


@apart
def is_monotone(context: Context, n: int) -> Any:
    """1 where the nth guard function goes one way in the step by its rates at both ends, 0 where it may turn, NaN where
    its rates are not known. See `step_ends.Ends`."""
    length, (before, after) = load(context.at.clock, LENGTH), end_rates(context, n)
    mean = end_value(context, n) - start_value(context, n)
    low, high = length * minimum(before, after), length * maximum(before, after)
    few, many = (
        minimum(mean / MONOTONE_RATIO, mean * MONOTONE_RATIO),
        maximum(mean / MONOTONE_RATIO, mean * MONOTONE_RATIO),
    )
    even = choose((low >= few) & (high <= many), splat(1.0), 0.0)
    return choose((before == before) & (after == after), even, splat(np.nan))


@apart
def may_turn(context: Context, n: int) -> Any:
    """1 where the rates of the nth guard function are known, and do not say that it goes one way in the step."""
    monotone = is_monotone(context, n)
    turns = (monotone < 1.0) | ((monotone == monotone) & oscillates(context, n))
    return choose(turns, splat(1.0), 0.0)


@apart
def may_cross(context: Context, n: int) -> Lanes:
    """1 where the nth guard function may cross zero upwards inside the step in a way that its signs at the ends do not
    show, else 0: by its rates there, or by how much it changed in this step and in the one before."""
    length, before, after = load(context.at.clock, LENGTH), start_value(context, n), end_value(context, n)
    side, monotone = choose(before > 0.0, splat(-1.0), splat(1.0)), is_monotone(context, n)
    begin, end = side * before, side * after
    p, q = end_rates(context, n)
    p, q = side * length * p, side * length * q
    earlier = load(context.at.conditions, layout.rise_row(context.sizes) + n)
    earlier = earlier * maximum(length / load(context.at.lanes, STRODE), splat(1.0))
    reach = choose(monotone == 1.0, splat(0.0), by_rates(minimum(p, q), maximum(p, q), end - begin))
    reach = choose(monotone == monotone, reach, by_changes(end - begin, earlier))
    reaches = (end <= 0.0) & (maximum(begin, end) + reach > threshold(context, n, before > 0.0))
    turns = (may_turn(context, n) > 0.0) & ((end > 0.0) | oscillates(context, n))
    unresolved = length > RESOLVED_GROWTH * load(context.at.lanes, RESOLVED)
    may = choose(reaches | turns, splat(1.0), choose(unresolved, is_force(context, n), 0.0))
    return choose(before == before, _is_sampled(context, n) * may, splat(0.0))


@apart
def store_end_rates(context: Context, new: int) -> None:
    """Store the rates at the end of the step, which the kernel `events` has written behind the address `new`."""
    for n in range(context.sizes.events):
        row = layout.peak_row(context.sizes) + END_RATE * context.sizes.events + n
        store(context.at.conditions, row, load(new, layout.rate_row(context.sizes) + n))


@apart
def drop_jumping_rates(context: Context, new: int, jumps: Mask) -> None:
    """Make rates unknown that jump at the discontinuity on which the step ends; behind it guard functions are in
    `following`."""
    for n in range(context.sizes.events):
        peaks, rate = (
            context.at.conditions + ROW * (layout.peak_row(context.sizes) + n),
            layout.rate_row(context.sizes) + n,
        )
        jump = absolute(load(context.at.following, rate) - load(new, rate))
        unknown = jumps & (jump > BEYOND * load(peaks, SWIFTEST * context.sizes.events))
        end = load(peaks, END_RATE * context.sizes.events)
        store(peaks, END_RATE * context.sizes.events, choose(unknown, splat(np.nan), end))


@inlined
def rises_at_end(context: Context, n: int) -> Mask:
    """Where the guard function of an event passes 0 at the end of the step, but for roundoff."""
    peaks = context.at.conditions + ROW * (layout.peak_row(context.sizes) + n)
    band = ROOT_RTOL * load(peaks, EXTENT * context.sizes.events)
    rises = load(peaks, END_RATE * context.sizes.events) > 0.0
    return (start_value(context, n) < -band) & (end_value(context, n) > -band) & rises


@apart
def go_on(context: Context, going: Mask) -> None:
    """The guard functions at the end of the step are those at the start of the next one in the lanes `going`."""
    at, sizes, count = context.at, context.sizes, layout.conditions(context.sizes)
    for n in range(count):
        row, rise = layout.rise_row(sizes) + n, end_value(context, n) - start_value(context, n)
        store(at.conditions, row, choose(going, rise, load(at.conditions, row)))
    store(at.lanes, RESOLVED, choose(load(at.lanes, CHANGED) != 0.0, 0.0, load(at.lanes, RESOLVED)))
    store(at.lanes, STRODE, choose(going, load(at.clock, LENGTH), load(at.lanes, STRODE)))
    rates = layout.peak_row(sizes) + END_RATE * sizes.events
    follow(sizes, at, at.conditions + ROW * count, at.conditions + ROW * rates, going)
    stages.commit(going, at.conditions, at.conditions + ROW * count, count)
