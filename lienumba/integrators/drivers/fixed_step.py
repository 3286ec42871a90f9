"""The driver of steps of one length: advances blocks of W runs, all lanes at the same time.

Compiled once for all mechanisms. A lane that fails is frozen while the others go on.
"""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, all_lanes, any_lane, call, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import Floats1, Floats2, Floats3, Floats4, Integers1, apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout, selection_table
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.measuring.steps import begin_measures, forget_past, measure, placed, take_gains
from lienumba.integrators.drivers.row_selection import WEAKENED
from lienumba.integrators.drivers.stages import commit, copy
from lienumba.integrators.drivers.workspace import Context, Places, Plan, Rows, addresses
from lienumba.integrators.layout import ACCEPTED, FRESH, ITERATIONS, SEEN, STATUS, UNTIL, T
from lienumba.integrators.sizes import Sizes


@apart
def _next_part(t: np.ndarray, until: np.ndarray, jumps: Rows, passed: np.ndarray, end: float) -> bool:
    """The end of the next part of a step in each lane, to `until`: the end of the step, or a discontinuity before it.
    Returns whether any lane ends on one."""
    landed = False
    for lane in range(W):
        while jumps[passed[lane], lane] <= t[lane]:
            passed[lane] += 1
        landed = landed or jumps[passed[lane], lane] <= end
        until[lane] = min(jumps[passed[lane], lane], end)
    return landed


@apart
def _set_clock(clock: Address, t: Lanes, to: Lanes, begin: float, end: float, h: float) -> None:
    """The clock of a part of a step. A step that is not cut is h long, whatever its ends round to."""
    length = choose((to == end) & (t == begin), splat(h), to - t)
    store(clock, layout.TIME, t)
    store(clock, layout.LENGTH, length)
    store(clock, layout.MIDDLE, t + 0.5 * length)


class Runs(NamedTuple):
    """The arrays of `drive` that are of runs."""

    states: Floats3
    parameters: Floats3
    discontinuities: Floats3
    records: Floats4
    statuses: Floats2
    end_steps: Floats2
    ends: Floats2
    kept: Floats3


def drive(
    kernels: Integers1, nodes: Floats1, sizes: Sizes, steps: int, h: float, output_steps: Integers1, limit: int,
    tolerance: float, states: Floats3, parameters: Floats3, discontinuities: Floats3, records: Floats4,
    statuses: Floats2, end_steps: Floats2, ends: Floats2, kept: Floats3, plan: Plan, buffer: Floats1,
    passed: Integers1, progress: Integers1, stop: Integers1,
) -> None:  # fmt: skip
    """Integrate all blocks.

    kernels: see `layout.ORDER`; nodes: c of all stages; states (blocks, state rows, W): initial, left at the last good
    state; parameters (blocks, P, W), invariants prepared; discontinuities (blocks, L, W): the times on which a step
    must end, those of a lane ascending, and an infinite one last;
    records (blocks, outputs, record rows, W): what is stored, at the steps `output_steps`;
    statuses (blocks, W): in, 0 for lanes that may run, out, the code; end_steps (blocks, W): the last good step; ends
    (blocks, W): the time of the last good state (s), which is later where a step failed behind a discontinuity; kept:
    see `lane_queue.ChunkRuns`; plan: what of it;
    buffer: as many rows as `layout.workspace` says, and the kernels' work; passed (W,): room for the discontinuities
    that each lane has passed; progress[0]: outputs done so far;
    stop[0]: set from outside to end early; limit and tolerance: of the projections. Every array is contiguous.
    """
    runs = Runs(states, parameters, discontinuities, records, statuses, end_steps, ends, kept)
    at, first = addresses(buffer, sizes), layout.workspace(sizes)
    memory = matrix(buffer.ctypes.data, first.work, W)
    table = memory[first.table : first.table + selection_table.table_rows(sizes.exchangeable)]
    context = Context(kernels, nodes, sizes, plan, limit, tolerance, at, first, memory, table)
    when = Steps(steps, h, output_steps)
    if sizes.kept > 0:
        _measured(context, when, runs, passed, progress, stop)
    else:
        _unmeasured(context, when, runs, passed, progress, stop)


class Steps(NamedTuple):
    """How many steps of which length (s), and at which of them something is stored."""

    number: int
    h: float
    outputs: Integers1


@apart
def _measured(
    context: Context, when: Steps, runs: Runs, passed: np.ndarray, progress: np.ndarray, stop: np.ndarray
) -> None:
    _advance(context, when, runs, passed, progress, stop, True)


@apart
def _unmeasured(
    context: Context, when: Steps, runs: Runs, passed: np.ndarray, progress: np.ndarray, stop: np.ndarray
) -> None:
    """In code of its own: where nothing is measured, what would do so costs 4 % of a step of the heavy top."""
    _advance(context, when, runs, passed, progress, stop, False)


@inlined
def _advance(
    context: Context,
    when: Steps,
    runs: Runs,
    passed: np.ndarray,
    progress: np.ndarray,
    stop: np.ndarray,
    measured: bool,
) -> None:
    """See `drive`; measured: whether something is kept of runs as a whole."""
    kernels, sizes, at, first, memory = context.kernels, context.sizes, context.at, context.first, context.rows
    steps, h, output_steps = when
    states, parameters, discontinuities, records, statuses, end_steps, ends, kept = runs
    elements, rows, q = layout.element_rows(sizes), layout.state_rows(sizes), sizes.exchangeable
    best = elements + sizes.first_mask + q  # the row of the largest margin
    clock, lanes = at.clock, at.lanes
    iterations, status, end_step = lanes + ROW * ITERATIONS, lanes + ROW * STATUS, lanes + ROW * ACCEPTED
    since, until = memory[first.lanes + T], memory[first.lanes + UNTIL]
    cuts = discontinuities.shape[1] > 1
    for block in range(states.shape[0]):
        x, places = at.state, Places(at.new, at.now, at.following)
        state, p = states[block].ctypes.data, parameters[block].ctypes.data
        copy(x, state, rows)
        jumps = discontinuities[block]
        store(status, 0, load(statuses[block].ctypes.data, 0))
        for row in range(layout.PROJECTIONS):
            store(iterations, row, splat(0.0))
        store(end_step, 0, splat(0.0))
        store(clock, layout.TIME, splat(0.0))
        store(lanes, T, splat(0.0))
        passed[:] = 0
        if kernels[layout.SAMPLE] != 0:
            call(kernels[layout.SAMPLE], x, p, clock, 0, places.new, at.work)
            commit(load(status, 0) == 0.0, x, places.new, elements)
        if measured:
            copy(at.parameters, p, sizes.parameters)
            store(lanes, FRESH, splat(1.0))
            store(lanes, SEEN, splat(0.0))
            begin_measures(context)
        done = 0
        for n in range(steps + 1):
            if stop[0] != 0:
                return
            alive = load(status, 0) == 0.0
            going = alive & (load(lanes, T) < n * h)
            while any_lane(going):
                landed = cuts and _next_part(since, until, jumps, passed, n * h)
                if not cuts:
                    store(lanes, UNTIL, splat(n * h))
                _set_clock(clock, load(lanes, T), load(lanes, UNTIL), (n - 1) * h, n * h, h)
                if kernels[layout.STEP] != 0:
                    call(kernels[layout.STEP], x, p, clock, 0, places.new, at.work)
                else:
                    stages.staged_step(context, 0, x, p, places.new)
                if measured and sizes.integrands > 0:
                    made = places.new + ROW * layout.first_slope(sizes)
                    take_gains(context, x, made)
                store(clock, layout.TIME, load(lanes, UNTIL))
                code = load(places.new, rows + layout.CODE)
                margin = load(places.new, rows + layout.MARGIN)
                store(status, 0, choose(going, code, load(status, 0)))
                places = stages.project(context, p, places, True, status, going, iterations)
                good = going & (load(status, 0) == 0.0)
                if measured and any_lane(good):
                    measure(placed(context, x, places), good, load(lanes, UNTIL), splat(0.0) > 0.0, True)
                if all_lanes(good):
                    x, places = places.new, Places(x, places.now, places.following)
                else:
                    commit(good, x, places.new, rows)
                if q > 0:
                    weak = good & (margin < WEAKENED * load(x, best))
                    if any_lane(weak):
                        others = stages.reselect(context, x, p, weak, x)
                        if sizes.fixed != 0:
                            store(status, 0, choose(others, codes.RESELECT, load(status, 0)))
                        if measured and sizes.leaping > 0:
                            store(lanes, SEEN, choose(others, splat(0.0), load(lanes, SEEN)))
                if landed and kernels[layout.SAMPLE] != 0:
                    call(kernels[layout.SAMPLE], x, p, clock, 0, places.new, at.work)
                    commit(good, x, places.new, elements)
                if measured and landed:
                    forget_past(sizes, at, good)
                    if sizes.leaping > 0:
                        store(lanes, SEEN, splat(0.0))
                store(lanes, T, choose(good, load(lanes, UNTIL), load(lanes, T)))
                going = good & (load(lanes, T) < n * h)
            store(clock, layout.TIME, splat(n * h))
            alive = load(status, 0) == 0.0
            store(end_step, 0, choose(alive, splat(float(n)), load(end_step, 0)))
            if done < output_steps.size and output_steps[done] == n:
                stages.record(context, records[block, done].ctypes.data, x, p, alive, iterations)
                for row in range(layout.PROJECTIONS):
                    store(iterations, row, splat(0.0))
                done += 1
                progress[0] += 1
                if not any_lane(alive):
                    break
        copy(state, x, rows)
        store(statuses[block].ctypes.data, 0, load(status, 0))
        store(end_steps[block].ctypes.data, 0, load(end_step, 0))
        store(ends[block].ctypes.data, 0, load(lanes, T))
        if measured:
            copy(kept[block].ctypes.data, at.measures, kept.shape[1])
        for rest in range(done, output_steps.size):
            for row in range(layout.record_rows(sizes)):
                store(records[block, rest].ctypes.data, row, splat(np.nan))
        progress[0] += output_steps.size - done
