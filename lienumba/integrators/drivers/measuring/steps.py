"""What is kept of runs as a whole: what each step adds to it.

Signals are looked at in both ends of a step, and between them only where that may change what is kept.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.measuring.panels import keep_panels
from lienumba.integrators.drivers.measuring.points import LEANING, look, signals, value_of
from lienumba.integrators.drivers.workspace import Places, Plan, Rows
from lienumba.integrators.layout import (
    CHANGES,
    COUNTS,
    FRESH,
    INTEGRATES,
    KEEPS_FIRST,
    KEEPS_LAST,
    KEPT_CONDITION,
    KEPT_KIND,
    KEPT_SIGNAL,
    KEPT_SIZE,
    KEPT_TIME,
    KEPT_TRUE,
    KEPT_UNDEFINED,
    KEPT_VALUE,
    LARGEST_SIZES,
    PICKED,
    POINTS,
    RATES,
    SEEN,
    UNTIL,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes


@apart
def _open(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, t: Lanes, length: Lanes, closed: bool
) -> None:
    """What is between the ends of the step becomes known; closed: whether even the slopes of its stages are not."""
    if closed and kernels[layout.SLOPES] != 0:
        store(at.clock, layout.TIME, t)
        call(kernels[layout.SLOPES], at.state, at.parameters, at.clock, 0, at.slopes, at.work)
    elif closed:
        for s in range(sizes.stages):
            stages.stage(kernels, sizes, nodes, s, at.state, at.parameters, at, t, length)
    stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))


@inlined
def forget_past(sizes: Sizes, at: Workspace, lanes: Mask) -> None:
    """What signals were says nothing of what they will be where forces jump."""
    for n in range(layout.PAST):
        length = load(at.measures, layout.length_row(sizes) + n)
        store(at.measures, layout.length_row(sizes) + n, choose(lanes, splat(0.0), length))


@inlined
def forget_past_of(lane: int, rows: Rows, first: Workspace, sizes: Sizes) -> None:
    """The same of one lane; nothing where nothing is kept."""
    for n in range(layout.PAST if sizes.kept > 0 else 0):
        rows[first.measures + layout.length_row(sizes) + n, lane] = 0.0


@apart
def _see(kernels: np.ndarray, sizes: Sizes, at: Workspace, t: Lanes, length: Lanes, good: Mask, unseen: Mask) -> None:
    """What signals are where a step begins that is not where the last one ended."""
    there, rates = signals(sizes, at, 0, POINTS - 1), signals(sizes, at, 0, RATES)
    look(kernels, sizes, at, t, length, splat(0.0), there)
    stages.commit(unseen, signals(sizes, at, 0, 0), there, sizes.signals)
    kicked = unseen & (load(at.lanes, SEEN) < 0.0)
    for signal in range(sizes.signals if sizes.seen == 0 else 0):
        store(rates, signal, choose(kicked, splat(np.nan), load(rates, signal)))
    store(at.lanes, SEEN, choose(good, splat(1.0), load(at.lanes, SEEN)))


@apart
def _look_into(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    good: Mask, t: Lanes, length: Lanes, until: Lanes, closed: bool,
) -> None:  # fmt: skip
    """Keep what has to be of a step in the lanes `good`, of what its ends do not say everything of."""
    cut = load(at.lanes, PICKED) < 0.0
    whole = choose(until < load(at.lanes, UNTIL), (until - t) / length, 1.0)
    _open(kernels, sizes, nodes, at, t, length, closed)
    if keep_panels(kernels, sizes, at, first, rows, plan, t, length, until, whole, good, cut):
        look(kernels, sizes, at, t, length, splat(0.0), signals(sizes, at, 0, 0))
    for signal in range(sizes.signals):
        before, after = value_of(sizes, at, 0, signal, 0), value_of(sizes, at, 0, signal, POINTS - 1)
        changes = signals(sizes, at, 0, CHANGES)
        store(changes, signal, choose(good, after - before, load(changes, signal)))
        store(signals(sizes, at, 0, 0), signal, choose(good, after, before))
    store(at.lanes, SEEN, choose(good & cut, splat(-1.0), load(at.lanes, SEEN)))
    forget_past(sizes, at, good & cut)


@inlined
def _said(sizes: Sizes, at: Workspace, n: int) -> Lanes:
    """The nth number that F at the end of the step says of signals: first their rates, then these themselves."""
    return load(at.slopes, layout.said_row(sizes, sizes.integrands + n, sizes.slopes - 1))


@inlined
def renew_rates(sizes: Sizes, at: Workspace, lanes: Mask) -> None:
    """Where a step begins with another F than the last one has ended with, signals have other rates."""
    rates = signals(sizes, at, 0, RATES)
    for signal in range(sizes.signals):
        store(rates, signal, choose(lanes, _said(sizes, at, signal), load(rates, signal)))


@inlined
def _keep(kernels: np.ndarray, sizes: Sizes, at: Workspace, new: Address) -> None:
    """What the end of the step says."""
    for n in range(sizes.seen):
        store(at.measures, layout.seen_row(sizes) + n, _said(sizes, at, n))
    if sizes.leaping > 0:
        store(at.clock, layout.LEAN, -LEANING * load(at.clock, layout.LENGTH))
    call(kernels[layout.KEEP], new, at.parameters, at.clock, at.lanes, at.measures, at.work)
    if sizes.leaping > 0:
        store(at.clock, layout.LEAN, splat(0.0))


@inlined
def measure(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    good: Mask, t: Lanes, length: Lanes, until: Lanes, leaves: Mask,
) -> None:  # fmt: skip
    """Keep what has to be of the open step in the lanes `good`, which are left at `until`; leaves: those in which an
    event is why. The clock stays as it is. Whether the step is looked into is a matter of each lane, and of each thing
    that is kept."""
    now, end = load(at.clock, layout.TIME), load(at.lanes, UNTIL)
    unseen = good & (load(at.lanes, SEEN) <= 0.0)
    if any_lane(unseen):
        _see(kernels, sizes, at, t, length, good, unseen)
    store(at.clock, layout.TIME, end)
    store(at.lanes, PICKED, choose(good, choose(leaves, splat(-1.0), 1.0), 0.0))
    _keep(kernels, sizes, at, at.new)
    if any_lane(load(at.measures, layout.open_row(sizes)) != 0.0):
        _look_into(kernels, sizes, nodes, at, first, rows, plan, good, t, length, until, False)
    store(at.clock, layout.TIME, now)


@inlined
def take_gains(kernels: np.ndarray, sizes: Sizes, at: Workspace, x: Address, made: Address) -> None:
    """What a step from x has just said that signals integrate to, at `made` or by its slopes."""
    to = at.measures + ROW * layout.gain_row(sizes)
    if kernels[layout.QUADRATURE] != 0:
        call(kernels[layout.QUADRATURE], x, at.parameters, at.clock, at.slopes, to, at.work)
    else:
        stages.copy(to, made, sizes.integrands)


@inlined
def measure_closed(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    good: Mask, x: Address, places: Places,
) -> None:  # fmt: skip
    """The same where states change places, and the clock is at the end of the step, which no lane leaves before. What
    is rarely done is told nothing that would have to wait for it."""
    store(at.lanes, PICKED, choose(good, splat(1.0), splat(0.0)))
    if any_lane(good & (load(at.lanes, SEEN) <= 0.0)):
        _see_closed(kernels, sizes, at, x, places)
    _keep(kernels, sizes, at, places.new)
    if any_lane(load(at.measures, layout.open_row(sizes)) != 0.0):
        _look_into_closed(kernels, sizes, nodes, at, first, rows, plan, x, places)


@inlined
def _placed(at: Workspace, x: Address, places: Places) -> Workspace:
    """The regions where states have changed places, of which none but the slopes' own may lie before these."""
    now, following = places.now, places.following
    if following == at.new:
        now, following = following, now
    return Workspace(
        x, places.new, at.slopes, at.control, now, following, at.clock, at.lanes, at.u, at.conditions, at.table,
        at.change, at.measures, at.parameters, at.work,
    )  # fmt: skip


@apart
def _see_closed(kernels: np.ndarray, sizes: Sizes, at: Workspace, x: Address, places: Places) -> None:
    """`_see` of a step that is `PICKED`."""
    t, length, until = load(at.lanes, T), load(at.clock, layout.LENGTH), load(at.lanes, UNTIL)
    good = load(at.lanes, PICKED) != 0.0
    unseen = good & (load(at.lanes, SEEN) <= 0.0)
    _see(kernels, sizes, _placed(at, x, places), t, length, good, unseen)
    store(at.clock, layout.TIME, until)


@apart
def _look_into_closed(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    x: Address, places: Places,
) -> None:  # fmt: skip
    """`_look_into` of a step that is `PICKED`."""
    t, length, until = load(at.lanes, T), load(at.clock, layout.LENGTH), load(at.lanes, UNTIL)
    good, here = load(at.lanes, PICKED) != 0.0, _placed(at, x, places)
    _look_into(kernels, sizes, nodes, here, first, rows, plan, good, t, length, until, True)
    store(at.clock, layout.TIME, until)


@apart
def begin_measures(kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan) -> None:
    """What is kept of runs that begin: what holds at their start."""
    store(at.clock, layout.TIME, splat(0.0))
    call(kernels[layout.MEASURE], at.state, at.parameters, at.clock, 0, signals(sizes, at, 0, 0), at.work)
    seen = first.measures + layout.signal_row(sizes, 0)
    changes = first.measures + layout.signal_row(sizes, CHANGES)
    rates = first.measures + layout.signal_row(sizes, RATES)
    largest = first.measures + layout.signal_row(sizes, LARGEST_SIZES)
    for lane in range(W):
        for signal in range(sizes.signals):
            if rows[first.lanes + FRESH, lane] != 0.0:
                rows[changes + signal, lane] = np.inf
                rows[rates + signal, lane] = np.nan
                now = rows[seen + signal, lane]
                rows[largest + signal, lane] = max(now, -now) if now == now else 0.0
        if rows[first.lanes + FRESH, lane] != 0.0:
            forget_past_of(lane, rows, first, sizes)
    for n in range(sizes.kept):
        kept, kind = first.measures + layout.KEPT_ROWS * n, plan.kept[n, KEPT_KIND]
        value, condition = plan.kept[n, KEPT_SIGNAL], plan.kept[n, KEPT_CONDITION]
        lasting = kind < INTEGRATES or KEEPS_FIRST <= kind <= KEEPS_LAST
        for lane in range(W):
            if rows[first.lanes + FRESH, lane] == 0.0:
                continue
            true = condition < 0 or rows[seen + condition, lane] > 0.0
            rows[kept + KEPT_TRUE, lane] = 1.0 if true else 0.0
            now = rows[seen + condition, lane] if condition >= 0 else 0.0
            unknown = now != now
            rows[kept + KEPT_SIZE, lane] = 0.0 if unknown else max(now, -now)
            rows[kept + KEPT_UNDEFINED, lane] = 1.0 if unknown else 0.0
            rows[kept + KEPT_VALUE, lane] = rows[kept + KEPT_TIME, lane] = np.nan if lasting else 0.0
            if true and kind == COUNTS:
                rows[kept + KEPT_VALUE, lane] = 1.0
            if true and lasting:
                rows[kept + KEPT_TIME, lane] = 0.0
                rows[kept + KEPT_VALUE, lane] = rows[seen + value, lane] if value >= 0 else 1.0
