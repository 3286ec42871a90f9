"""Positions at a change onto the constraints: states that are read off within a step, and joints that close."""

import numpy as np

from lienumba.compiler.lanes import Mask, call, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.events.acting import engages
from lienumba.integrators.drivers.events.search import TOUCH
from lienumba.integrators.drivers.switching import reactions
from lienumba.integrators.drivers.workspace import Places, Plan, Rows
from lienumba.integrators.layout import (
    CHANGED,
    FRESH,
    ITERATIONS,
    OFF,
    SIZE,
    STATUS,
    SWITCH_FIRST,
    SWITCH_ROWS,
    TARGET,
    Workspace,
)
from lienumba.integrators.sizes import Sizes

CLOSING = 200  # iterations to close a joint over a gap, of which steps have none


@apart
def project(kernels: np.ndarray, sizes: Sizes, at: Workspace, table: Rows, limit: int, tolerance: float) -> None:
    """States read off within a step, onto the constraints."""
    lanes, state = at.lanes, layout.state_rows(sizes)
    if kernels[layout.POSITION] == 0 and kernels[layout.VELOCITY] == 0:
        return
    going = (load(lanes, CHANGED) != 0.0) & (load(lanes, STATUS) == 0.0) & (load(lanes, FRESH) == 0.0)
    stages.copy(at.new, at.state, state)
    places, status = Places(at.new, at.now, at.following), lanes + ROW * STATUS
    stages.project(
        kernels, sizes, at.parameters, places, False, at, status, going, lanes + ROW * ITERATIONS, table, limit,
        tolerance,
    )  # fmt: skip
    stages.commit(going & (load(status, 0) == 0.0), at.state, at.new, state)


@apart
def close(
    kernels: np.ndarray, sizes: Sizes, at: Workspace, closing: Mask, table: Rows, limit: int, tolerance: float
) -> None:
    """Positions of what is to close, onto the constraints; velocities, with which bodies move on as before, onto those
    that always hold, as the impulses of the others expect it."""
    state, status = layout.state_rows(sizes), at.lanes + ROW * STATUS
    if kernels[layout.POSITION] == 0:
        return
    stages.copy(at.new, at.state, state)
    places = Places(at.new, at.now, at.following)
    most = max(limit, CLOSING)
    stages.project_positions(
        kernels, sizes, at.parameters, places, False, at, status, closing, table, most, tolerance, True
    )  # fmt: skip
    closed = closing & (load(status, 0) == 0.0)
    if kernels[layout.CARRY] != 0:
        call(kernels[layout.CARRY], at.new, at.parameters, at.clock, at.state, at.now, at.work)
        stages.commit(closed, at.new, at.now, layout.element_rows(sizes))
    for row in range(layout.mask_row(sizes), layout.on_row(sizes)):
        store(at.new, row, splat(0.0))
    if kernels[layout.VELOCITY] != 0:
        stages.project_velocities(kernels, sizes, at.parameters, places, False, at, status, closed, limit, tolerance)
    stages.commit(closed & (load(status, 0) == 0.0), at.state, at.new, state)


@apart
def has_closed(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, tolerance: float) -> None:
    """Whether what was to close in a lane has closed, rows that say the same as others with it; else nothing has
    happened, and the run ends."""
    open_ = rows[first.lanes + STATUS, lane] != 0.0
    for event in range(sizes.events):
        if engages(sizes, first, rows, plan, lane, event):
            size = reactions.number(rows, first, sizes, lane, plan.targets[plan.acts[event, TARGET]], SIZE)
            open_ = open_ or widest_gap(sizes, first, rows, plan, lane, event) > tolerance + TOUCH * size
    if open_:
        for event in range(sizes.events):
            if engages(sizes, first, rows, plan, lane, event):
                target = plan.targets[plan.acts[event, TARGET]]
                rows[first.state + layout.on_row(sizes) + target, lane] = float(OFF)
        rows[first.lanes + STATUS, lane] = codes.NOT_CLOSED
        rows[first.lanes + CHANGED, lane] = 0.0


@inlined
def widest_gap(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, event: int) -> float:
    """How far (m or rad) the parts of a joint are from where an event wants them."""
    widest, target = 0.0, plan.targets[plan.acts[event, TARGET]]
    row = first.change + layout.border_gaps(sizes) + plan.switches[target, SWITCH_FIRST]
    for i in range(row, row + plan.switches[target, SWITCH_ROWS]):
        widest = max(widest, max(rows[i, lane], -rows[i, lane]))
    return widest
