"""Subdivide a step for one record, until neither its value nor its condition has a kink or crosses zero in a part.

A subinterval is halved where an interpolant does not show the course of a signal, and ends directly before the first
breakpoint. Where many refinements in a row find no such part, the signal is noise, and taken as it is sampled.
"""

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.roots import finest_fraction
from lienumba.integrators.drivers.lane_queue import NEVER
from lienumba.integrators.drivers.measuring.breakpoints import NOWHERE, first_breakpoint, guards_need_refinement
from lienumba.integrators.drivers.measuring.integrals import quadrature_needs_refinement
from lienumba.integrators.drivers.measuring.points import (
    Record,
    Subinterval,
    needs_refinement,
    put,
    sample,
    signals,
    without,
)
from lienumba.integrators.drivers.measuring.records import add
from lienumba.integrators.drivers.workspace import Context
from lienumba.numerics.operations import HOLDS, maximum, minimum

SMALLEST_PART = 2.0**-16  # of a step: so far a kink of which no formula tells is enclosed
MAX_REFINEMENTS = 20  # more than smooth subintervals that were recorded: behind that a signal is noise
MAX_SUBINTERVALS = 4096  # of a step; behind that the record is undefined


@apart
def _value_needs_refinement(context: Context, record: Record, part: Subinterval) -> Mask:
    """Where what is recorded of a value would be wrong, which has no breakpoint in a subinterval."""
    if record.kind == layout.INTEGRATES and record.signal >= 0:
        return quadrature_needs_refinement(context, record, part)
    if record.kind <= layout.SMALLEST:
        return needs_refinement(context, part, record.signal)
    return splat(0.0) > 0.0


@inlined
def _left(refinements: Lanes, used: Mask, smooth: Mask) -> Lanes:
    """How many refinements are left: one less where one was used, one more behind a smooth subinterval, and none from
    then on where all have been used."""
    more = choose(smooth & (refinements > 0.0), minimum(refinements + 1.0, splat(float(MAX_REFINEMENTS))), refinements)
    return choose(used, refinements - 1.0, more)


@apart
def record_step(context: Context, record: Record, step: Subinterval, lanes: Mask) -> None:
    """Add a step, whose nodes have been sampled, to a record: march from subinterval to subinterval, in each lane by
    itself. One is halved, cut at a breakpoint, or done, and then the next one begins."""
    finest, whole, left = finest_fraction(context), step.high, lanes
    low, high, width, after = splat(0.0), whole, whole, splat(NOWHERE)  # after: where the next subinterval begins
    part, halvings, cuts = step, splat(float(MAX_REFINEMENTS)), splat(float(MAX_REFINEMENTS))
    for count in range(MAX_SUBINTERVALS):
        if count > 0:
            part = Subinterval(step.t, step.length, low, high, 1)
            sample(context, part)
        ends_at_cut = (after != high) & (after <= whole)
        rough = guards_need_refinement(context, record, part)
        divisible = left & (high - low > SMALLEST_PART) & (halvings > 0.0)
        settled, place = without(left, divisible & rough), splat(NOWHERE)
        if any_lane(settled & (cuts > 0.0)):
            place = first_breakpoint(context, record, part, settled & (cuts > 0.0), ends_at_cut)
        cut = settled & (place <= high)
        rough = rough | _value_needs_refinement(context, record, part)
        halved = without(divisible & rough, cut)
        done = without(without(left, cut), halved)
        if any_lane(done):
            add(context, record, part, done)
        smooth = without(done, rough) & (high - low > SMALLEST_PART)
        if record.signal >= 0:
            smooth = without(smooth, needs_refinement(context, part, record.signal))
        halvings, cuts = _left(halvings, halved, smooth), _left(cuts, cut, smooth)
        width = choose(halved, 0.5 * (high - low), choose(without(done, ends_at_cut), 2.0 * width, width))
        left = without(left, done & (after > whole))
        if not any_lane(left):
            return
        low = choose(done & left, after, low)
        end = choose(cut, maximum(place - finest, low), minimum(low + width, whole))
        high = choose(left, end, high)
        after = choose(cut, place, choose(high < whole, high, NOWHERE))
    put(record.rows, layout.KEPT_UNDEFINED, left, splat(1.0))


@apart
def record_event(context: Context, record: Record, step: Subinterval, until: Lanes, lanes: Mask) -> None:
    """Where an event leaves the step that has the condition of a record, this holds there whatever roundoff says: a
    subinterval of no length is added in which it does."""
    if record.event < 0:
        return
    time = load(context.at.conditions, 2 * layout.conditions(context.sizes) + record.event)
    happens = lanes & (time < NEVER) & (time <= until) & (load(record.rows, layout.KEPT_PEAK) == 0.0)
    if any_lane(happens):
        part = Subinterval(step.t, step.length, step.high, step.high, 1)
        sample(context, part)
        for k in range(layout.NODES):
            store(signals(context, layout.NODES + k), record.condition, splat(HOLDS))
        add(context, record, part, happens)
