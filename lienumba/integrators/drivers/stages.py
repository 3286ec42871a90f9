"""What drivers do with one block: a step by stages, projections, another selection of constraint rows, a record.

They know rows of lanes, not mechanics; kernels are called by their addresses. A run feels nothing of its neighbours:
every iteration is committed by lane.
"""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, all_lanes, any_lane, call, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout, selection_table
from lienumba.integrators.drivers.row_selection import select_rows
from lienumba.integrators.drivers.workspace import Context, Places
from lienumba.integrators.layout import UNTIL, T
from lienumba.numerics.operations import maximum


@inlined
def commit(mask: Mask, target: Address, source: Address, rows: int) -> None:
    """target = source in the lanes of the mask."""
    for row in range(rows):
        store(target, row, choose(mask, load(source, row), load(target, row)))


@inlined
def copy(target: Address, source: Address, rows: int) -> None:
    for row in range(rows):
        store(target, row, load(source, row))


@apart
def record(context: Context, to: Address, state: Address, p: Address, alive: Mask, iterations: Address) -> None:
    """Store state, observed rows and iterations; NaN in the lanes that are not alive. A NaN that was computed has the
    sign that the processor gives it: all that are stored are the same one."""
    rows = layout.state_rows(context.sizes)
    call(context.kernels[layout.OBSERVE], state, p, context.at.clock, 0, to + ROW * rows, context.at.work)
    copy(to, state, rows)
    copy(to + ROW * (rows + context.sizes.observed), iterations, layout.PROJECTIONS)
    for row in range(layout.record_rows(context.sizes)):
        x = load(to, row)
        store(to, row, choose(alive & (x == x), x, splat(np.nan)))


class Iteration(NamedTuple):
    """How a projection is iterated: the kernels of the first and of all further iterations; the row of the violation in
    what they give; how many rows of that become the next iterate, and how many this keeps behind them."""

    first: Address
    further: Address
    violation: int
    committed: int
    carried: int


@inlined
def iterate(
    context: Context, how: Iteration, p: Address, hat: Address, places: Places, status: Address, pending: Mask,
    exchange: bool,
) -> tuple[Lanes, Places]:  # fmt: skip
    """Iterate a projection from `places.now` until every pending lane is within the tolerance; returns each lane's
    iterations, and the places with the last iterate as `now`.

    hat: what is projected, 0: the iterate itself; the place `new` is spare; exchange: whether iterates may change
    places.
    """
    used, now, following, spare = splat(0.0), places.now, places.following, places.new
    for n in range(context.limit):
        if not any_lane(pending):
            return used, Places(spare, now, following)
        kernel = how.first if n == 0 else how.further
        call(kernel, now if hat == 0 else hat, p, context.at.clock, now, following, context.at.work)
        code = load(following, how.violation - layout.VIOLATION + layout.ITERATE_CODE)
        left = load(following, how.violation)
        if exchange and all_lanes(pending):
            copy(following + ROW * how.committed, now + ROW * how.committed, how.carried)
            if now == hat:
                now, following, spare = following, spare, now
            else:
                now, following = following, now
        else:
            commit(pending, now, following, how.committed)
        used = used + choose(pending, 1.0, 0.0)
        store(status, 0, choose(pending, choose(code == 0.0, load(status, 0), code), load(status, 0)))
        pending = pending & (load(status, 0) == 0.0) & (left > context.tolerance)
    store(status, 0, choose(pending, splat(codes.NOT_CONVERGED), load(status, 0)))
    return used, Places(spare, now, following)


@apart
def reselect(context: Context, state: Address, p: Address, lanes: Mask, target: Address) -> Mask:
    """Select the constraint rows anew at a state in these lanes; the masks go to the state `target`.
    Returns in which lanes they are others than before."""
    q = context.sizes.exchangeable
    first = layout.element_rows(context.sizes) + context.sizes.first_mask
    masks, asked = selection_table.table_masks(q), selection_table.table_asked(q)
    room = matrix(context.at.table + ROW * selection_table.table_room(q), q + 2, q)
    call(context.kernels[layout.SCHUR], state, p, context.at.clock, 0, context.at.table, context.at.work)
    for i in range(q):
        store(context.at.table, masks + i, load(target, first + i))
    store(context.at.table, asked, choose(lanes, splat(1.0), splat(0.0)))
    for lane in range(W):
        if context.table[asked, lane] != 0.0:
            select_rows(context.table, lane, q, room)
    same = splat(1.0)
    for i in range(q):
        mask = choose(lanes, load(context.at.table, masks + i), load(target, first + i))
        same = choose(mask == load(target, first + i), same, 0.0)
        store(target, first + i, mask)
    store(target, first + q, choose(lanes, splat(0.0), load(target, first + q)))
    return same == 0.0


@inlined
def project_positions(
    context: Context, p: Address, places: Places, movable: bool, status: Address, pending: Mask, closing: bool
) -> tuple[Lanes, Places]:
    """Project the positions of `new` in the pending lanes; returns each lane's iterations, and the places.
    closing: over gaps.

    Where it does not converge, a constraint that said the same as others may have begun to say something of its own:
    the rows are selected anew where the iteration has come to, and it starts again; with fixed rows that is for another
    program to do.
    """
    rows = layout.element_rows(context.sizes)
    iterated = rows + context.sizes.correction
    first, chord = context.kernels[layout.POSITION], context.kernels[layout.CHORD]
    if closing and context.kernels[layout.CLOSURE] != 0:
        first, chord = context.kernels[layout.CLOSURE], 0
    again = chord if chord != 0 else first  # reads what the first one left behind its iterate: that stays in its place
    used, new = splat(0.0), places.new
    for attempt in range(2):
        # an iterate begins as a copy of `new`, or is `new`, whose rows behind the bodies have been read
        if not (movable and chord == 0 and context.sizes.augmented == 0 and all_lanes(pending)):
            copy(places.now, new, rows)
        else:
            places = Places(places.now, new, places.following)
        for row in range(rows, iterated):
            store(places.now, row, splat(0.0))
        violation = iterated + layout.VIOLATION
        how = Iteration(first, again, violation, iterated, 0)
        count, places = iterate(context, how, p, new, places, status, pending, chord == 0)
        used = used + count
        done = pending & (load(status, 0) == 0.0)
        if movable and all_lanes(done):
            copy(places.now + ROW * rows, new + ROW * rows, context.sizes.augmented)
            return used, Places(places.now, new, places.following)
        commit(done, new, places.now, rows)
        pending = pending & (load(status, 0) == codes.NOT_CONVERGED)
        if attempt == 1 or context.sizes.exchangeable == 0 or not any_lane(pending):
            break
        copy(places.now + ROW * rows, new + ROW * rows, context.sizes.augmented)
        others = reselect(context, places.now, p, pending, new)
        if context.sizes.fixed != 0:
            store(status, 0, choose(others, codes.RESELECT, load(status, 0)))
            break
        store(status, 0, choose(pending, splat(0.0), load(status, 0)))
    return used, places


@inlined
def project_velocities(
    context: Context, p: Address, places: Places, movable: bool, status: Address, pending: Mask
) -> tuple[Lanes, Places]:
    """Project the velocities of `new` in the pending lanes; returns each lane's iterations, and the places."""
    rows, kernel = layout.element_rows(context.sizes), context.kernels[layout.VELOCITY]
    violation = rows + layout.VIOLATION
    how = Iteration(kernel, kernel, violation, rows, context.sizes.augmented)
    there = Places(places.now, places.new, places.following)
    used, after = iterate(context, how, p, 0, there, status, pending, movable)
    return used, Places(after.now, after.new, after.following)


@inlined
def project(
    context: Context, p: Address, places: Places, movable: bool, status: Address, going: Mask, iterations: Address
) -> Places:
    """Project positions and velocities of `new` in the lanes `going`; the most so far go to the rows `iterations`.
    Returns the places; movable: whether `new` may get another one, where its code and margin do not follow."""
    if context.kernels[layout.POSITION] != 0:
        pending = going & (load(status, 0) == 0.0)
        used, places = project_positions(context, p, places, movable, status, pending, False)
        store(iterations, 0, choose(used > load(iterations, 0), used, load(iterations, 0)))
    if context.kernels[layout.VELOCITY] != 0:
        pending = going & (load(status, 0) == 0.0)
        used, places = project_velocities(context, p, places, movable, status, pending)
        store(iterations, 1, choose(used > load(iterations, 1), used, load(iterations, 1)))
    return places


@apart
def stage(context: Context, s: int, x: Address, p: Address, t: Lanes, h: Lanes) -> Lanes:
    """The slopes of stage s of a step; returns the largest squared rotation of its argument."""
    size, combine = context.sizes.coordinates, context.kernels[layout.COMBINE + s]
    store(context.at.clock, layout.TIME, t + context.nodes[s] * h)
    store(context.at.clock, layout.NODE, splat(context.nodes[s]))
    rotation = splat(0.0)
    for i in range(context.sizes.elements if combine != 0 else 0):
        slopes = context.at.slopes + ROW * layout.slope_row(context.sizes, i, 0)
        call(combine, 0, p, context.at.clock, slopes, context.at.u + ROW * size * i, context.at.work)
        rotation = maximum(load(context.at.u, size * (i + 1)), rotation)
    slopes = context.at.slopes + ROW * layout.slope_row(context.sizes, 0, s)
    call(
        context.kernels[layout.STAGE if combine != 0 else layout.FIRST],
        x,
        p,
        context.at.clock,
        context.at.u,
        slopes,
        context.at.work,
    )
    return rotation


@inlined
def end_slope(context: Context) -> None:
    """The slope at the end of the current step, about its start."""
    if context.kernels[layout.CLOSE] == 0:
        store(context.at.clock, layout.TIME, load(context.at.lanes, UNTIL))
        last = context.at.slopes + ROW * layout.slope_row(context.sizes, 0, context.sizes.slopes - 1)
        call(
            context.kernels[layout.FIRST],
            context.at.new,
            context.at.parameters,
            context.at.clock,
            0,
            last,
            context.at.work,
        )
    call(
        context.kernels[layout.END],
        context.at.state,
        context.at.parameters,
        context.at.clock,
        context.at.slopes,
        context.at.slopes,
        context.at.work,
    )


@apart
def extend(context: Context) -> None:
    """The slope at the end of the current step, and those of the stages that only the continuous extension needs; a
    series says it all."""
    if context.kernels[layout.EXPAND] != 0:
        return
    t, length = load(context.at.lanes, T), load(context.at.clock, layout.LENGTH)
    end_slope(context)
    for s in range(context.sizes.stages + 1, context.sizes.slopes - 1):
        stage(context, s, context.at.state, context.at.parameters, t, length)
    store(context.at.clock, layout.TIME, t)


@apart
def extend_at_end(context: Context, lanes: Mask) -> None:
    """Behind `end_slope`: what will do for the continuous extension next to the end of the step in these lanes. What
    only the extension needs has the weight (1 - fraction)^2 there: a straight line between the ends is enough."""
    last = layout.report_row(context.sizes, context.sizes.slopes - 1)
    for s in range(context.sizes.stages + 1, context.sizes.slopes - 1):
        for i in range(context.sizes.elements):
            first, end = layout.slope_row(context.sizes, i, 0), layout.slope_row(context.sizes, i, context.sizes.stages)
            for n in range(context.sizes.coordinates):
                _between(
                    context.at.slopes,
                    lanes,
                    context.nodes[s],
                    first + n,
                    end + n,
                    layout.slope_row(context.sizes, i, s) + n,
                )
        for n in range(layout.REPORTS):
            _between(
                context.at.slopes,
                lanes,
                context.nodes[s],
                layout.report_row(context.sizes, 0) + n,
                last + n,
                layout.report_row(context.sizes, s) + n,
            )


@inlined
def _between(slopes: Address, lanes: Mask, node: float, first: int, end: int, row: int) -> None:
    """On the straight line from one row to another."""
    a = load(slopes, first)
    store(slopes, row, choose(lanes, a + node * (load(slopes, end) - a), load(slopes, row)))


@apart
def staged_step(context: Context, since: int, x: Address, p: Address, new: Address) -> None:
    """One step stage by stage, from stage `since` on, for mechanisms whose step is too long for one kernel; code and
    margin go behind `new`.

    The kernels of one body put what they report behind the body's rows: it is read before the next body's call, whose
    rows begin there.
    """
    t, h = load(context.at.clock, layout.TIME), load(context.at.clock, layout.LENGTH)
    rotation, square, first, every = splat(0.0), splat(0.0), splat(1.0), splat(1.0)
    for s in range(context.sizes.stages):
        if s >= since:
            rotation = maximum(stage(context, s, x, p, t, h), rotation)
        sound = load(context.at.slopes, layout.report_row(context.sizes, s) + layout.NONSINGULAR)
        every = choose(sound < every, sound, every)
        first = every if s == 0 else first
    for i in range(context.sizes.elements):
        element, slopes = (
            ROW * context.sizes.element * i,
            context.at.slopes + ROW * layout.slope_row(context.sizes, i, 0),
        )
        call(context.kernels[layout.ADVANCE], x + element, p, context.at.clock, slopes, new + element, context.at.work)
        rotation = maximum(load(new, context.sizes.element * (i + 1) + layout.TURNED), rotation)
        square = square + load(new, context.sizes.element * (i + 1) + layout.MOVED)
    rows, behind = ROW * layout.element_rows(context.sizes), layout.state_rows(context.sizes)
    copy(new + rows, x + rows, context.sizes.augmented)
    store(context.at.clock, layout.TIME, t + h)
    if context.sizes.augmented > 0:
        call(context.kernels[layout.FINISH], new, p, context.at.clock, context.at.slopes, context.at.u, context.at.work)
        copy(new + rows, context.at.u, context.sizes.augmented)
    code = codes.verdict(rotation, square, first, every)
    store(new, behind + layout.CODE, choose(every < 0.0, splat(codes.PARADOX), code))
    store(
        new, behind + layout.MARGIN, load(context.at.slopes, layout.report_row(context.sizes, 0) + layout.STAGE_MARGIN)
    )
