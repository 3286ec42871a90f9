"""States at events, which drivers leave behind as they read them off the steps: projected, and observed."""

import numpy as np

from lienumba.compiler.lanes import any_lane, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import Floats1, Floats3, Floats4, Integers1
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout, selection_table
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.workspace import NO_PLAN, Context, Places, addresses
from lienumba.integrators.layout import ITERATIONS, STATUS
from lienumba.integrators.sizes import Sizes


def observe_events(
    kernels: Integers1, nodes: Floats1, sizes: Sizes, states: Floats4, times: Floats3, parameters: Floats3,
    records: Floats4, limit: int, tolerance: float, buffer: Floats1,
) -> None:  # fmt: skip
    """Records of the states (blocks, events, state rows, W) at times (blocks, events, W), NaN where nothing happened.

    records (blocks, events, record rows, W): NaN there, and where a state cannot be projected; the rest as in
    `fixed_step.drive`.
    """
    at, first = addresses(buffer, sizes), layout.workspace(sizes)
    rows = matrix(buffer.ctypes.data, first.work, W)
    table = rows[first.table : first.table + selection_table.table_rows(sizes.exchangeable)]
    context = Context(kernels, nodes, sizes, NO_PLAN, limit, tolerance, at, first, rows, table)
    status, iterations = at.lanes + ROW * STATUS, at.lanes + ROW * ITERATIONS
    for block in range(states.shape[0]):
        p = parameters[block].ctypes.data
        for event in range(states.shape[1]):
            to, time = records[block, event].ctypes.data, load(times[block, event].ctypes.data, 0)
            known = time == time
            if not any_lane(known):
                for row in range(layout.record_rows(sizes)):
                    store(to, row, splat(np.nan))
                continue
            stages.copy(at.new, states[block, event].ctypes.data, layout.state_rows(sizes))
            store(at.clock, layout.TIME, choose(known, time, splat(0.0)))
            store(at.clock, layout.LENGTH, splat(0.0))
            store(status, 0, splat(0.0))
            for row in range(layout.PROJECTIONS):
                store(iterations, row, splat(0.0))
            places = Places(at.new, at.now, at.following)
            stages.project(context, p, places, False, status, known, iterations)
            known = known & (load(status, 0) == 0.0)
            stages.record(context, to, at.new, p, known, iterations)
