"""The first breakpoint of a subinterval: where a guard crosses zero, at whose zeros other signals have kinks or jumps.

The condition of a record is a guard of its own. Between nodes of one sign a guard may cross zero twice: where its
interpolant comes near zero, its true extreme decides.
"""

from lienumba.compiler.lanes import Lanes, Mask, any_lane, choose, splat
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.roots import Bracket, find_root
from lienumba.integrators.drivers.measuring.extremes import interior_extreme
from lienumba.integrators.drivers.measuring.points import (
    ROUNDOFF_RTOL,
    Record,
    Subinterval,
    fraction_of_node,
    needs_refinement,
    value_at,
    without,
)
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import NODES
from lienumba.numerics.operations import absolute, minimum

NOWHERE = 2.0  # in the place of a fraction of a step


@inlined
def _side(x: Lanes) -> Lanes:
    """The sign of a number; NaN of what is undefined."""
    return choose(x > 0.0, splat(1.0), choose(x < 0.0, splat(-1.0), 0.0 * x))


@apart
def guards_need_refinement(context: Context, record: Record, part: Subinterval) -> Mask:
    """Where the interpolant of a guard without kinks of its own does not show its course."""
    plan, found = context.plan, splat(0.0)
    for k in range(record.guards):
        guard = plan.guards[record.guard + k]
        if plan.straight[guard] != 0:
            found = choose(needs_refinement(context, part, guard), splat(1.0), found)
    return found > 0.0


@apart
def _zero(
    context: Context, guard: int, begin: Lanes, end: Lanes, before: Lanes, after: Lanes, lanes: Mask
) -> Lanes:  # fmt: skip
    """Directly behind the zero of a guard between two fractions of the step, at which it has these values."""
    place, inside = end, lanes & (absolute(after) > 0.0)
    if any_lane(inside):
        found = find_root(context, layout.MEASURE, guard, Bracket(begin, end, before, after), splat(0.0) > 0.0, inside)
        place = choose(inside, found, place)
    return place


@inlined
def _value(context: Context, part: Subinterval, guard: int, k: int, roundoff: Lanes) -> Lanes:
    """A guard in a node; zero where it is roundoff at an end of the step, whose other side is in the next one."""
    x, end = value_at(context, part, guard, k), splat(0.5)
    if k == 0:
        end = part.low
    elif k == NODES - 1:
        end = part.high
    return choose(((end == 0.0) | (end == 1.0)) & (absolute(x) <= roundoff), splat(0.0), x)


@apart
def _first_crossing(context: Context, part: Subinterval, guard: int, lanes: Mask, ends_at_cut: Mask) -> Lanes:
    """Directly behind the first zero crossing of a guard, NOWHERE without any. Where a subinterval ends directly before
    a crossing that is known, another one there is roundoff."""
    begin, end, before, after = splat(NOWHERE), splat(NOWHERE), splat(0.0), splat(0.0)
    roundoff = ROUNDOFF_RTOL * absolute(value_at(context, part, guard, NODES - 1) - value_at(context, part, guard, 0))
    for gap in range(NODES - 1):
        k = NODES - 2 - gap
        a, b = _value(context, part, guard, k, roundoff), _value(context, part, guard, k + 1, roundoff)
        changes = lanes & (absolute(_side(b) - _side(a)) > 0.0)
        if gap == 0:
            changes = without(changes, ends_at_cut & (absolute(b) <= roundoff))
        begin, before = choose(changes, fraction_of_node(context, k, part), begin), choose(changes, a, before)
        end, after = choose(changes, fraction_of_node(context, k + 1, part), end), choose(changes, b, after)
    same = lanes & (begin == NOWHERE)
    for turn in range(2 if any_lane(same) else 0):
        sign = 1.0 if turn == 0 else -1.0
        x = value_at(context, part, guard, 0)
        place, value = interior_extreme(context, part, guard, sign, splat(0.0), same & (sign * x < 0.0))
        crosses = same & (sign * x < 0.0) & (value > 0.0)
        begin, before = choose(crosses, part.low, begin), choose(crosses, x, before)
        end, after = choose(crosses, place, end), choose(crosses, sign * value, after)
    crosses = lanes & (begin != NOWHERE)
    found = splat(NOWHERE)
    if any_lane(crosses):
        found = choose(crosses, _zero(context, guard, begin, end, before, after, crosses), found)
    return found


@apart
def first_breakpoint(
    context: Context, record: Record, part: Subinterval, lanes: Mask, ends_at_cut: Mask
) -> Lanes:  # fmt: skip
    """Directly behind the first zero crossing of any guard of a record, a fraction of the step; else NOWHERE."""
    place = splat(NOWHERE)
    for k in range(record.guards):
        guard = context.plan.guards[record.guard + k]
        place = minimum(_first_crossing(context, part, guard, lanes, ends_at_cut), place)
    return place
