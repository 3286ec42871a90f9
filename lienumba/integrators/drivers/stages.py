"""What drivers do with one block: a step by stages, projections, another selection of constraint rows, a record.

They know rows of lanes, not mechanics; kernels are called by their addresses. A run feels nothing of its neighbours:
every iteration is committed by lane.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, all_lanes, any_lane, call, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout, selection_table
from lienumba.integrators.drivers.row_selection import select_rows
from lienumba.integrators.drivers.workspace import Places, Rows
from lienumba.integrators.layout import Workspace
from lienumba.integrators.sizes import Sizes
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
def record(
    kernels: np.ndarray, sizes: Sizes, to: Address, state: Address, p: Address, at: Workspace, alive: Mask,
    iterations: Address,
) -> None:  # fmt: skip
    """Store state, observed rows and iterations; NaN in the lanes that are not alive. A NaN that was computed has the
    sign that the processor gives it: all that are stored are the same one."""
    rows = layout.state_rows(sizes)
    call(kernels[layout.OBSERVE], state, p, at.clock, 0, to + ROW * rows, at.work)
    copy(to, state, rows)
    copy(to + ROW * (rows + sizes.observed), iterations, layout.PROJECTIONS)
    for row in range(layout.record_rows(sizes)):
        x = load(to, row)
        store(to, row, choose(alive & (x == x), x, splat(np.nan)))


@inlined
def iterate(
    kernel: int, again: int, p: Address, hat: Address, places: Places, at: Workspace, status: Address, pending: Mask,
    limit: int, tolerance: float, violation: int, committed: int, carried: int, exchange: bool,
) -> tuple[Lanes, Places]:  # fmt: skip
    """Iterate a projection from `places.now` until every pending lane is within the tolerance; returns each lane's
    iterations, and the places with the last iterate as `now`.

    `again`: the kernel of the iterations after the first; hat: what is projected, 0: the iterate itself; the place
    `new` is spare; `violation`: its row in what they give; `committed`, `carried`: how many rows go to `now`, and how
    many it keeps behind them; `exchange`: whether iterates may change places.
    """
    used, now, following, spare = splat(0.0), places.now, places.following, places.new
    for n in range(limit):
        if not any_lane(pending):
            return used, Places(spare, now, following)
        call(kernel if n == 0 else again, now if hat == 0 else hat, p, at.clock, now, following, at.work)
        code = load(following, violation - layout.VIOLATION + layout.ITERATE_CODE)
        left = load(following, violation)
        if exchange and all_lanes(pending):
            copy(following + ROW * committed, now + ROW * committed, carried)
            if now == hat:
                now, following, spare = following, spare, now
            else:
                now, following = following, now
        else:
            commit(pending, now, following, committed)
        used = used + choose(pending, 1.0, 0.0)
        store(status, 0, choose(pending, choose(code == 0.0, load(status, 0), code), load(status, 0)))
        pending = pending & (load(status, 0) == 0.0) & (left > tolerance)
    store(status, 0, choose(pending, splat(codes.NOT_CONVERGED), load(status, 0)))
    return used, Places(spare, now, following)


@apart
def reselect(
    kernels: np.ndarray, sizes: Sizes, state: Address, p: Address, at: Workspace, lanes: Mask, table: Rows,
    target: Address,
) -> Mask:  # fmt: skip
    """Select the constraint rows anew at a state in these lanes; the masks go to the state `target`.
    Returns in which lanes they are others than before."""
    q = sizes.exchangeable
    first = layout.element_rows(sizes) + sizes.first_mask
    masks, asked = selection_table.table_masks(q), selection_table.table_asked(q)
    room = matrix(at.table + ROW * selection_table.table_room(q), q + 2, q)
    call(kernels[layout.SCHUR], state, p, at.clock, 0, at.table, at.work)
    for i in range(q):
        store(at.table, masks + i, load(target, first + i))
    store(at.table, asked, choose(lanes, splat(1.0), splat(0.0)))
    for lane in range(W):
        if table[asked, lane] != 0.0:
            select_rows(table, lane, q, room)
    same = splat(1.0)
    for i in range(q):
        mask = choose(lanes, load(at.table, masks + i), load(target, first + i))
        same = choose(mask == load(target, first + i), same, 0.0)
        store(target, first + i, mask)
    store(target, first + q, choose(lanes, splat(0.0), load(target, first + q)))
    return same == 0.0


@inlined
def project_positions(
    kernels: np.ndarray, sizes: Sizes, p: Address, places: Places, movable: bool, at: Workspace, status: Address,
    pending: Mask, table: Rows, limit: int, tolerance: float, closing: bool,
) -> tuple[Lanes, Places]:  # fmt: skip
    """Project the positions of `new` in the pending lanes; returns each lane's iterations, and the places.
    closing: over gaps.

    Where it does not converge, a constraint that said the same as others may have begun to say something of its own:
    the rows are selected anew where the iteration has come to, and it starts again; with fixed rows that is for another
    program to do.
    """
    rows = layout.element_rows(sizes)
    iterated = rows + sizes.correction
    first, chord = kernels[layout.POSITION], kernels[layout.CHORD]
    if closing and kernels[layout.CLOSURE] != 0:
        first, chord = kernels[layout.CLOSURE], 0
    again = chord if chord != 0 else first  # reads what the first one left behind its iterate: that stays in its place
    used, new = splat(0.0), places.new
    for attempt in range(2):
        # an iterate begins as a copy of `new`, or is `new`, whose rows behind the bodies have been read
        if not (movable and chord == 0 and sizes.augmented == 0 and all_lanes(pending)):
            copy(places.now, new, rows)
        else:
            places = Places(places.now, new, places.following)
        for row in range(rows, iterated):
            store(places.now, row, splat(0.0))
        violation = iterated + layout.VIOLATION
        count, places = iterate(
            first, again, p, new, places, at, status, pending, limit, tolerance, violation, iterated, 0, chord == 0
        )  # fmt: skip
        used = used + count
        done = pending & (load(status, 0) == 0.0)
        if movable and all_lanes(done):
            copy(places.now + ROW * rows, new + ROW * rows, sizes.augmented)
            return used, Places(places.now, new, places.following)
        commit(done, new, places.now, rows)
        pending = pending & (load(status, 0) == codes.NOT_CONVERGED)
        if attempt == 1 or sizes.exchangeable == 0 or not any_lane(pending):
            break
        copy(places.now + ROW * rows, new + ROW * rows, sizes.augmented)
        others = reselect(kernels, sizes, places.now, p, at, pending, table, new)
        if sizes.fixed != 0:
            store(status, 0, choose(others, codes.RESELECT, load(status, 0)))
            break
        store(status, 0, choose(pending, splat(0.0), load(status, 0)))
    return used, places


@inlined
def project_velocities(
    kernels: np.ndarray, sizes: Sizes, p: Address, places: Places, movable: bool, at: Workspace, status: Address,
    pending: Mask, limit: int, tolerance: float,
) -> tuple[Lanes, Places]:  # fmt: skip
    """Project the velocities of `new` in the pending lanes; returns each lane's iterations, and the places."""
    rows, kernel = layout.element_rows(sizes), kernels[layout.VELOCITY]
    violation = rows + layout.VIOLATION
    used, after = iterate(
        kernel, kernel, p, 0, Places(places.now, places.new, places.following), at, status, pending, limit, tolerance,
        violation, rows, sizes.augmented, movable,
    )  # fmt: skip
    return used, Places(after.now, after.new, after.following)


@inlined
def project(
    kernels: np.ndarray, sizes: Sizes, p: Address, places: Places, movable: bool, at: Workspace, status: Address,
    going: Mask, iterations: Address, table: Rows, limit: int, tolerance: float,
) -> Places:  # fmt: skip
    """Project positions and velocities of `new` in the lanes `going`; the most so far go to the rows `iterations`.
    Returns the places; movable: whether `new` may get another one, where its code and margin do not follow."""
    if kernels[layout.POSITION] != 0:
        pending = going & (load(status, 0) == 0.0)
        used, places = project_positions(
            kernels, sizes, p, places, movable, at, status, pending, table, limit, tolerance, False
        )  # fmt: skip
        store(iterations, 0, choose(used > load(iterations, 0), used, load(iterations, 0)))
    if kernels[layout.VELOCITY] != 0:
        pending = going & (load(status, 0) == 0.0)
        used, places = project_velocities(kernels, sizes, p, places, movable, at, status, pending, limit, tolerance)
        store(iterations, 1, choose(used > load(iterations, 1), used, load(iterations, 1)))
    return places


@apart
def stage(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, s: int, x: Address, p: Address, at: Workspace, t: Lanes,
    h: Lanes,
) -> Lanes:  # fmt: skip
    """The slopes of stage s of a step; returns the largest squared rotation of its argument."""
    size, combine = sizes.coordinates, kernels[layout.COMBINE + s]
    store(at.clock, layout.TIME, t + nodes[s] * h)
    store(at.clock, layout.NODE, splat(nodes[s]))
    rotation = splat(0.0)
    for i in range(sizes.elements if combine != 0 else 0):
        slopes = at.slopes + ROW * layout.slope_row(sizes, i, 0)
        call(combine, 0, p, at.clock, slopes, at.u + ROW * size * i, at.work)
        rotation = maximum(load(at.u, size * (i + 1)), rotation)
    slopes = at.slopes + ROW * layout.slope_row(sizes, 0, s)
    call(kernels[layout.STAGE if combine != 0 else layout.FIRST], x, p, at.clock, at.u, slopes, at.work)
    return rotation


@inlined
def end_slope(kernels: np.ndarray, sizes: Sizes, at: Workspace, until: Lanes) -> None:
    """The slope at the end of an open step, about its start."""
    if kernels[layout.CLOSE] == 0:
        store(at.clock, layout.TIME, until)
        last = at.slopes + ROW * layout.slope_row(sizes, 0, sizes.slopes - 1)
        call(kernels[layout.FIRST], at.new, at.parameters, at.clock, 0, last, at.work)
    call(kernels[layout.END], at.state, at.parameters, at.clock, at.slopes, at.slopes, at.work)


@apart
def extend(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, at: Workspace, t: Lanes, length: Lanes, until: Lanes
) -> None:
    """The slope at the end of an open step, and those of the stages that only the continuous extension needs; a
    series says it all."""
    if kernels[layout.EXPAND] != 0:
        return
    end_slope(kernels, sizes, at, until)
    for s in range(sizes.stages + 1, sizes.slopes - 1):
        stage(kernels, sizes, nodes, s, at.state, at.parameters, at, t, length)
    store(at.clock, layout.TIME, t)


@apart
def extend_at_end(sizes: Sizes, nodes: np.ndarray, at: Workspace, lanes: Mask) -> None:
    """Behind `end_slope`: what will do for the continuous extension next to the end of the step in these lanes. What
    only the extension needs has the weight (1 - fraction)^2 there: a straight line between the ends is enough."""
    last = layout.report_row(sizes, sizes.slopes - 1)
    for s in range(sizes.stages + 1, sizes.slopes - 1):
        for i in range(sizes.elements):
            first, end = layout.slope_row(sizes, i, 0), layout.slope_row(sizes, i, sizes.stages)
            for n in range(sizes.coordinates):
                _between(at.slopes, lanes, nodes[s], first + n, end + n, layout.slope_row(sizes, i, s) + n)
        for n in range(layout.REPORTS):
            _between(
                at.slopes, lanes, nodes[s], layout.report_row(sizes, 0) + n, last + n, layout.report_row(sizes, s) + n
            )


@inlined
def _between(slopes: Address, lanes: Mask, node: float, first: int, end: int, row: int) -> None:
    """On the straight line from one row to another."""
    a = load(slopes, first)
    store(slopes, row, choose(lanes, a + node * (load(slopes, end) - a), load(slopes, row)))


@apart
def staged_step(
    kernels: np.ndarray, sizes: Sizes, nodes: np.ndarray, since: int, x: Address, p: Address, new: Address,
    at: Workspace,
) -> None:  # fmt: skip
    """One step stage by stage, from stage `since` on, for mechanisms whose step is too long for one kernel; code and
    margin go behind `new`.

    The kernels of one body put what they report behind the body's rows: it is read before the next body's call, whose
    rows begin there.
    """
    t, h = load(at.clock, layout.TIME), load(at.clock, layout.LENGTH)
    rotation, square, first, every = splat(0.0), splat(0.0), splat(1.0), splat(1.0)
    for s in range(sizes.stages):
        if s >= since:
            rotation = maximum(stage(kernels, sizes, nodes, s, x, p, at, t, h), rotation)
        sound = load(at.slopes, layout.report_row(sizes, s) + layout.SOUND)
        every = choose(sound < every, sound, every)
        first = every if s == 0 else first
    for i in range(sizes.elements):
        element, slopes = ROW * sizes.element * i, at.slopes + ROW * layout.slope_row(sizes, i, 0)
        call(kernels[layout.ADVANCE], x + element, p, at.clock, slopes, new + element, at.work)
        rotation = maximum(load(new, sizes.element * (i + 1) + layout.TURNED), rotation)
        square = square + load(new, sizes.element * (i + 1) + layout.MOVED)
    rows, behind = ROW * layout.element_rows(sizes), layout.state_rows(sizes)
    copy(new + rows, x + rows, sizes.augmented)
    store(at.clock, layout.TIME, t + h)
    if sizes.augmented > 0:
        call(kernels[layout.FINISH], new, p, at.clock, at.slopes, at.u, at.work)
        copy(new + rows, at.u, sizes.augmented)
    code = codes.verdict(rotation, square, first, every)
    store(new, behind + layout.CODE, choose(every < 0.0, splat(codes.PARADOX), code))
    store(new, behind + layout.MARGIN, load(at.slopes, layout.report_row(sizes, 0) + layout.STAGE_MARGIN))
