"""Positions at a change onto the constraints: states that are read off within a step, and joints that close."""

from lienumba.compiler.lanes import Mask, call, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.events.acting import engages
from lienumba.integrators.drivers.events.tolerances import CLOSED_GAP_RTOL
from lienumba.integrators.drivers.switching import reactions
from lienumba.integrators.drivers.workspace import Context, Places, Plan, Rows
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
def project(context: Context) -> None:
    """States read off within a step, onto the constraints."""
    kernels, sizes, at = context.kernels, context.sizes, context.at
    lanes, state = at.lanes, layout.state_rows(sizes)
    if kernels[layout.POSITION] == 0 and kernels[layout.VELOCITY] == 0:
        return
    going = (load(lanes, CHANGED) != 0.0) & (load(lanes, STATUS) == 0.0) & (load(lanes, FRESH) == 0.0)
    stages.copy(at.new, at.state, state)
    places, status = Places(at.new, at.now, at.following), lanes + ROW * STATUS
    stages.project(context, at.parameters, places, False, status, going, lanes + ROW * ITERATIONS)
    stages.commit(going & (load(status, 0) == 0.0), at.state, at.new, state)


@apart
def close(context: Context, closing: Mask) -> None:
    """Positions of what is to close, onto the constraints; velocities, with which bodies move on as before, onto those
    that always hold, as the impulses of the others expect it."""
    kernels, sizes, at = context.kernels, context.sizes, context.at
    state, status = layout.state_rows(sizes), at.lanes + ROW * STATUS
    if kernels[layout.POSITION] == 0:
        return
    stages.copy(at.new, at.state, state)
    places = Places(at.new, at.now, at.following)
    patient = Context(
        kernels, context.nodes, sizes, context.plan, max(context.limit, CLOSING), context.tolerance, at, context.first,
        context.rows, context.table,
    )  # fmt: skip
    stages.project_positions(patient, at.parameters, places, False, status, closing, True)
    closed = closing & (load(status, 0) == 0.0)
    if kernels[layout.CARRY] != 0:
        call(kernels[layout.CARRY], at.new, at.parameters, at.clock, at.state, at.now, at.work)
        stages.commit(closed, at.new, at.now, layout.element_rows(sizes))
    for row in range(layout.mask_row(sizes), layout.on_row(sizes)):
        store(at.new, row, splat(0.0))
    if kernels[layout.VELOCITY] != 0:
        stages.project_velocities(context, at.parameters, places, False, status, closed)
    stages.commit(closed & (load(status, 0) == 0.0), at.state, at.new, state)


@apart
def has_closed(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, tolerance: float) -> None:
    """Whether what was to close in a lane has closed, rows that say the same as others with it; else nothing has
    happened, and the run ends."""
    open_ = rows[first.lanes + STATUS, lane] != 0.0
    for event in range(sizes.events):
        if engages(sizes, first, rows, plan, lane, event):
            size = reactions.number(rows, first, sizes, lane, plan.targets[plan.acts[event, TARGET]], SIZE)
            open_ = open_ or widest_gap(sizes, first, rows, plan, lane, event) > tolerance + CLOSED_GAP_RTOL * size
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
