"""What drivers do with one block: a step by stages, projections, exchange of constraint rows, a record.

They know rows of lanes, not mechanics; kernels are called by their addresses. A run feels nothing of its neighbours:
every iteration is committed by lane.
"""

from typing import Any

import numpy as np
from numba import njit

from lienumba.compiler import jit
from lienumba.compiler.lanes import any_lane, call, choose, load, splat, store
from lienumba.compiler.rows import ROW, W
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.drivers.workspace import OPTIONS, slope_row
from lienumba.integrators.methods.munthe_kaas import verdict
from lienumba.integrators.tracing.row_selection import choose_rows
from lienumba.numerics.operations import maximum

# `kernels`: addresses in this order, 0 where the method has no such kernel; behind them combine0, combine1, ...
ORDER = (
    "step", "position", "chord", "velocity", "observe", "first", "stage", "advance", "finish", "exchange", "sample",
    "close", "end", "dense", "events",
)  # fmt: skip
(
    STEP, POSITION, CHORD, VELOCITY, OBSERVE, FIRST, STAGE, ADVANCE, FINISH, EXCHANGE, SAMPLE,
    CLOSE, END, DENSE, EVENTS,
) = range(len(ORDER))  # fmt: skip

jit.register()  # `verdict` is a kernel


@njit(**OPTIONS)
def commit(mask: Any, target: int, source: int, rows: int) -> None:
    """target = source in the lanes of the mask."""
    for row in range(rows):
        store(target, row, choose(mask, load(source, row), load(target, row)))


@njit(**OPTIONS)
def copy(target: int, source: int, rows: int) -> None:
    for row in range(rows):
        store(target, row, load(source, row))


@njit(**OPTIONS)
def record(to: int, observe: int, state: int, p: int, at: Any, rows: int, seen: int, alive: Any, counts: int) -> None:
    """Store state, observed rows and iteration counts; NaN in the lanes that are not alive."""
    call(observe, state, p, at.clock, 0, to + ROW * rows, at.work)
    copy(to, state, rows)
    copy(to + ROW * (rows + seen), counts, 2)
    for row in range(rows + seen + 2):
        store(to, row, choose(alive, load(to, row), splat(np.nan)))


@njit(**OPTIONS)
def iterate(
    kernel: int, again: int, p: int, hat: int, now: int, at: Any, status: int, pending: Any, limit: int,
    tolerance: float, violation: int, committed: int,
) -> Any:  # fmt: skip
    """Iterate a projection until every pending lane is within the tolerance; returns each lane's iterations.

    `again`: the kernel of the iterations after the first; `violation`: its row in what they give, followed by the code;
    `committed`: how many rows go to `now`.
    """
    used = splat(0.0)
    for n in range(limit):
        if not any_lane(pending):
            return used
        call(kernel if n == 0 else again, hat, p, at.clock, now, at.following, at.work)
        commit(pending, now, at.following, committed)
        used = used + choose(pending, 1.0, 0.0)
        code = load(at.following, violation + 1)
        store(status, 0, choose(pending, choose(code == 0.0, load(status, 0), code), load(status, 0)))
        pending = pending & (load(status, 0) == 0.0) & (load(at.following, violation) > tolerance)
    store(status, 0, choose(pending, splat(codes.NOT_CONVERGED), load(status, 0)))
    return used


@njit(**OPTIONS)
def exchange(kernels: Any, sizes: Any, state: int, p: int, at: Any, lanes: Any, table: Any, target: int) -> Any:
    """Choose the constraint rows anew at a state in these lanes; the masks go to the state `target`.
    Returns in which lanes they are others than before."""
    q = sizes.q
    first = ELEMENT * sizes.elements + sizes.first_mask
    masks, asked = q * (q + 1) // 2 + q, q * (q + 1) // 2 + 2 * q
    call(kernels[EXCHANGE], state, p, at.clock, 0, at.table, at.work)
    for i in range(q):
        store(at.table, masks + i, load(target, first + i))
    store(at.table, asked, choose(lanes, splat(1.0), splat(0.0)))
    for lane in range(W):
        if table[asked, lane] != 0.0:
            choose_rows(table, lane, q)
    same = splat(1.0)
    for i in range(q):
        mask = choose(lanes, load(at.table, masks + i), load(target, first + i))
        same = choose(mask == load(target, first + i), same, 0.0)
        store(target, first + i, mask)
    store(target, first + q, choose(lanes, splat(0.0), load(target, first + q)))
    return same == 0.0


@njit(**OPTIONS)
def project(
    kernels: Any, sizes: Any, p: int, new: int, at: Any, status: int, pending: Any, table: Any, limit: int,
    tolerance: float,
) -> Any:  # fmt: skip
    """Project the positions of `new` in the pending lanes; returns each lane's iterations.

    Where it does not converge, a constraint that said the same as others may have begun to say something of its own:
    the rows are chosen anew where the iteration has come to, and it starts again; with fixed rows that is for another
    program to do.
    """
    rows = ELEMENT * sizes.elements
    iterated = rows + sizes.correction
    again = kernels[CHORD] if kernels[CHORD] != 0 else kernels[POSITION]
    used = splat(0.0)
    for attempt in range(2):
        copy(at.now, new, rows)
        for row in range(rows, iterated):
            store(at.now, row, splat(0.0))
        used = used + iterate(
            kernels[POSITION], again, p, new, at.now, at, status, pending, limit, tolerance, iterated, iterated
        )
        commit(pending & (load(status, 0) == 0.0), new, at.now, rows)
        pending = pending & (load(status, 0) == codes.NOT_CONVERGED)
        if attempt == 1 or sizes.q == 0 or not any_lane(pending):
            break
        copy(at.now + ROW * rows, new + ROW * rows, sizes.held)
        others = exchange(kernels, sizes, at.now, p, at, pending, table, new)
        if sizes.fixed != 0:
            store(status, 0, choose(others, codes.EXCHANGED, load(status, 0)))
            break
        store(status, 0, choose(pending, splat(0.0), load(status, 0)))
    return used


@njit(**OPTIONS)
def project_velocities(
    kernels: Any, sizes: Any, p: int, new: int, at: Any, status: int, pending: Any, limit: int, tolerance: float
) -> Any:
    """Project the velocities of `new` in the pending lanes; returns each lane's iterations."""
    rows = ELEMENT * sizes.elements
    return iterate(kernels[VELOCITY], kernels[VELOCITY], p, new, new, at, status, pending, limit, tolerance, rows, rows)


@njit(**OPTIONS)
def project_both(
    kernels: Any, sizes: Any, p: int, new: int, at: Any, status: int, going: Any, counts: int, table: Any, limit: int,
    tolerance: float,
) -> None:  # fmt: skip
    """Project positions and velocities of `new` in the lanes `going`; the most iterations so far go to two `counts`."""
    if kernels[POSITION] != 0:
        pending = going & (load(status, 0) == 0.0)
        used = project(kernels, sizes, p, new, at, status, pending, table, limit, tolerance)
        store(counts, 0, choose(used > load(counts, 0), used, load(counts, 0)))
    if kernels[VELOCITY] != 0:
        pending = going & (load(status, 0) == 0.0)
        used = project_velocities(kernels, sizes, p, new, at, status, pending, limit, tolerance)
        store(counts, 1, choose(used > load(counts, 1), used, load(counts, 1)))


@njit(**OPTIONS)
def stage(kernels: Any, sizes: Any, nodes: Any, s: int, x: int, p: int, at: Any, t: Any, h: Any) -> Any:
    """The slopes of stage s of a step; returns the largest squared rotation of its argument."""
    size, combine = sizes.slope, kernels[len(ORDER) + s]
    store(at.clock, codes.TIME, t + nodes[s] * h)
    store(at.clock, codes.NODE, splat(nodes[s]))
    rotation = splat(0.0)
    for i in range(sizes.elements if combine != 0 else 0):
        call(combine, 0, p, at.clock, at.slopes + ROW * slope_row(sizes, i, 0), at.u + ROW * size * i, at.work)
        rotation = maximum(load(at.u, size * (i + 1)), rotation)
    call(kernels[STAGE if combine != 0 else FIRST], x, p, at.clock, at.u, at.slopes + ROW * size * s, at.work)
    return rotation


@njit(**OPTIONS)
def extend(kernels: Any, sizes: Any, nodes: Any, at: Any, t: Any, length: Any, until: Any) -> None:
    """The slope at the end of an open step, and those of the stages that only the continuous extension needs."""
    if kernels[CLOSE] == 0:
        store(at.clock, codes.TIME, until)
        last = at.slopes + ROW * slope_row(sizes, 0, sizes.slots - 1)
        call(kernels[FIRST], at.new, at.parameters, at.clock, 0, last, at.work)
    call(kernels[END], at.state, at.parameters, at.clock, at.slopes, at.slopes, at.work)
    for s in range(sizes.stages + 1, sizes.slots - 1):
        stage(kernels, sizes, nodes, s, at.state, at.parameters, at, t, length)
    store(at.clock, codes.TIME, t)


@njit(**OPTIONS)
def staged_step(kernels: Any, sizes: Any, nodes: Any, since: int, x: int, p: int, at: Any) -> None:
    """One step stage by stage, from stage `since` on, for mechanisms whose step is too long for one kernel; code and
    margin go behind `new`.

    The kernels of one body put what they report behind the body's rows: it is read before the next body's call, whose
    rows begin there.
    """
    k, held, size = sizes.elements, sizes.held, sizes.slope
    t, h = load(at.clock, codes.TIME), load(at.clock, codes.LENGTH)
    said = at.slopes + ROW * slope_row(sizes, k, 0)
    rotation, square, first, every = splat(0.0), splat(0.0), splat(1.0), splat(1.0)
    for s in range(sizes.stages):
        if s >= since:
            rotation = maximum(stage(kernels, sizes, nodes, s, x, p, at, t, h), rotation)
        every = every * load(said, size * s)
        first = every if s == 0 else first
    for i in range(k):
        call(kernels[ADVANCE], x + ROW * ELEMENT * i, p, at.clock, at.slopes + ROW * slope_row(sizes, i, 0),
             at.new + ROW * ELEMENT * i, at.work)  # fmt: skip
        rotation = maximum(load(at.new, ELEMENT * (i + 1)), rotation)
        square = square + load(at.new, ELEMENT * (i + 1) + 1)
    rows = ELEMENT * k
    copy(at.new + ROW * rows, x + ROW * rows, held)
    store(at.clock, codes.TIME, t + h)
    if held > 0:
        call(kernels[FINISH], at.new, p, at.clock, at.slopes, at.u, at.work)
        copy(at.new + ROW * rows, at.u, held)
    store(at.new, rows + held, verdict(rotation, square, first, every))
    store(at.new, rows + held + 1, load(said, 2))
