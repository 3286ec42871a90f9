"""What happens at a change: actions of events, impacts, and how everything goes on from there.

A change is worked out in rounds at one time. In each of them events act, positions that are to close are closed, a
complementarity problem of velocities gives impulses, and one of accelerations says what stays closed, sticks or slides
(`reactions`). Conditions that become true by that are the next round's.
"""

import numpy as np

from lienumba.compiler.lanes import any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.change_records import record_change, record_events
from lienumba.integrators.drivers.events.acting import (
    engages,
    fired,
    follow,
    follow_one,
    hold,
    hold_before,
    let_go,
    lets_go,
    pass_over,
    rescale,
    sift,
    used,
)
from lienumba.integrators.drivers.events.finding import note
from lienumba.integrators.drivers.events.tolerances import CLOSED_GAP_RTOL, CONTACT_ROUNDOFF, SEPARATING_GAP_RTOL
from lienumba.integrators.drivers.lane_queue import NEVER, ChunkRuns, Queue, keep_state
from lienumba.integrators.drivers.measuring.steps import forget_past_of
from lienumba.integrators.drivers.notes import note_causes, note_kicks, note_modes, note_of_lane
from lienumba.integrators.drivers.switching import (
    complementarity,
    contact_laws,
    impacts,
    independent_rows,
    modes,
    problem,
    reactions,
)
from lienumba.integrators.drivers.switching.closing import close, has_closed, project, widest_gap
from lienumba.integrators.drivers.switching.reactions import Reactions
from lienumba.integrators.drivers.trail import ACTS, CLOSES, GOES_ON
from lienumba.integrators.drivers.workspace import Context, Plan, Rows
from lienumba.integrators.hysteresis import HYSTERESIS_RTOL
from lienumba.integrators.layout import (
    ACTION,
    BEGINS,
    BILATERAL,
    CHANGED,
    CLOCK_ROW,
    ENGAGES,
    FREES,
    FRESH,
    FRICTION,
    GAINED,
    HAD,
    LOCKS,
    MANY,
    OFF,
    PICKED,
    RECENT,
    RELEASES,
    SEEN,
    SETS,
    SLIDE,
    STALE,
    STATUS,
    STICK,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_MEMORIES,
    SWITCH_MEMORY,
    SWITCH_ROWS,
    TARGET,
    TARGETS,
    UNILATERAL,
    VALUE,
    WRITTEN,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import HOLDS

ROUNDS = 64  # at one time
WINDOW, MOST = 1e-6, 1000.0  # of the time of a run, and how many changes may be in so much of it


@apart
def change(context: Context, runs: ChunkRuns, queue: Queue, end: float, step: float) -> None:
    """Change the runs that are CHANGED, at their time T and state. Afterwards these have other modes, velocities and
    conditions, or a status. step: of given length, but by collocation; else 0."""
    kernels, sizes, plan, at, first, rows = (
        context.kernels, context.sizes, context.plan, context.at, context.first, context.rows,
    )  # fmt: skip
    x, p, lanes, switched = at.state, at.parameters, at.lanes, sizes.switches > 0
    forces = False
    for s in range(sizes.switches):
        forces = forces or plan.switches[s, SWITCH_KIND] != BILATERAL
    border, impulses = at.change, at.change + ROW * layout.change_impulses(sizes)
    store(at.clock, layout.TIME, load(lanes, T))
    project(context)
    for n in range(ROUNDS):
        pending = (load(lanes, CHANGED) != 0.0) & (load(lanes, STATUS) == 0.0)
        if not any_lane(pending):
            return
        store(lanes, CHANGED, choose(pending, splat(1.0), splat(0.0)))
        call(kernels[layout.EVENTS], x, p, at.clock, 0, at.following, at.work)
        hold_before(sizes, at, plan, at.following, pending)
        if n == 0:  # what held directly before the change, for what becomes true by it
            follow(sizes, at, at.following, at.following + ROW * layout.rate_row(sizes), pending)
        if n == 0:
            note_causes(context, runs, queue)
        jumps = False
        for lane in range(W):
            rows[first.lanes + FREES, lane], rows[first.lanes + PICKED, lane] = 0.0, 0.0
            if switched and rows[first.lanes + CHANGED, lane] != 0.0:
                frees = not forces and lets_go(sizes, first, rows, plan, lane)
                rows[first.lanes + FREES, lane], jumps = 1.0 if frees else 0.0, jumps or not frees
        if jumps:
            call(kernels[layout.BORDER], x, p, at.clock, 0, border, at.work)
        for lane in range(W):
            if rows[first.lanes + CHANGED, lane] != 0.0:
                if rows[first.lanes + FREES, lane] == 0.0:
                    starts = n == 0 and rows[first.lanes + FRESH, lane] != 0.0
                    reactions.update_velocity_scale(rows, first, sizes, plan.switches, lane, starts, end)
                if sizes.values > 0:
                    rows[first.lanes + HAD, lane] = _energy(sizes, first, rows, plan, lane)
                _begin(sizes, first, rows, plan, lane)
        for event in range(sizes.events):  # in the order of the file, each with what those before it have set
            sets = False
            for lane in range(W):
                if rows[first.lanes + CHANGED, lane] != 0.0 and fired(sizes, first, rows, lane, event):
                    _act(sizes, first, rows, plan, lane, event)
                    note_of_lane(context, runs, queue, lane, ACTS, float(event))
                    sets = sets or plan.acts[event, ACTION] == SETS or plan.acts[event, CLOCK_ROW] >= 0
            if sets:
                call(kernels[layout.EVENTS], x, p, at.clock, 0, at.following, at.work)
                rescale(sizes, at, plan, at.following, load(lanes, CHANGED) != 0.0)
        if sizes.values > 0:
            _gain(kernels, sizes, at, first, rows, plan)
        if switched and any_lane(load(lanes, FRESH) != 0.0):  # with what now holds from the start on
            call(kernels[layout.BORDER], x, p, at.clock, 0, border, at.work)
        r = reactions.contact_workspace(at, sizes, plan.switches)
        closing = load(lanes, PICKED) != 0.0
        if any_lane(closing):
            for lane in range(W):
                if rows[first.lanes + PICKED, lane] != 0.0:
                    reactions.read(r, rows, first, sizes, lane)
                    independent_rows.choose_rows(r, rows, first, sizes, lane)
                    note_of_lane(context, runs, queue, lane, GOES_ON, 1.0)
            close(context, closing)
            call(kernels[layout.BORDER], x, p, at.clock, 0, border, at.work)
            for lane in range(W):
                if rows[first.lanes + PICKED, lane] != 0.0:
                    has_closed(sizes, first, rows, plan, lane, context.tolerance)
                    note_of_lane(context, runs, queue, lane, CLOSES, 0.0)
            if sizes.values > 0:
                _gain(kernels, sizes, at, first, rows, plan)
        for lane in range(W):
            changes, hit = rows[first.lanes + CHANGED, lane] != 0.0, False
            if changes:
                hit = switched and rows[first.lanes + FREES, lane] == 0.0 and _hit(r, sizes, first, rows, lane)
            if changes and rows[first.lanes + STATUS, lane] == 0.0:  # impulses that were not found do nothing
                record_events(r, sizes, first, rows, runs, queue, plan, lane)
            rows[first.lanes + PICKED, lane] = 1.0 if hit and rows[first.lanes + STATUS, lane] == 0.0 else 0.0
        if switched:
            hits = load(lanes, PICKED) != 0.0
            if any_lane(hits):
                call(kernels[layout.KICK], x, p, at.clock, impulses, at.now, at.work)
                stages.commit(hits, x, at.now, layout.state_rows(sizes))
                note_kicks(context, runs, queue, 0.0)
            if forces and (sizes.values > 0 or any_lane(hits)):  # of locks and joints alone nothing is asked again
                call(kernels[layout.BORDER], x, p, at.clock, 0, border, at.work)
            for _ in range(sizes.switches if forces else 0):  # what is brought to rest may slow down others
                if not _halt(r, sizes, first, rows):
                    break
                call(kernels[layout.KICK], x, p, at.clock, impulses, at.now, at.work)
                stages.commit(load(lanes, PICKED) != 0.0, x, at.now, layout.state_rows(sizes))
                note_kicks(context, runs, queue, 1.0)
                call(kernels[layout.BORDER], x, p, at.clock, 0, border, at.work)
            for lane in range(W):
                rows[first.lanes + PICKED, lane] = 0.0
                if rows[first.lanes + FREES, lane] != 0.0:
                    let_go(sizes, first, rows, plan, lane)
                elif rows[first.lanes + CHANGED, lane] != 0.0 and rows[first.lanes + STATUS, lane] == 0.0:
                    _assign_modes_of_lane(r, sizes, first, rows, runs, queue, lane, forces, step)
            begins = load(lanes, PICKED) != 0.0
            if any_lane(begins):
                call(kernels[layout.KICK], x, p, at.clock, impulses, at.now, at.work)
                stages.commit(begins, x, at.now, layout.state_rows(sizes))
                note_kicks(context, runs, queue, 1.0)
        note_modes(context, runs, queue)
        call(kernels[layout.EVENTS], x, p, at.clock, 0, at.following, at.work)
        hold(sizes, at, at.following)
        for lane in range(W):
            if rows[first.lanes + CHANGED, lane] != 0.0 and rows[first.lanes + STATUS, lane] == 0.0:
                _renew(sizes, first, rows, runs, queue, plan, lane, end)
    endless = (load(lanes, CHANGED) != 0.0) & (load(lanes, STATUS) == 0.0)
    store(lanes, STATUS, choose(endless, splat(codes.CHATTERING), load(lanes, STATUS)))


@apart
def _begin(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> None:
    """PICKED where joints are to close; if one of them cannot, nothing happens. What locks a run as it begins remembers
    how it begins."""
    values = first.following + layout.conditions(sizes)
    for event in range(sizes.events):
        if engages(sizes, first, rows, plan, lane, event):
            rows[first.lanes + PICKED, lane] = 1.0
            if widest_gap(sizes, first, rows, plan, lane, event) > rows[values + plan.acts[event, VALUE], lane]:
                rows[first.lanes + STATUS, lane] = codes.NOT_CLOSED
    if rows[first.lanes + STATUS, lane] != 0.0:
        rows[first.lanes + CHANGED, lane] = rows[first.lanes + PICKED, lane] = 0.0
        return
    for s in range(sizes.switches):
        on = rows[first.state + layout.on_row(sizes) + s, lane] != OFF
        if rows[first.lanes + FRESH, lane] != 0.0 and on and plan.switches[s, SWITCH_KIND] == BILATERAL:
            _turn_on(sizes, first, rows, plan, lane, s)


@apart
def _act(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, event: int) -> None:
    """Do what an event does."""
    values, action = first.following + layout.conditions(sizes), plan.acts[event, ACTION]
    for n in range(plan.acts[event, TARGETS]):
        target = plan.targets[plan.acts[event, TARGET] + n]
        if action == SETS:
            rows[first.state + target, lane] = rows[values + plan.acts[event, VALUE] + n, lane]
        if action == RELEASES:
            rows[first.state + layout.on_row(sizes) + target, lane] = float(OFF)
        if LOCKS <= action <= ENGAGES:
            _turn_on(sizes, first, rows, plan, lane, target)
    if plan.acts[event, CLOCK_ROW] >= 0:
        rows[first.state + plan.acts[event, CLOCK_ROW], lane] = rows[first.lanes + T, lane]


@apart
def _energy(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int) -> float:
    """The energy (J) of a lane as far as an action changes it by itself: of numbers that are set the potential one,
    kinetic energy, too, where bodies are moved to close a joint."""
    behind, energy = first.following + layout.pushing_row(sizes), 0.0
    sets, closes = False, False
    for event in range(sizes.events):
        if fired(sizes, first, rows, lane, event):
            sets = sets or plan.acts[event, ACTION] == SETS or plan.acts[event, CLOCK_ROW] >= 0
            closes = closes or plan.acts[event, ACTION] == ENGAGES
    if sets or closes:
        energy += rows[behind - 1, lane]
    if closes:
        energy += rows[behind - 2, lane]
    return energy


@apart
def _gain(kernels: np.ndarray, sizes: Sizes, at: Workspace, first: Workspace, rows: Rows, plan: Plan) -> None:
    """What lanes that change have GAINED of energy since it was last asked for, to the books as work."""
    call(kernels[layout.EVENTS], at.state, at.parameters, at.clock, 0, at.following, at.work)
    for lane in range(W):
        if rows[first.lanes + CHANGED, lane] != 0.0:
            energy = _energy(sizes, first, rows, plan, lane)
            gained = energy - rows[first.lanes + HAD, lane]
            rows[first.state + layout.work_row(sizes), lane] += gained
            rows[first.lanes + GAINED, lane], rows[first.lanes + HAD, lane] = gained, energy


@inlined
def _turn_on(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, switch: int) -> None:
    """A lock or a joint holds from now on."""
    rows[first.state + layout.on_row(sizes) + switch, lane] = float(STICK)
    memory = plan.switches[switch, SWITCH_MEMORY]
    for n in range(memory, memory + plan.switches[switch, SWITCH_MEMORIES]):
        measured = rows[first.change + layout.border_memory(sizes) + n, lane]
        rows[first.state + layout.memory_row(sizes) + n, lane] = measured


@apart
def _hit(r: Reactions, sizes: Sizes, first: Workspace, rows: Rows, lane: int) -> bool:
    """Impulses of a lane, to where `kick` reads them; whether there are any."""
    reactions.read(r, rows, first, sizes, lane)
    p, hit = r.problem, False
    for s in range(sizes.switches):
        row, on = p.switches[s, SWITCH_FIRST], rows[first.state + layout.on_row(sizes) + s, lane] != OFF
        still = reactions.still(rows, first, sizes, lane, s)
        if p.switches[s, SWITCH_KIND] == BILATERAL and on:
            for i in range(row, row + p.switches[s, SWITCH_ROWS]):
                hit = hit or max(r.rates[i], -r.rates[i]) > still
        if p.switches[s, SWITCH_KIND] == UNILATERAL:
            touches = on or reactions.touches(rows, first, sizes, lane, s, row)
            hit = hit or (touches and r.rates[row] < -still)
    if hit:
        status = impacts.impulses(r, rows, first, sizes, lane)
        if status != problem.SOLVED:
            rows[first.lanes + STATUS, lane] = _failure(r, problem.UNSOLVED)
        elif not impacts.holds(r, rows, first, sizes, lane):
            rows[first.lanes + STATUS, lane] = codes.CONTRADICTS
    for i in range(sizes.switched):
        rows[first.change + layout.change_impulses(sizes) + i, lane] = p.x[i]
    return hit


@apart
def _halt(r: Reactions, sizes: Sizes, first: Workspace, rows: Rows) -> bool:
    """Impulses of lanes in which something is brought to rest, to where `kick` reads them; whether there are any."""
    some = False
    for lane in range(W):
        rows[first.lanes + PICKED, lane] = 0.0
        asked = rows[first.lanes + CHANGED, lane] != 0.0 and rows[first.lanes + STATUS, lane] == 0.0
        if asked and rows[first.lanes + FREES, lane] == 0.0:
            reactions.read(r, rows, first, sizes, lane)
            if contact_laws.halt(r, rows, first, sizes, lane):
                rows[first.lanes + PICKED, lane], some = 1.0, True
                for i in range(sizes.switched):
                    rows[first.change + layout.change_impulses(sizes) + i, lane] = r.problem.x[i]
    return some


@inlined
def _failure(r: Reactions, status: int) -> float:
    """The status of a run in which impulses or forces were not found."""
    if status == problem.PARADOX:
        return codes.PARADOX
    return codes.CONTRADICTS if complementarity.contradicts(r.problem) else codes.UNSOLVED


@apart
def _assign_modes_of_lane(
    r: Reactions, sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, lane: int, forces: bool,
    step: float,
) -> None:  # fmt: skip
    """Modes of a lane from now on, and what of that is a change, to the books."""
    p, on, before = r.problem, first.state + layout.on_row(sizes), first.conditions + layout.conditions(sizes)
    reactions.read(r, rows, first, sizes, lane)
    for s in range(sizes.switches):
        row, unilateral = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_KIND] == UNILATERAL
        driven = unilateral and r.rates[row] < -impacts.DRIVEN * reactions.still(rows, first, sizes, lane, s)
        if driven and reactions.touches(rows, first, sizes, lane, s, row):
            rows[first.lanes + STATUS, lane] = codes.CONTRADICTS
    for s in range(sizes.switches):  # what was, where conditions at the end of a step were
        rows[before + sizes.events + s, lane] = rows[on + s, lane]
    status = modes.decide(r, rows, first, sizes, lane) if forces else problem.SOLVED
    if step > 0.0 and forces:
        modes.limit_friction_stiffness(r, rows, first, sizes, lane, step)
    independent_rows.choose_rows(r, rows, first, sizes, lane)
    if status == problem.SOLVED and modes.seed_sliding(r, rows, first, sizes, lane):
        rows[first.lanes + PICKED, lane] = 1.0
        for i in range(sizes.switched):
            rows[first.change + layout.change_impulses(sizes) + i, lane] = p.x[i]
    if status != problem.SOLVED:
        rows[first.lanes + STATUS, lane] = _failure(r, status)
    for s in range(sizes.switches):
        was, now, kind = rows[before + sizes.events + s, lane], rows[on + s, lane], p.switches[s, SWITCH_KIND]
        if kind != BILATERAL and was != now:
            tells = codes.SLID if now == SLIDE else codes.STUCK
            if kind == UNILATERAL and was == OFF:
                tells = codes.CLOSED
            if kind == UNILATERAL and now == OFF:
                tells = codes.OPENED
            if kind != FRICTION or was != OFF:
                record_change(rows, first, runs, queue, lane, tells, s, 0.0, 0.0)


@inlined
def _decided(sizes: Sizes, first: Workspace, rows: Rows, lane: int, condition: int) -> bool:
    """Whether a condition of a switch is about what a change decides, and not the rate of an open gap."""
    on = rows[first.state + layout.on_row(sizes) + condition // layout.CONDITIONS, lane]
    return on != OFF or condition % layout.CONDITIONS == layout.OPENS


@inlined
def _rounding(
    sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, condition: int, force: float, old: float
) -> float:  # fmt: skip
    """What a condition of a switch, that was `old` before a change, may be by rounding behind it, in its own unit;
    force: that of what is closed (N). A gap that is open may be so far below 0 that its contact touches, at a time that
    is rounded. What is closed may pull by a part of the force with which the step began: it will have to open yet."""
    switch = condition // layout.CONDITIONS
    mode = rows[first.state + layout.on_row(sizes) + switch, lane]
    if condition % layout.CONDITIONS == layout.SLIDES:
        dry = plan.switches[switch, SWITCH_KIND] == FRICTION
        held = dry and not used(sizes, first, rows, plan.switches, lane, switch)
        speed = CONTACT_ROUNDOFF * rows[first.change + layout.change_speeds(sizes) + switch, lane]
        return force if mode == STICK and not held else speed
    if mode == OFF:
        apart = rows[first.following + sizes.events + condition + layout.SLIDES - layout.OPENS, lane] > 0.0
        return SEPARATING_GAP_RTOL if apart else CLOSED_GAP_RTOL
    return max(force, modes.FORCE_RTOL * -old)


@inlined
def _is_reset(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, event: int, new: float) -> bool:
    """Whether an event has set its own condition false, as that of a timer."""
    extent = rows[first.conditions + layout.peak_row(sizes) + layout.EXTENT * sizes.events + event, lane]
    sets = plan.acts[event, ACTION] == SETS and plan.acts[event, WRITTEN] != 0
    return sets and new < -HYSTERESIS_RTOL * extent


@apart
def _renew(
    sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, lane: int, end: float
) -> None:
    """Conditions after a change; those of events that became true by it happen now, those of switches say nothing of
    what has just been decided. Before a run has any events, none happens."""
    own, count = first.lanes, layout.conditions(sizes)
    t, again, noise, begins = rows[own + T, lane], False, 0.0, rows[first.lanes + FRESH, lane] == BEGINS
    for s in range(sizes.switches):
        force = rows[first.following + sizes.events + layout.CONDITIONS * s + layout.OPENS, lane]
        if rows[first.state + layout.on_row(sizes) + s, lane] != OFF:
            noise = max(noise, CONTACT_ROUNDOFF * max(force, -force))
    for n in range(count):
        now = n < sizes.events and fired(sizes, first, rows, lane, n)
        old, new = rows[first.conditions + n, lane], rows[first.following + n, lane]
        turned = n < sizes.events and new > 0.0 and not old > 0.0 and not now and not begins
        rows[first.conditions + 2 * count + n, lane] = t if turned else NEVER
        if turned:
            keep_state(rows, runs, queue, lane, n, first.state)
        if now and not _is_reset(sizes, first, rows, plan, lane, n, new):
            new = max(new, HOLDS)
        if n >= sizes.events and _decided(sizes, first, rows, lane, n - sizes.events):
            least = _rounding(sizes, first, rows, plan, lane, n - sizes.events, noise, old)
            new = new if new > least else min(new, 0.0)
        if n < sizes.events:
            follow_one(sizes, first, rows, lane, n, new)
        rows[first.conditions + n, lane] = new
        rows[first.conditions + layout.rise_row(sizes) + n, lane] = NEVER
    sift(sizes, first, rows, runs, queue, plan, lane, 0.0)
    pass_over(sizes, first, rows, lane)
    for n in range(sizes.events):
        again = again or (plan.acts[n, ACTION] >= LOCKS and fired(sizes, first, rows, lane, n))
    note(sizes, first, rows, runs, queue, lane, t)
    rows[own + CHANGED, lane] = 1.0 if again else 0.0
    rows[own + STALE, lane], rows[own + SEEN, lane] = 1.0, -1.0
    forget_past_of(lane, rows, first, sizes)
    rows[first.clock + layout.MEMORY, lane] = 0.0
    if t - rows[own + RECENT, lane] > WINDOW * end:
        rows[own + RECENT, lane], rows[own + MANY, lane] = t, 0.0
    rows[own + MANY, lane] += 1.0
    if rows[own + MANY, lane] > MOST:
        rows[own + STATUS, lane] = codes.CHATTERING
    for n in range(sizes.events):
        if plan.stops[n] != 0 and rows[first.conditions + 2 * count + n, lane] == t:
            rows[own + STATUS, lane] = codes.STOPPED
