"""Record signals over a whole run: what each step adds.

Signals are evaluated at the end of each step, and between its ends only where that may change what is recorded.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.bounds import finite_size
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.measuring.points import (
    LEANING,
    Subinterval,
    evaluate,
    nth_record,
    put,
    sample,
    signals,
    value_at,
)
from lienumba.integrators.drivers.measuring.subintervals import record_event, record_step
from lienumba.integrators.drivers.workspace import Context, Places, Rows
from lienumba.integrators.hysteresis import HYSTERESIS_RTOL, ROOT_RTOL
from lienumba.integrators.layout import (
    CHANGES,
    ELSEWHERE,
    FRESH,
    KEPT_TIME,
    KEPT_VALUE,
    LARGEST_RATES,
    LARGEST_SIZES,
    NODES,
    PICKED,
    RATES,
    SEEN,
    UNTIL,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes


@apart
def _extend(context: Context, t: Lanes, length: Lanes, closed: bool) -> None:
    """Make the continuous extension of the step; closed: the slopes of its stages have to be computed again."""
    kernels, sizes, at = context.kernels, context.sizes, context.at
    if closed and kernels[layout.SLOPES] != 0:
        store(at.clock, layout.TIME, t)
        call(kernels[layout.SLOPES], at.state, at.parameters, at.clock, 0, at.slopes, at.work)
    elif closed:
        for s in range(sizes.stages):
            stages.stage(context, s, at.state, at.parameters, t, length)
    stages.extend(context)


@inlined
def forget_past(sizes: Sizes, at: Workspace, lanes: Mask) -> None:
    """Where forces jump, the course of signals so far does not tell how they go on."""
    for n in range(layout.PAST):
        length = load(at.measures, layout.length_row(sizes) + n)
        store(at.measures, layout.length_row(sizes) + n, choose(lanes, splat(0.0), length))


@inlined
def forget_past_of(lane: int, rows: Rows, first: Workspace, sizes: Sizes) -> None:
    """`forget_past` of one lane; nothing without records."""
    for n in range(layout.PAST if sizes.kept > 0 else 0):
        rows[first.measures + layout.length_row(sizes) + n, lane] = 0.0


@apart
def _evaluate_start(context: Context) -> None:
    """Evaluate the signals where a step that is PICKED begins elsewhere than the last one ended."""
    sizes, at = context.sizes, context.at
    good, rates = load(at.lanes, PICKED) != 0.0, signals(context, RATES)
    unseen = good & (load(at.lanes, SEEN) <= 0.0)
    step = Subinterval(load(at.lanes, T), load(at.clock, layout.LENGTH), splat(0.0), splat(1.0), 0)
    evaluate(context, step, step.low, signals(context, ELSEWHERE))
    stages.commit(unseen, signals(context, 0), signals(context, ELSEWHERE), sizes.signals)
    for signal in range(sizes.signals if sizes.seen == 0 else 0):
        put(rates, signal, unseen & (load(at.lanes, SEEN) < 0.0), splat(np.nan))
    for n in range(sizes.kept):
        record = nth_record(context, n)
        if record.condition >= 0:  # what has come to rest is above 0 by roundoff only
            peak, size = load(record.rows, layout.KEPT_PEAK), load(record.rows, layout.KEPT_SIZE)
            rests = load(signals(context, 0), record.condition) <= ROOT_RTOL * size
            put(record.rows, layout.KEPT_PEAK, unseen & rests & (peak > HYSTERESIS_RTOL * size), splat(0.0))
    put(at.lanes, SEEN, good, splat(1.0))


@apart
def _record_inside(context: Context, until: Lanes, closed: bool) -> None:
    """Add a step that is PICKED and left at `until` to all records that its ends do not decide; closed: the slopes of
    its stages have to be computed again."""
    sizes, at = context.sizes, context.at
    t, length, picked = load(at.lanes, T), load(at.clock, layout.LENGTH), load(at.lanes, PICKED)
    good, leaves = picked != 0.0, picked < 0.0
    whole = choose(until < load(at.lanes, UNTIL), (until - t) / length, 1.0)
    _extend(context, t, length, closed)
    step = Subinterval(t, length, splat(0.0), whole, 0)
    sample(context, step)
    for n in range(sizes.kept):
        record = nth_record(context, n)
        opens = good & (leaves | (load(record.rows, layout.KEPT_OPEN) != 0.0))
        if any_lane(opens):
            record_step(context, record, step, opens)
            record_event(context, record, step, until, opens & leaves)
    for signal in range(sizes.signals):
        before, after = value_at(context, step, signal, 0), value_at(context, step, signal, NODES - 1)
        put(signals(context, CHANGES), signal, good, after - before)
        put(signals(context, 0), signal, good, after)
    put(at.lanes, SEEN, leaves, splat(-1.0))
    forget_past(sizes, at, leaves)


@inlined
def _stated(sizes: Sizes, at: Workspace, n: int) -> Lanes:
    """The nth number about signals that F at the end of the step states: first their rates, then their values."""
    return load(at.slopes, layout.said_row(sizes, sizes.integrands + n, sizes.slopes - 1))


@inlined
def renew_rates(context: Context, lanes: Mask) -> None:
    """Where a step begins with another F than the last one has ended with, signals have other rates."""
    rates = signals(context, RATES)
    for signal in range(context.sizes.signals):
        store(rates, signal, choose(lanes, _stated(context.sizes, context.at, signal), load(rates, signal)))


@inlined
def _record_end(context: Context) -> None:
    """Add what the end of the step decides."""
    sizes, at = context.sizes, context.at
    for n in range(sizes.seen):
        store(at.measures, layout.seen_row(sizes) + n, _stated(sizes, at, n))
    if sizes.leaping > 0:
        store(at.clock, layout.LEAN, -LEANING * load(at.clock, layout.LENGTH))
    call(context.kernels[layout.KEEP], at.new, at.parameters, at.clock, at.lanes, at.measures, at.work)
    if sizes.leaping > 0:
        store(at.clock, layout.LEAN, splat(0.0))


@inlined
def measure(context: Context, good: Mask, until: Lanes, leaves: Mask, closed: bool) -> None:
    """Add the current step to all records in the lanes `good`, which leave it at `until`; leaves: because of an event;
    closed: nothing is known of its stages. The clock stays as it is. Each lane and each record is subdivided as if it
    were alone. Rare work reads for itself what it needs, so that nothing is held ready for it."""
    at = context.at
    now = load(at.clock, layout.TIME)
    store(at.lanes, PICKED, choose(good, choose(leaves, splat(-1.0), 1.0), 0.0))
    if any_lane(good & (load(at.lanes, SEEN) <= 0.0)):
        _evaluate_start(context)
    store(at.clock, layout.TIME, load(at.lanes, UNTIL))
    _record_end(context)
    if any_lane(load(at.measures, layout.open_row(context.sizes)) != 0.0):
        _record_inside(context, until, closed)
    store(at.clock, layout.TIME, now)


@inlined
def take_gains(context: Context, x: Address, made: Address) -> None:
    """Take the integrals of signals over a step from x, which are at `made` or follow from its slopes."""
    sizes, at = context.sizes, context.at
    to = at.measures + ROW * layout.gain_row(sizes)
    if context.kernels[layout.QUADRATURE] != 0:
        call(context.kernels[layout.QUADRATURE], x, at.parameters, at.clock, at.slopes, to, at.work)
    else:
        stages.copy(to, made, sizes.integrands)


@inlined
def placed(context: Context, x: Address, places: Places) -> Context:
    """The context where states have changed places, of which none but the slopes' own may lie before these."""
    at, now, following = context.at, places.now, places.following
    if following == at.new:
        now, following = following, now
    there = Workspace(
        x, places.new, at.slopes, at.control, now, following, at.clock, at.lanes, at.u, at.conditions, at.table,
        at.change, at.measures, at.parameters, at.work,
    )  # fmt: skip
    return Context(
        context.kernels, context.nodes, context.sizes, context.plan, context.limit, context.tolerance, there,
        context.first, context.rows, context.table,
    )  # fmt: skip


@apart
def begin_measures(context: Context) -> None:
    """Begin the records of runs that are FRESH by what holds at their start."""
    sizes, at = context.sizes, context.at
    fresh, now = load(at.lanes, FRESH) != 0.0, signals(context, 0)
    store(at.clock, layout.TIME, splat(0.0))
    call(
        context.kernels[layout.MEASURE],
        at.state,
        at.parameters,
        at.clock,
        0,
        signals(context, ELSEWHERE),
        at.work,
    )
    stages.commit(fresh, now, signals(context, ELSEWHERE), sizes.signals)
    for signal in range(sizes.signals):
        x = load(now, signal)
        put(signals(context, CHANGES), signal, fresh, splat(np.inf))
        put(signals(context, RATES), signal, fresh, splat(np.nan))
        put(signals(context, LARGEST_RATES), signal, fresh, splat(0.0))
        put(signals(context, LARGEST_SIZES), signal, fresh, finite_size(x))
    forget_past(sizes, at, fresh)
    for n in range(sizes.kept):
        record, x = nth_record(context, n), splat(1.0)
        rows, kind = record.rows, record.kind
        if record.condition >= 0:
            x = load(now, record.condition)
        none = 0.0 if kind == layout.COUNTS else 0.0 if kind == layout.INTEGRATES else np.nan
        put(rows, layout.KEPT_PEAK, fresh, choose(x > 0.0, x, 0.0))
        put(rows, layout.KEPT_SIZE, fresh, finite_size(x))
        put(rows, layout.KEPT_UNDEFINED, fresh, choose(x == x, splat(0.0), 1.0))
        put(rows, KEPT_VALUE, fresh, splat(none))
        put(rows, KEPT_TIME, fresh, splat(none))
        if kind == layout.COUNTS:
            put(rows, KEPT_VALUE, fresh & (x > 0.0), splat(1.0))
        elif kind != layout.INTEGRATES:
            put(rows, KEPT_TIME, fresh & (x > 0.0), splat(0.0))
            value = load(now, record.signal) if record.signal >= 0 else splat(1.0)
            put(rows, KEPT_VALUE, fresh & (x > 0.0), value)
