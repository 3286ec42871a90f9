"""The driver of steps of one length: advances blocks of W runs, all lanes at the same time.

Compiled once for all mechanisms. A lane that fails is frozen while the others go on.
"""

from typing import Any

import numpy as np
from numba import njit
from numba.core import types

from lienumba.compiler import cache
from lienumba.compiler.lanes import any_lane, borrowed, call, choose, load, splat, store
from lienumba.compiler.rows import ROW, W
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.stages import commit
from lienumba.integrators.drivers.workspace import OPTIONS, SIZES, addresses, layout, table_rows
from lienumba.integrators.tracing.row_selection import WEAKENED

COUNTS, SINCE, UNTIL = 0, 2, 3  # rows of the lanes: iterations of both projections, the ends of the part of a step


@njit(**OPTIONS)
def _next_landing(times: Any, landings: Any, passed: Any, end: float) -> bool:
    """The end of the next part of a step in each lane: at the end of the step, or at a time on which it has to land.
    times: since when, until when. Returns whether any lane lands."""
    landed = False
    for lane in range(W):
        while landings[passed[lane], lane] <= times[0, lane]:
            passed[lane] += 1
        landed = landed or landings[passed[lane], lane] <= end
        times[1, lane] = min(landings[passed[lane], lane], end)
    return landed


@njit(**OPTIONS)
def _set_clock(clock: int, t: Any, to: Any, begin: float, end: float, h: float) -> None:
    """The clock of a part of a step. A step that is not cut is h long, whatever its ends round to."""
    length = choose((to == end) & (t == begin), splat(h), to - t)
    store(clock, codes.TIME, t)
    store(clock, codes.LENGTH, length)
    store(clock, codes.MIDDLE, t + 0.5 * length)


@cache.numba_cached(
    types.void(
        types.int64[::1], types.float64[::1], SIZES,
        types.int64, types.float64, types.int64[::1], types.int64, types.float64,
        types.float64[:, :, ::1], types.float64[:, :, ::1], types.float64[:, :, ::1], types.float64[:, :, :, ::1],
        types.float64[:, ::1], types.float64[:, ::1], types.float64[:, ::1], types.float64[::1], types.int64[::1],
        types.int64[::1],
    ),
    **OPTIONS,
)  # fmt: skip
def drive(
    kernels: Any, nodes: Any, sizes: Any, steps: int, h: float, output_steps: Any, limit: int, tolerance: float,
    states: Any, parameters: Any, landings: Any, records: Any, statuses: Any, end_steps: Any, ends: Any,
    buffer: Any, progress: Any, stop: Any,
) -> None:  # fmt: skip
    """Integrate all blocks.

    states (blocks, 18 k + held, W): initial, left at the last good state;
    parameters (blocks, P, W), invariants prepared; landings (blocks, L, W): the times on which a step must land, those
    of a lane ascending, and an infinite one last;
    records (blocks, outputs, 18 k + held + seen + 2, W): what is stored, at the steps `output_steps`;
    statuses (blocks, W): in, 0 for lanes that may run, out, the code; end_steps (blocks, W): the last good step; ends
    (blocks, W): the time of the last good state (s), which is later where a step failed after a landing;
    buffer: as many rows as `scratch.layout` says, and the kernels' work; progress[0]: outputs done so far;
    stop[0]: set from outside to end early. Every array is contiguous.
    """
    rows, held = ELEMENT * sizes.elements, sizes.held
    masks = rows + sizes.first_mask
    at, first = addresses(buffer, sizes), layout(sizes)
    new, clock, lanes = at.new, at.clock, at.lanes
    times = buffer[W * (first.lanes + SINCE) : W * (first.lanes + UNTIL + 1)].reshape((2, W))
    table = borrowed(
        buffer[W * first.table : W * (first.table + table_rows(sizes.q))].reshape((table_rows(sizes.q), W))
    )
    times, kernels, nodes = borrowed(times), borrowed(kernels), borrowed(nodes)
    passed, cuts = np.zeros(W, np.int64), landings.shape[1] > 1  # passed: landings of each lane
    for block in range(states.shape[0]):
        x, p = states[block].ctypes.data, parameters[block].ctypes.data
        ours = landings[block]
        status, end_step = statuses[block].ctypes.data, end_steps[block].ctypes.data
        store(lanes, COUNTS, splat(0.0))
        store(lanes, COUNTS + 1, splat(0.0))
        store(end_step, 0, splat(0.0))
        store(clock, codes.TIME, splat(0.0))
        store(lanes, SINCE, splat(0.0))
        passed[:] = 0
        if kernels[stages.SAMPLE] != 0:
            call(kernels[stages.SAMPLE], x, p, clock, 0, new, at.work)
            commit(load(status, 0) == 0.0, x, new, rows)
        done = 0
        for n in range(steps + 1):
            if stop[0] != 0:
                return
            alive = load(status, 0) == 0.0
            going = alive & (load(lanes, SINCE) < n * h)
            while any_lane(going):
                landed = cuts and _next_landing(times, ours, passed, n * h)
                if not cuts:
                    store(lanes, UNTIL, splat(n * h))
                _set_clock(clock, load(lanes, SINCE), load(lanes, UNTIL), (n - 1) * h, n * h, h)
                if kernels[stages.STEP] != 0:
                    call(kernels[stages.STEP], x, p, clock, 0, new, at.work)
                else:
                    stages.staged_step(kernels, sizes, nodes, 0, x, p, at)
                store(clock, codes.TIME, load(lanes, UNTIL))
                code = load(new, rows + held)
                margin = load(new, rows + held + 1)
                store(status, 0, choose(going, code, load(status, 0)))
                counts = lanes + ROW * COUNTS
                stages.project_both(kernels, sizes, p, new, at, status, going, counts, table, limit, tolerance)
                good = going & (load(status, 0) == 0.0)
                commit(good, x, new, rows + held)
                if sizes.q > 0:
                    weak = good & (margin < WEAKENED * load(x, masks + sizes.q))
                    if any_lane(weak):
                        others = stages.exchange(kernels, sizes, x, p, at, weak, table, x)
                        if sizes.fixed != 0:
                            store(status, 0, choose(others, codes.EXCHANGED, load(status, 0)))
                if landed and kernels[stages.SAMPLE] != 0:
                    call(kernels[stages.SAMPLE], x, p, clock, 0, new, at.work)
                    commit(good, x, new, rows)
                store(lanes, SINCE, choose(good, load(lanes, UNTIL), load(lanes, SINCE)))
                going = good & (load(lanes, SINCE) < n * h)
            store(clock, codes.TIME, splat(n * h))
            alive = load(status, 0) == 0.0
            store(end_step, 0, choose(alive, splat(float(n)), load(end_step, 0)))
            if done < output_steps.size and output_steps[done] == n:
                to = records[block, done].ctypes.data
                stages.record(
                    to, kernels[stages.OBSERVE], x, p, at, rows + held, sizes.seen, alive, lanes + ROW * COUNTS
                )
                store(lanes, COUNTS, splat(0.0))
                store(lanes, COUNTS + 1, splat(0.0))
                done += 1
                progress[0] += 1
                if not any_lane(alive):
                    break
        store(ends[block].ctypes.data, 0, load(lanes, SINCE))
        for rest in range(done, output_steps.size):
            for row in range(rows + held + sizes.seen + 2):
                store(records[block, rest].ctypes.data, row, splat(np.nan))
        progress[0] += output_steps.size - done
