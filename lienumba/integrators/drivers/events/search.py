"""Where in the open step conditions become true: one search of all lanes, each for a condition of its own.

Where the mechanism changes, what the step was computed with is as good as the method at its ends alone: a step that has
a change inside is tried again, to end directly behind it. There the end of the step says where it is, and the stages of
the extension are not needed. A series is as good everywhere.
"""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, any_lane, call, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import W
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue, keep_state
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    ACTION,
    AFTER,
    BEFORE,
    CUT,
    DIPS,
    FOUND,
    LOW,
    NEAR,
    OFF,
    OPENS,
    PICKED,
    RECORDS,
    ROUGH,
    SEEKS,
    SLIDES,
    SWITCH_KIND,
    UNILATERAL,
    UNTIL,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import maximum

SOUGHT = -1.0  # in the place of a time: it is yet to be found
FINEST = 2.0**-52  # a fraction of a step is known to the last bit
LONGEST_SEARCH = 200  # of tries
TOUCH = 1e-9  # of the length of a contact: where its gap is at most so wide it touches
LEAVES = 1e-6  # the same: by how much what comes apart may overlap yet, since a step was cut a little behind its impact
EDGE = 1e-3  # of a step: nearer to its ends the extension is as good as the step
CLOSE_TO = 2.0**-24  # of a step: how exactly it is known where a step is to be cut
LATER = 2.0**-23  # of a step: by how much it is cut later, so that the condition is true at its end
VICINITY = 2.0**-22  # of a step that was cut: how far from its end the condition is not true yet
STRAIGHT_TRIES = 3  # to find it on a straight line there
FLAT = 0.0625  # a secant that goes less far tells nothing


@inlined
def _margins(
    kernels: np.ndarray,
    kernel: int,
    at: Workspace,
    first: Workspace,
    rows: Rows,
    t: Lanes,
    length: Lanes,
    fraction: Lanes,
) -> Lanes:
    """What each lane SEEKS, at a fraction of the open step."""
    look_within(kernels, kernel, at, t, length, fraction)
    own, found = first.lanes, matrix(at.following, first.following - first.now, W)
    for lane in range(W):
        rows[own + FOUND, lane] = found[int(rows[own + SEEKS, lane]), lane]
    return load(at.lanes, FOUND)


@inlined
def look_within(kernels: np.ndarray, kernel: int, at: Workspace, t: Lanes, length: Lanes, fraction: Lanes) -> None:
    """All conditions at a fraction of the open step, to `following`; kernel: that says them (see `layout.ORDER`)."""
    store(at.clock, layout.TIME, t)
    if kernel == layout.EVENTS and kernels[layout.WATCH] != 0:
        store(at.clock, layout.FRACTION, fraction)
        call(kernels[layout.WATCH], at.state, at.parameters, at.clock, at.slopes, at.following, at.work)
        return
    between(kernels, at, fraction)
    store(at.clock, layout.TIME, t + fraction * length)
    call(kernels[kernel], at.now, at.parameters, at.clock, 0, at.following, at.work)


@apart
def locate(
    kernels: np.ndarray, kernel: int, at: Workspace, first: Workspace, rows: Rows, t: Lanes, length: Lanes,
    begin: Lanes, end: Lanes, before: Lanes, after: Lanes, lanes: Mask, rough: Mask, sense: Lanes,
) -> Lanes:  # fmt: skip
    """The fraction of the open step at which what a lane SEEKS is true, directly behind one at which it is not, in
    these lanes, as exactly as times are different numbers; before, after: what it is at the fractions `begin` and
    `end`; kernel: that says it (see `layout.ORDER`); sense: -1 where it is true below 0; rough: within `CLOSE_TO` will
    do where it is not near an end of the step. By Chandrupatla's method, from a secant on: inverse quadratic
    interpolation where three values allow it, else halves. Where the root stays on one side, it is felt for in steps
    that double: near it a condition is rounding, of which no interpolation makes sense."""
    low, high, f_low, f_high = begin, end, before, after
    third, f_third = begin, before  # the end that was replaced last
    newest_low, part = splat(1.0), before / (before - after)  # whether the last value is that of `low`; of the way on
    part = choose(part > FLAT, part, 0.5)
    finest = finest_part(t, length)
    least, reach, left = finest, finest, lanes
    for _ in range(LONGEST_SEARCH):
        if not any_lane(left):
            break
        lower = newest_low == 1.0
        a, b = choose(lower, low, high), choose(lower, high, low)
        x = a + part * (b - a)
        f = sense * _margins(kernels, kernel, at, first, rows, t, length, x)
        true = f > 0.0
        replaced, f_replaced = choose(true, high, low), choose(true, f_high, f_low)
        third, f_third = choose(left, replaced, third), choose(left, f_replaced, f_third)
        high, f_high = choose(left & true, x, high), choose(left & true, f, f_high)
        low, f_low = choose(true, low, choose(left, x, low)), choose(true, f_low, choose(left, f, f_low))
        newest = choose(true, splat(0.0), splat(1.0))
        inside = rough & (x > 2.0 * EDGE) & (x < 1.0 - 2.0 * EDGE)
        least = choose(inside, maximum(finest, splat(CLOSE_TO)), finest)
        reach = choose(newest == newest_low, maximum(2.0 * reach, least), least)
        newest_low = choose(left, newest, newest_low)
        left = left & (high - low > least)
        part = choose(left, _part(low, f_low, high, f_high, third, f_third, newest_low == 1.0, reach), part)
    store(at.clock, layout.TIME, t)
    return high


@inlined
def finest_part(t: Lanes, length: Lanes) -> Lanes:
    """The least fraction of a step that makes another time."""
    return FINEST * maximum(splat(1.0), (t + length) / length)


@inlined
def _part(
    low: Lanes, f_low: Lanes, high: Lanes, f_high: Lanes, third: Lanes, f_third: Lanes, lower: Mask, reach: Lanes
) -> Lanes:  # fmt: skip
    """Where to look next, as a part of the way from the newest end of the bracket to the other; reach: how far away
    from both at least."""
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


@apart
def _along(
    kernels: np.ndarray, at: Workspace, first: Workspace, rows: Rows, t: Lanes, length: Lanes, low: Lanes,
    before: Lanes, after: Lanes, lanes: Mask,
) -> Lanes:  # fmt: skip
    """As `locate`, between the fraction `low` and the end of the step, where a condition is next to a straight line;
    1 where it is not. The place is behind the root by a few times more than times differ."""
    finest, slope, left = finest_part(t, length), (after - before) / (1.0 - low), lanes
    found, x, behind = splat(1.0), low - before / (after - before) * (1.0 - low), 1.0
    for _ in range(STRAIGHT_TRIES):
        x = x + behind * finest
        tried = choose(left & (x < 1.0) & (x > low), x, low)
        miss = _margins(kernels, layout.EVENTS, at, first, rows, t, length, tried)
        there = left & (miss > 0.0) & (miss <= 8.0 * behind * finest * slope)
        found = choose(there, x, found)
        left = left & (found == 1.0)
        if not any_lane(left):
            break
        x, behind = x - miss / slope, 2.0 * behind
    return found


@apart
def _near(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, plan: Plan,
    seeks: Mask, t: Lanes, length: Lanes,
) -> None:  # fmt: skip
    """NEAR: which lanes seek one condition alone, at the end of a step that was cut for it. All conditions at LOW,
    directly before it, go to `following`."""
    count, own = layout.conditions(sizes), first.lanes
    times = first.conditions + 2 * count
    cut = seeks & (load(at.lanes, UNTIL) == load(at.lanes, CUT))
    store(at.lanes, NEAR, splat(0.0))
    store(at.lanes, LOW, splat(0.0))
    if kernels[layout.EXPAND] != 0 or not any_lane(cut):  # a series says it all
        return
    low = 1.0 - maximum(splat(VICINITY), 8.0 * finest_part(t, length))
    cut = cut & (low > 0.5)
    stages.end_slope(kernels, sizes, at, load(at.lanes, UNTIL))
    stages.extend_at_end(sizes, nodes, at, cut)
    look_within(kernels, layout.EVENTS, at, t, length, low)
    store(at.lanes, NEAR, choose(cut, splat(1.0), splat(0.0)))
    for lane in range(W):
        sought = 0
        for n in range(count if rows[own + NEAR, lane] != 0.0 else 0):
            if rows[times + n, lane] == SOUGHT:
                late = rows[first.following + n, lane] <= 0.0 and not _dips(sizes, first, rows, plan, lane, n)
                sought += 1 if late else 2
        if sought != 1:
            rows[own + NEAR, lane] = 0.0
    store(at.lanes, LOW, choose(load(at.lanes, NEAR) != 0.0, low, splat(0.0)))


@inlined
def _dips(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, n: int) -> bool:
    """Whether a condition is the rate of an open gap."""
    if n < sizes.events or (n - sizes.events) % layout.CONDITIONS != SLIDES:
        return False
    switch = (n - sizes.events) // layout.CONDITIONS
    off = rows[first.state + layout.on_row(sizes) + switch, lane] == OFF
    return off and plan.switches[switch, SWITCH_KIND] == UNILATERAL


@apart
def _choose_sought(exact: bool, sizes: Sizes, first: Workspace, rows: Rows, plan: Plan) -> bool:
    """The first condition that each PICKED lane seeks; those without one are not PICKED afterwards. Returns whether
    there is any."""
    count, own, found = layout.conditions(sizes), first.lanes, False
    times = first.conditions + 2 * count
    for lane in range(W):
        n = 0 if rows[own + PICKED, lane] != 0.0 else count
        while n < count and rows[times + n, lane] != SOUGHT:
            n += 1
        picked, near = n < count, rows[own + NEAR, lane] != 0.0
        rows[own + PICKED, lane], rows[own + DIPS, lane], rows[own + ROUGH, lane] = 1.0 if picked else 0.0, 0.0, 0.0
        n = n if picked else 0
        before, after = rows[first.conditions + n, lane], rows[first.conditions + count + n, lane]
        if not before < 0.0:  # at 0, where something has just closed or opened
            before = -after
        rows[own + SEEKS, lane], rows[own + AFTER, lane] = float(n), after
        rows[own + BEFORE, lane] = rows[first.following + n, lane] if near else before
        if picked:
            dips = _dips(sizes, first, rows, plan, lane, n)
            rows[own + DIPS, lane] = 1.0 if dips else 0.0
            acts = n >= sizes.events or (plan.acts[n, ACTION] != RECORDS and plan.stops[n] == 0)
            rows[own + ROUGH, lane] = 1.0 if acts and not (exact or dips or near) else 0.0
            found = True
    return found


@apart
def _dive(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, t: Lanes, length: Lanes,
    fraction: Lanes,
) -> None:  # fmt: skip
    """Of open gaps that begin to grow, at this fraction of the step, the time at which they closed before, if they did,
    by more than what touches."""
    own, times = first.lanes, first.conditions + 2 * layout.conditions(sizes)
    for lane in range(W):
        if rows[own + DIPS, lane] != 0.0:
            rows[times + int(rows[own + SEEKS, lane]), lane] = NEVER
            rows[own + SEEKS, lane] += float(OPENS - SLIDES)
            if rows[times + int(rows[own + SEEKS, lane]), lane] != NEVER:
                rows[own + DIPS, lane] = 0.0
    deep = _margins(kernels, layout.EVENTS, at, first, rows, t, length, fraction)
    dives = (load(at.lanes, DIPS) != 0.0) & (deep > TOUCH)
    if any_lane(dives):
        nowhere = dives & (deep < 0.0)
        part = locate(
            kernels, layout.EVENTS, at, first, rows, t, length, splat(0.0), fraction, -deep, deep, dives, nowhere,
            splat(1.0),
        )  # fmt: skip
        store(at.lanes, FOUND, t + part * length)
        store(at.lanes, DIPS, choose(dives, splat(1.0), splat(0.0)))
        for lane in range(W):
            if rows[own + DIPS, lane] != 0.0:
                rows[times + int(rows[own + SEEKS, lane]), lane] = rows[own + FOUND, lane]
    store(at.clock, layout.TIME, t)


@apart
def _keep_found(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    t: Lanes, length: Lanes, found: Lanes,
) -> None:  # fmt: skip
    """The fraction of the open step at which what the PICKED lanes SEEK is true is its time, and the state there is
    kept."""
    own, times, kept = first.lanes, first.conditions + 2 * layout.conditions(sizes), False
    store(at.lanes, FOUND, choose(found == 1.0, load(at.lanes, UNTIL), t + found * length))
    for lane in range(W):
        if rows[own + PICKED, lane] != 0.0:
            rows[times + int(rows[own + SEEKS, lane]), lane] = rows[own + FOUND, lane]
            kept = kept or int(rows[own + SEEKS, lane]) < runs.event_states.shape[1]
    if kept:
        between(kernels, at, found)
        stages.commit(found >= 1.0, at.now, at.new, layout.state_rows(sizes))
        for lane in range(W):
            if rows[own + PICKED, lane] != 0.0:
                keep_state(first, rows, runs, queue, lane, int(rows[own + SEEKS, lane]), first.now)


@apart
def search_between(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue,
    n: int, t: Lanes, length: Lanes, begin: Lanes, end: Lanes, before: Lanes, after: Lanes, lanes: Mask,
) -> None:  # fmt: skip
    """Find the time of one condition between two fractions of the open step, at which it is so much, in these lanes."""
    store(at.lanes, SEEKS, splat(float(n)))
    store(at.lanes, PICKED, choose(lanes, splat(1.0), splat(0.0)))
    place = locate(
        kernels, layout.EVENTS, at, first, rows, t, length, begin, end, before, after, lanes, splat(0.0) > 0.0,
        splat(1.0),
    )  # fmt: skip
    _keep_found(kernels, sizes, at, first, rows, runs, queue, t, length, place)


@apart
def search(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, first: Workspace, rows: Rows, runs: ChunkRuns,
    queue: Queue, plan: Plan, seeks: Mask, t: Lanes, length: Lanes,
) -> None:  # fmt: skip
    """Find the times of the conditions that are SOUGHT in the lanes `seeks`."""
    exact = kernels[layout.EXPAND] != 0
    _near(kernels, sizes, nodes, at, first, rows, plan, seeks, t, length)
    far = seeks & (load(at.lanes, NEAR) == 0.0)
    if any_lane(far):
        stages.extend(kernels, sizes, nodes, at, t, length, load(at.lanes, UNTIL))
        stages.extend_at_end(sizes, nodes, at, load(at.lanes, NEAR) != 0.0)
    store(at.lanes, PICKED, choose(seeks, splat(1.0), splat(0.0)))
    while _choose_sought(exact, sizes, first, rows, plan):
        picked = load(at.lanes, PICKED) != 0.0
        before, after, low = load(at.lanes, BEFORE), load(at.lanes, AFTER), load(at.lanes, LOW)
        rough = load(at.lanes, ROUGH) != 0.0
        found, near = splat(1.0), picked & (load(at.lanes, NEAR) != 0.0)
        if any_lane(near):
            found = _along(kernels, at, first, rows, t, length, low, before, after, near)
            picked = picked & (choose(found < 1.0, 1.0, 0.0) == 0.0)
        if any_lane(picked):
            place = locate(
                kernels, layout.EVENTS, at, first, rows, t, length, low, splat(1.0), before, after, picked, rough,
                splat(1.0),
            )  # fmt: skip
            found = choose(picked, place, found)
        _keep_found(kernels, sizes, at, first, rows, runs, queue, t, length, found)
        if any_lane(load(at.lanes, DIPS) != 0.0):
            _dive(kernels, sizes, at, first, rows, t, length, found)


@inlined
def read_off(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, t: Lanes, length: Lanes, left: Lanes
) -> None:
    """The states at the times `left` of the open step, to `now`."""
    near = load(at.lanes, NEAR) != 0.0
    if any_lane(near):
        stages.extend_at_end(sizes, nodes, at, near)
    between(kernels, at, (left - t) / length)
