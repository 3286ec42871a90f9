"""What a change has done, to the records of its run: events, impacts, other modes."""

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import codes
from lienumba.integrators.drivers.events.acting import fired, turns
from lienumba.integrators.drivers.events.tolerances import CONTACT_ROUNDOFF
from lienumba.integrators.drivers.lane_queue import ChunkRuns, Queue
from lienumba.integrators.drivers.switching import impacts
from lienumba.integrators.drivers.switching.reactions import Reactions
from lienumba.integrators.drivers.workspace import Plan, Rows
from lienumba.integrators.layout import (
    ACTION,
    ENGAGES,
    GAINED,
    LOCKS,
    RECORDS,
    RELEASES,
    SETS,
    SWITCH_FIRST,
    SWITCH_KIND,
    TARGET,
    TARGETS,
    UNILATERAL,
    T,
    Workspace,
)  # fmt: skip
from lienumba.integrators.sizes import Sizes


@apart
def record_change(
    rows: Rows, first: Workspace, runs: ChunkRuns, queue: Queue, lane: int, kind: int, what: int, impulse: float,
    energy: float,
) -> None:  # fmt: skip
    """A change, to the books."""
    block, place = queue.block[lane], queue.lane[lane]
    n = int(runs.change_counts[block, place])
    if n < runs.changes.shape[1]:
        told = runs.changes[block, n]
        told[0, place], told[1, place], told[2, place] = rows[first.lanes + T, lane], float(kind), float(what)
        told[3, place], told[4, place] = impulse, energy
    runs.change_counts[block, place] += 1.0
    runs.energy_lost[block, place] += energy


@inlined
def _is_recorded(sizes: Sizes, first: Workspace, rows: Rows, plan: Plan, lane: int, event: int, switch: int) -> bool:
    """Whether an event before this one in the file has turned the same on now: its impulse is told once."""
    told = False
    for other in range(event):
        told = told or (fired(sizes, first, rows, lane, other) and turns(plan, other, switch) > 0.0)
    return told


@apart
def record_events(
    r: Reactions, sizes: Sizes, first: Workspace, rows: Rows, runs: ChunkRuns, queue: Queue, plan: Plan, lane: int
) -> None:
    """What events have done in a lane, and impacts, to the books."""
    for event in range(sizes.events):
        action, impulse, energy = plan.acts[event, ACTION], 0.0, 0.0
        only_time = action == SETS and plan.acts[event, TARGETS] == 0
        if action != RECORDS and not only_time and fired(sizes, first, rows, lane, event):
            tells = codes.RELEASED if action == RELEASES else codes.SET
            if action == ENGAGES:
                energy, rows[first.lanes + GAINED, lane] = -rows[first.lanes + GAINED, lane], 0.0
            if LOCKS <= action <= ENGAGES:
                tells = codes.LOCKED if action == LOCKS else codes.ENGAGED
                for n in range(plan.acts[event, TARGET], plan.acts[event, TARGET] + plan.acts[event, TARGETS]):
                    if not _is_recorded(sizes, first, rows, plan, lane, event, plan.targets[n]):
                        impulse += impacts.impulse(r, plan.targets[n])
                        energy += impacts.energy_lost(r, plan.targets[n])
            record_change(rows, first, runs, queue, lane, tells, event, impulse, energy)
    p, largest = r.problem, 0.0
    for i in range(sizes.switched):
        largest = max(largest, max(p.x[i], -p.x[i]))
    for s in range(sizes.switches):
        hit = p.switches[s, SWITCH_KIND] == UNILATERAL and p.x[p.switches[s, SWITCH_FIRST]] > CONTACT_ROUNDOFF * largest
        if hit:  # and not by rounding, where something else is
            impulse, energy = impacts.impulse(r, s), impacts.energy_lost(r, s)
            record_change(rows, first, runs, queue, lane, codes.IMPACT, s, impulse, energy)
