"""The driver of a queue: each lane has its own time, chooses its steps, and takes the next run when one is over.

A step stays open until it is accepted: the state at its start is there, with the slopes of all stages, so that what
lies between its ends is read off the continuous extension, and no output ever moves a step. What is stored is projected
and observed afterwards, block by block. With steps of one length it is for events.
"""

import numpy as np

from lienumba.compiler.lanes import Address, Lanes, Mask, any_lane, call, choose, load, matrix, splat, store
from lienumba.compiler.routines.marks import Floats1, Integers1, Integers2, apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout, selection_table
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.changes import change
from lienumba.integrators.drivers.dense_output import earliest_end, keep_between, keep_ends, observe, pending
from lienumba.integrators.drivers.events.finding import find_events, leave, read_off, start_events, start_switches
from lienumba.integrators.drivers.events.tolerances import SIMULTANEOUS_RTOL
from lienumba.integrators.drivers.implicit import forget, grow, shorten, solve_stages, straddle
from lienumba.integrators.drivers.lane_queue import (
    END,
    LAST,
    LONGEST,
    NEVER,
    STEP,
    TOLERANCE,
    ChunkRuns,
    Queue,
    accept,
    fill,
    finish,
    keep,
    lose_patience,
    pass_discontinuities,
    propose,
    reject,
)
from lienumba.integrators.drivers.measuring.steps import (
    begin_measures,
    forget_past_of,
    measure,
    renew_rates,
    take_gains,
)
from lienumba.integrators.drivers.row_selection import WEAKENED
from lienumba.integrators.drivers.stages import commit
from lienumba.integrators.drivers.trail import SAMPLES, STEPS, note
from lienumba.integrators.drivers.workspace import Context, Places, Plan, addresses
from lienumba.integrators.layout import (
    ACCEPTED,
    BACK,
    BUSY,
    CHANGED,
    DUE,
    FRESH,
    GRID,
    ITERATIONS,
    JUMP,
    PICKED,
    SEEN,
    STALE,
    STATUS,
    TRIAL,
    UNTIL,
    H,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import maximum, minimum

WEAK = 1e-4  # margin of a step that begins or ends near a singular position
LOST = 1e-12  # of one that ends so near to it that the branch is noise to implicit stages


@apart
def _next_runs(
    context: Context, runs: ChunkRuns, queue: Queue, outputs: np.ndarray, pace: np.ndarray, step: float
) -> bool:
    """Give every lane without a run the next one, and store its start; whether any lane has a run."""
    kernels, sizes, at, first, rows = context.kernels, context.sizes, context.at, context.first, context.rows
    fresh, busy = False, False
    for lane in range(W):
        if rows[first.lanes + BUSY, lane] == 0.0:
            fresh = fill(lane, rows, first, runs, queue) or fresh
        busy = busy or rows[first.lanes + BUSY, lane] != 0.0
    if not fresh:
        return busy
    if kernels[layout.SAMPLE] != 0:
        store(at.clock, layout.TIME, splat(0.0))
        call(kernels[layout.SAMPLE], at.state, at.parameters, at.clock, 0, at.new, at.work)
        commit(load(at.lanes, FRESH) != 0.0, at.state, at.new, layout.element_rows(sizes))
    if layout.conditions(sizes) > 0:
        if sizes.switches > 0:
            start_switches(context)
            change(context, runs, queue, pace[END], step)
        start_events(context, runs, queue)
        if any_lane(load(at.lanes, CHANGED) != 0.0):
            change(context, runs, queue, pace[END], step)
    if sizes.kept > 0:
        begin_measures(context)
    for lane in range(W):
        if rows[first.lanes + FRESH, lane] != 0.0:
            keep(lane, rows, first, sizes, runs, queue, outputs, first.state, True)
            rows[first.lanes + FRESH, lane] = 0.0
    return busy


@inlined
def _take(mask: Mask, sizes: Sizes, slopes: Address) -> None:
    """F at the end of a step is the first slope of the next one."""
    if sizes.slopes > 1:
        for element in range(sizes.elements):
            source, target = layout.slope_row(sizes, element, sizes.slopes - 1), layout.slope_row(sizes, element, 0)
            commit(mask, slopes + ROW * target, slopes + ROW * source, sizes.coordinates)
        source, target = layout.report_row(sizes, sizes.slopes - 1), layout.report_row(sizes, 0)
        commit(mask, slopes + ROW * target, slopes + ROW * source, layout.REPORTS)
        for n in range(sizes.integrands):
            source, target = layout.said_row(sizes, n, sizes.slopes - 1), layout.said_row(sizes, n, 0)
            commit(mask, slopes + ROW * target, slopes + ROW * source, 1)


@inlined
def _expand(kernels: np.ndarray, at: Workspace, pace: np.ndarray) -> None:
    """The series of a step, which says how long it may be: again shorter where it was rejected."""
    lanes, t, jump = at.lanes, load(at.lanes, T), load(at.lanes, JUMP)
    store(at.clock, layout.TIME, t)
    store(at.clock, layout.MIDDLE, 0.5 * (t + choose(jump < pace[END], jump, splat(pace[END]))))
    call(kernels[layout.EXPAND], at.state, at.parameters, at.clock, 0, at.slopes, at.work)
    wanted = load(at.control, layout.FACTOR)
    wanted = choose(wanted > pace[LONGEST], splat(pace[LONGEST]), wanted)
    store(lanes, H, choose(load(lanes, BACK) != 0.0, load(lanes, H), wanted))


@inlined
def _try(context: Context) -> None:
    """One step of every lane with its projections, and where a tolerance chooses steps with F at its end and its error;
    codes go to TRIAL."""
    kernels, sizes, at = context.kernels, context.sizes, context.at
    x, p, new, lanes = at.state, at.parameters, at.new, at.lanes
    last, adaptive = at.slopes + ROW * layout.slope_row(sizes, 0, sizes.slopes - 1), kernels[layout.CLOSE] != 0
    implicit = kernels[layout.NEWTON] != 0
    ends = adaptive or (implicit and sizes.weakens != 0)  # whether F is known at both of them
    stale = load(lanes, STALE) != 0.0
    if ends and any_lane(stale):
        call(kernels[layout.FIRST], x, p, at.clock, 0, last, at.work)
        _take(stale, sizes, at.slopes)
        if sizes.seen > 0:
            renew_rates(context, stale)
        store(lanes, STALE, splat(0.0))
    unsettled = splat(0.0)
    if implicit:
        begins = forget(sizes, x, stale)
        if not ends and (sizes.exchangeable > 0 or any_lane(begins)):
            call(kernels[layout.FIRST], x, p, at.clock, 0, at.slopes, at.work)
        unsettled = solve_stages(kernels, sizes, at, stale)
        store(lanes, STALE, splat(0.0))
    if kernels[layout.STEP] != 0:
        call(kernels[layout.STEP], x, p, at.clock, at.slopes, new, at.work)
    else:
        stages.staged_step(context, 1 if adaptive else 0, x, p, new)
    if sizes.integrands > 0 and not adaptive:
        take_gains(context, x, at.slopes + ROW * layout.quadrature_row(sizes))
    if kernels[layout.DEFECT] != 0:
        call(kernels[layout.DEFECT], x, p, at.clock, at.slopes, at.slopes, at.work)
    trial = lanes + ROW * TRIAL
    said = load(new, layout.state_rows(sizes) + layout.CODE)
    store(trial, 0, choose(unsettled == 0.0, said, unsettled))
    store(at.clock, layout.TIME, load(lanes, UNTIL))
    busy = load(lanes, BUSY) != 0.0
    iterations = lanes + ROW * ITERATIONS
    places = Places(new, at.now, at.following)
    stages.project(context, p, places, False, trial, busy, iterations)
    if not ends:
        return
    call(kernels[layout.FIRST], new, p, at.clock, 0, last, at.work)
    if implicit and sizes.weakens != 0:
        lost = load(last, layout.report_row(sizes, 0) + layout.STAGE_MARGIN) < LOST
        store(trial, 0, choose(lost & (load(trial, 0) == 0.0), splat(codes.SINGULAR), load(trial, 0)))
    if not adaptive:
        return
    sound = load(at.slopes, layout.report_row(sizes, sizes.slopes - 1) + layout.NONSINGULAR) > 0.0
    store(trial, 0, choose(sound, load(trial, 0), choose(load(trial, 0) == 0.0, splat(codes.SINGULAR), load(trial, 0))))
    call(kernels[layout.CLOSE], x, p, at.clock, new, at.control, at.work)
    if sizes.integrands > 0:
        take_gains(context, x, at.slopes)
    if kernels[layout.CLOSE_ALONG] != 0:
        margin = layout.report_row(sizes, 0) + layout.STAGE_MARGIN
        weak = (load(at.slopes, margin) < WEAK) | (load(last, margin) < WEAK)
        if any_lane(weak):
            call(kernels[layout.CLOSE_ALONG], x, p, at.clock, new, at.u, at.work)
            commit(weak, at.control, at.u, layout.CONTROL)


@inlined
def _move(context: Context, good: Mask, left: Lanes, pace: np.ndarray) -> None:
    """The step is done in the lanes `good`, which leave it at the time `left`, or at its end."""
    sizes, at = context.sizes, context.at
    rows, lanes, x = layout.state_rows(sizes), at.lanes, at.state
    until, grid = load(lanes, UNTIL), load(lanes, GRID)
    store(at.clock, layout.TIME, until)
    commit(good, x, at.new, rows)
    store(lanes, T, choose(good, until, load(lanes, T)))
    counted = good
    if pace[STEP] > 0.0:
        came = choose((left < until) & (load(lanes, CHANGED) != 0.0), left, until)
        counted = good & (came >= (grid + 1.0) * pace[STEP])
    store(lanes, GRID, choose(counted, grid + 1.0, grid))
    store(lanes, ACCEPTED, choose(counted, load(lanes, ACCEPTED) + 1.0, load(lanes, ACCEPTED)))
    _take(good, sizes, at.slopes)
    if sizes.exchangeable > 0:
        best = layout.element_rows(sizes) + sizes.first_mask + sizes.exchangeable  # the row of the largest margin
        weak = good & (load(at.new, rows + layout.MARGIN) < WEAKENED * load(x, best))
        if any_lane(weak):
            others = stages.reselect(context, x, at.parameters, weak, x)
            store(lanes, STALE, choose(others, splat(1.0), load(lanes, STALE)))
            if sizes.leaping > 0:
                store(lanes, SEEN, choose(others, minimum(load(lanes, SEEN), splat(0.0)), load(lanes, SEEN)))
            if sizes.fixed != 0:
                store(lanes, STATUS, choose(others, splat(codes.RESELECT), load(lanes, STATUS)))


@apart
def _note_step(context: Context, runs: ChunkRuns, queue: Queue, good: Mask, began: Lanes, length: Lanes) -> None:
    """The step that is over, to the trails of the lanes `good`."""
    own, rows = context.first.lanes, context.rows
    store(context.at.lanes, PICKED, choose(good, splat(1.0), splat(0.0)))
    store(context.at.u, 0, began)
    store(context.at.u, 1, choose(load(context.at.lanes, T) < load(context.at.lanes, UNTIL), splat(0.0), length))
    for lane in range(W):
        if rows[own + PICKED, lane] != 0.0:
            begin, uncut = rows[context.first.u, lane], rows[context.first.u + 1, lane]
            run = queue.block[lane] * W + queue.lane[lane]
            note(runs.trail, run, rows, lane, context.first.state, STEPS, begin, rows[own + T, lane], uncut)


@apart
def _end_on_discontinuity(context: Context, runs: ChunkRuns, queue: Queue, moved: Mask) -> None:
    """What happens there: laws are sampled, and F may jump."""
    kernels, sizes, at, first, rows = context.kernels, context.sizes, context.at, context.first, context.rows
    own = first.lanes
    store(at.lanes, PICKED, choose(moved, splat(1.0), splat(0.0)))
    for lane in range(W):
        reached = rows[own + PICKED, lane] != 0.0 and pass_discontinuities(lane, rows, first, runs, queue)
        rows[own + PICKED, lane] = 1.0 if reached else 0.0
        if reached:
            rows[own + STALE, lane] = 1.0
            if sizes.leaping > 0:
                rows[own + SEEN, lane] = min(rows[own + SEEN, lane], 0.0)
            forget_past_of(lane, rows, first, sizes)
            rows[first.clock + layout.MEMORY, lane] = 0.0
    picked = load(at.lanes, PICKED) != 0.0
    if kernels[layout.SAMPLE] != 0 and any_lane(picked):
        call(kernels[layout.SAMPLE], at.state, at.parameters, at.clock, 0, at.new, at.work)
        commit(picked, at.state, at.new, layout.element_rows(sizes))
        for lane in range(W if runs.trail.entries.shape[1] > 0 else 0):
            if rows[own + PICKED, lane] != 0.0:
                run, t = queue.block[lane] * W + queue.lane[lane], rows[own + T, lane]
                note(runs.trail, run, rows, lane, first.state, SAMPLES, t, 0.0, 0.0)


def drive(
    kernels: Integers1, nodes: Floats1, sizes: Sizes, runs: ChunkRuns, outputs: Floats1, pace: Floats1,
    plan: Plan, limit: int, tolerance: float, buffer: Floats1, places: Integers2, progress: Integers1,
    stop: Integers1,
) -> None:  # fmt: skip
    """Integrate all runs.

    outputs: the times to be stored, from 0 on; pace: the end of the runs, the step where steps are of one length (else
    0), the longest and the shortest step, how far runs go at least, and the numbers of a `step_control.Tolerance`;
    limit and tolerance: of the projections; places (5, W): room for a `Queue`; the rest as in `fixed_step.drive`.
    """
    at, first = addresses(buffer, sizes), layout.workspace(sizes)
    rows = matrix(buffer.ctypes.data, first.work, W)
    table = rows[first.table : first.table + selection_table.table_rows(sizes.exchangeable)]
    queue = Queue(places[0], places[1], places[2], places[3], places[4])
    context = Context(kernels, nodes, sizes, plan, limit, tolerance, at, first, rows, table)
    queue.next[0] = 0
    lanes, total, fresh, done = at.lanes, runs.statuses.shape[0] * W, True, 0
    for lane in range(W):
        rows[first.lanes + BUSY, lane] = 0.0
    step = pace[STEP] if kernels[layout.NEWTON] == 0 or sizes.history > 0 else 0.0  # but for collocation
    while True:
        if stop[0] != 0:
            return
        if fresh:
            if not _next_runs(context, runs, queue, outputs, pace, step):
                break
            for n in range(pace.size - TOLERANCE):
                store(at.clock, layout.TOLERANCE + n, splat(pace[TOLERANCE + n]))
            fresh = False
        if kernels[layout.EXPAND] != 0:
            _expand(kernels, at, pace)
        propose(lanes, at.clock, pace[END], pace[STEP], kernels[layout.EXPAND] != 0)
        if kernels[layout.NEWTON] != 0 and pace[STEP] > 0.0:
            grow(sizes, at, pace[STEP])
        if kernels[layout.NEWTON] != 0 and sizes.weakens != 0:
            straddle(sizes, at, pace[STEP], pace[END])
        length, until = load(at.clock, layout.LENGTH), load(lanes, UNTIL)
        _try(context)
        given, trial = load(lanes, BUSY) != 0.0, load(lanes, TRIAL)
        busy = given & (load(lanes, STATUS) == 0.0)
        good = busy & (trial == 0.0)
        left = splat(NEVER)
        if pace[STEP] > 0.0:
            again = shorten(lanes, busy & (splat(float(kernels[layout.NEWTON])) != 0.0), length, pace[STEP])
            store(lanes, STATUS, choose(busy, choose(again, splat(0.0), trial), load(lanes, STATUS)))
        else:
            good = good & (load(at.control, layout.ERROR) <= 1.0)
            store(lanes, PICKED, choose(good, splat(0.0), splat(1.0)))
            reject(lanes, at.control, length, busy & (load(lanes, PICKED) != 0.0), pace)
        if layout.conditions(sizes) > 0:
            left = find_events(context, runs, queue, pace[END], good)
            good = good & (left >= 0.0)
            until = choose(left < until, left, until)
        if pace[STEP] == 0.0:
            accept(lanes, at.control, length, good, pace[LONGEST])
            store(
                at.clock,
                layout.MEMORY,
                choose(good, load(at.control, layout.REMEMBERED), load(at.clock, layout.MEMORY)),
            )
        if sizes.kept > 0 and any_lane(good):
            measure(context, good, until, left < NEVER, False)
        latest = choose(left < NEVER, until + SIMULTANEOUS_RTOL * maximum(length, until), until)
        if any_lane(pending(at, good, length, until, latest)):
            keep_between(context, runs, queue, outputs, good, until, latest)
        if any_lane(good & (left < load(lanes, UNTIL))):
            read_off(context, left)
        earliest, began = earliest_end(at, length), load(lanes, T)
        _move(context, good, left, pace)
        leave(context, left, good)
        if runs.trail.entries.shape[1] > 0:
            _note_step(context, runs, queue, good, began, length)
        reached = good & (load(lanes, T) == load(lanes, JUMP))
        if any_lane(reached):
            store(at.clock, layout.TIME, load(lanes, T))
            _end_on_discontinuity(context, runs, queue, reached)
        due = load(lanes, DUE)
        ended = good & (load(lanes, T) == load(lanes, UNTIL)) & (due >= earliest) & (due <= load(lanes, T))
        if any_lane(ended):
            keep_ends(context, runs, queue, outputs, ended)
        if layout.conditions(sizes) > 0 and any_lane(load(lanes, CHANGED) != 0.0):
            change(context, runs, queue, pace[END], step)
        if pace[STEP] == 0.0:
            lose_patience(lanes, given, pace[END])
        over = given & ((load(lanes, STATUS) != 0.0) | (load(lanes, T) >= pace[LAST]))
        if any_lane(over):
            store(lanes, PICKED, choose(over, splat(1.0), splat(0.0)))
            for lane in range(W):
                if rows[first.lanes + PICKED, lane] != 0.0:
                    finish(lane, rows, first, runs, queue)
                    rows[first.lanes + BUSY, lane] = 0.0
                    done += 1
            progress[0] = outputs.size * (done * runs.statuses.shape[0]) // total
            fresh = True
    observe(context, runs, outputs)
    progress[0] = outputs.size * runs.statuses.shape[0]
