"""Routines for a loop of the user's own: one step of one block, and the calls of kernels around it.

`step` does what `fixed_step` does in one step that no discontinuity cuts, to the bit.
"""

from typing import NamedTuple

from lienumba.compiler.lanes import Address, all_lanes, any_lane, call, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import Floats1, Integers1, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout, selection_table
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.row_selection import WEAKENED
from lienumba.integrators.drivers.stages import commit, copy
from lienumba.integrators.drivers.workspace import NO_PLAN, Context, Places
from lienumba.integrators.layout import ITERATIONS, STATUS, Workspace
from lienumba.integrators.sizes import Sizes


class Step(NamedTuple):
    """The addresses of the state and the parameters of a block; a step of length h (s) from t to `until`."""

    state: int
    parameters: int
    t: float
    h: float
    until: float


@inlined
def step(
    one: Step, kernels: Integers1, nodes: Floats1, sizes: Sizes, at: Workspace, limit: int, tolerance: float
) -> None:
    """Advance the state by one step with its projections. The row `STATUS` gets the code of each lane; a lane whose
    step fails, or leads to where other rows of C are needed, keeps its state. limit, tolerance: of the projections."""
    x, p, clock, status = one.state, one.parameters, at.clock, at.lanes + ROW * STATUS
    rows, q = layout.state_rows(sizes), sizes.exchangeable
    places, table = Places(at.new, at.now, at.following), matrix(at.table, selection_table.table_rows(q), W)
    context = Context(kernels, nodes, sizes, NO_PLAN, limit, tolerance, at, layout.workspace(sizes), table, table)
    store(status, 0, splat(0.0))
    every = load(status, 0) == 0.0
    store(clock, layout.TIME, splat(one.t))
    store(clock, layout.LENGTH, splat(one.h))
    store(clock, layout.MIDDLE, splat(one.t + 0.5 * one.h))
    if kernels[layout.STEP] != 0:
        call(kernels[layout.STEP], x, p, clock, 0, places.new, at.work)
    else:
        stages.staged_step(context, 0, x, p, places.new)
    store(clock, layout.TIME, splat(one.until))
    store(status, 0, load(places.new, rows + layout.CODE))
    margin = load(places.new, rows + layout.MARGIN)
    places = stages.project(context, p, places, True, status, every, at.lanes + ROW * ITERATIONS)
    if q > 0:
        best = load(x, layout.element_rows(sizes) + sizes.first_mask + q)
        weak = (load(status, 0) == 0.0) & (margin < WEAKENED * best)
        if any_lane(weak):
            others = stages.reselect(context, places.new, p, weak, places.new)
            store(status, 0, choose(others, codes.RESELECT, load(status, 0)))
    good = load(status, 0) == 0.0
    if all_lanes(good):
        copy(x, places.new, rows)
    else:
        commit(good, x, places.new, rows)


def evaluate(
    state: Address, parameters: Address, out: Address, kernel: int, clock: Address, work: Address, t: float
) -> None:
    """Call a kernel at a state and time (s)."""
    store(clock, layout.TIME, splat(t))
    store(clock, layout.LENGTH, splat(0.0))
    store(clock, layout.MIDDLE, splat(t))
    call(kernel, state, parameters, clock, 0, out, work)


def prepare(parameters: Address, kernels: Integers1, work: Address) -> None:
    """Fill the hoisted rows of the parameters of a block."""
    for n in range(kernels.size):
        call(kernels[n], 0, parameters, 0, 0, 0, work)
