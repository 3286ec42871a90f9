"""What a change does to each lane, to the trails of runs that have one."""

from lienumba.compiler.routines.marks import apart
from lienumba.compiler.rows import W
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.acting import fired
from lienumba.integrators.drivers.lane_queue import ChunkRuns, Queue
from lienumba.integrators.drivers.trail import CAUSES, GOES_ON, KICKS, note, note_impulses
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import CHANGED, PICKED, T


@apart
def note_of_lane(context: Context, runs: ChunkRuns, queue: Queue, lane: int, kind: int, what: float) -> None:
    """Note what was done in a lane: see `trail`."""
    if runs.trail.entries.shape[1] > 0:
        run, t = queue.block[lane] * W + queue.lane[lane], context.rows[context.first.lanes + T, lane]
        note(runs.trail, run, context.rows, lane, context.first.state, kind, t, what, 0.0)


@apart
def note_causes(context: Context, runs: ChunkRuns, queue: Queue) -> None:
    """Note the conditions that have become true."""
    for lane in range(W if runs.trail.entries.shape[1] > 0 else 0):
        for n in range(layout.conditions(context.sizes)):
            changed = context.rows[context.first.lanes + CHANGED, lane] != 0.0
            if changed and fired(context.sizes, context.first, context.rows, lane, n):
                note_of_lane(context, runs, queue, lane, CAUSES, float(n))


@apart
def note_kicks(context: Context, runs: ChunkRuns, queue: Queue, halts: float) -> None:
    """Note the impulses of lanes that are PICKED; halts: 1 where they only bring to rest what hardly moves, else 0."""
    impulses = context.first.change + layout.change_impulses(context.sizes)
    for lane in range(W if runs.trail.entries.shape[1] > 0 else 0):
        if context.rows[context.first.lanes + PICKED, lane] != 0.0:
            note_of_lane(context, runs, queue, lane, KICKS, halts)
            run = queue.block[lane] * W + queue.lane[lane]
            note_impulses(runs.trail, run, context.rows, lane, impulses, context.sizes.switched)


@apart
def note_modes(context: Context, runs: ChunkRuns, queue: Queue) -> None:
    """Note how lanes that have CHANGED go on."""
    for lane in range(W if runs.trail.entries.shape[1] > 0 else 0):
        if context.rows[context.first.lanes + CHANGED, lane] != 0.0:
            note_of_lane(context, runs, queue, lane, GOES_ON, 0.0)
