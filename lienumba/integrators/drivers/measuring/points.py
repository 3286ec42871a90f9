"""Signals at seven nodes of a subinterval of the current step: Lobatto's five points, and two between them.

The polynomial of degree 4 through Lobatto's points stands for a signal there; at the other two nodes it is tested.
"""

from typing import NamedTuple

from lienumba.compiler.lanes import Address, Lanes, Mask, all_lanes, any_lane, call, choose, load, splat, store
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers import stages
from lienumba.integrators.drivers.dense_output import between
from lienumba.integrators.drivers.events.roots import finest_fraction
from lienumba.integrators.drivers.lobatto import missed, point, through
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import ELSEWHERE, KEPT_ROWS, LARGEST_SIZES, NODES, UNTIL, Workspace
from lienumba.numerics.operations import absolute, maximum

INTERPOLATION_RTOL = 0.002  # of the spread of a signal: its interpolant shows where extremes and zeros are, no more
ROUNDOFF_RTOL = 2.0**-40  # of the largest size of a signal: what differs by less is roundoff
NODE_MARGIN = 2.0**10  # of the finest part of a step: so far from a breakpoint a jump is seen from its own side
LEANING = 2.0**-20  # of a step: so near to its ends jumps there are seen from the inside


class Subinterval(NamedTuple):
    """A part of the current step.

    t, length: where the step begins, and how long it is (s); low, high: the ends of the part as fractions of the step;
    nodes: which set of nodes has its signals, 0 for that of the whole step, which all records share, or 1.
    """

    t: Lanes
    length: Lanes
    low: Lanes
    high: Lanes
    nodes: int


class Record(NamedTuple):
    """A row of `Plan.kept`: what is recorded, of which signal, under which condition, the event with the same one, and
    the guards; rows: the address of `layout.KEPT_VALUE` and what follows."""

    kind: int
    signal: int
    condition: int
    event: int
    guard: int
    guards: int
    rows: Address


@inlined
def nth_record(context: Context, n: int) -> Record:
    """The nth record of all runs."""
    kept, rows = context.plan.kept, context.at.measures + ROW * KEPT_ROWS * n
    return Record(kept[n, 0], kept[n, 1], kept[n, 2], kept[n, 3], kept[n, 4], kept[n, 5], rows)


@inlined
def without(lanes: Mask, others: Mask) -> Mask:
    return lanes & (choose(others, splat(1.0), splat(0.0)) == 0.0)


@inlined
def put(rows: Address, row: int, lanes: Mask, value: Lanes) -> None:
    """Write a row in these lanes."""
    store(rows, row, choose(lanes, value, load(rows, row)))


@inlined
def time_of(at: Workspace, part: Subinterval, fraction: Lanes) -> Lanes:
    return choose(fraction == 1.0, load(at.lanes, UNTIL), part.t + fraction * part.length)


@inlined
def node(k: int) -> float:
    """The place of a node between 0 and 1."""
    if k == 1:
        return 0.5 * point(1)
    if k == 4:
        return 0.5 * (point(2) + point(3))
    return point(k - 1 if k > 1 else 0) if k < 4 else point(k - 2)


@inlined
def fraction_of_node(context: Context, k: int, part: Subinterval) -> Lanes:
    """The place of a node in the step. The first and the last one lie inside of a subinterval by more than breakpoints
    are known to, unless it is shorter than that or ends with the step."""
    if 0 < k < NODES - 1:
        return part.low + node(k) * (part.high - part.low)
    beside, end = NODE_MARGIN * finest_fraction(context), part.low if k == 0 else part.high
    within = (end > 0.0) & (end < 1.0) & (part.high - part.low > 4.0 * beside)
    return choose(within, end + beside if k == 0 else end - beside, end)


@inlined
def signals(context: Context, row: int) -> Address:
    """Where the values of all signals begin: of one of both sets of nodes, or one of the rows behind these."""
    return context.at.measures + ROW * layout.signal_row(context.sizes, row)


@inlined
def value_at(context: Context, part: Subinterval, signal: int, k: int) -> Lanes:
    """A signal in a node."""
    return load(signals(context, NODES * part.nodes + k), signal)


@apart
def evaluate(context: Context, part: Subinterval, fraction: Lanes, to: Address) -> None:
    """Evaluate all signals at a fraction of the current step; at its ends the states there count."""
    at, rows = context.at, layout.state_rows(context.sizes)
    edge = choose(fraction == 0.0, -1.0, choose(fraction == 1.0, splat(1.0), 0.0))
    state = at.now
    if all_lanes(edge == -1.0):
        state = at.state
    elif all_lanes(edge == 1.0):
        state = at.new
    else:
        store(at.clock, layout.TIME, part.t)
        between(context.kernels, at, fraction)
        if any_lane(edge != 0.0):
            stages.commit(edge == -1.0, at.now, at.state, rows)
            stages.commit(edge == 1.0, at.now, at.new, rows)
    store(at.clock, layout.TIME, time_of(at, part, fraction))
    if context.sizes.leaping > 0:
        side = choose(fraction < LEANING, splat(-1.0), choose(fraction > 1.0 - LEANING, splat(1.0), 0.0))
        store(at.clock, layout.LEAN, -LEANING * side * part.length)
    call(context.kernels[layout.MEASURE], state, at.parameters, at.clock, 0, to, at.work)
    store(at.clock, layout.LEAN, splat(0.0))


@inlined
def value_elsewhere(context: Context, part: Subinterval, signal: int, place: Lanes) -> Lanes:
    """A signal at a place between 0 and 1 in a subinterval."""
    evaluate(context, part, part.low + place * (part.high - part.low), signals(context, ELSEWHERE))
    return load(signals(context, ELSEWHERE), signal)


@apart
def sample(context: Context, part: Subinterval) -> None:
    """Evaluate all signals in all nodes of a subinterval."""
    for k in range(NODES):
        evaluate(context, part, fraction_of_node(context, k, part), signals(context, NODES * part.nodes + k))


@inlined
def lobatto_values(context: Context, part: Subinterval, signal: int) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
    """A signal in Lobatto's five points."""
    return (
        value_at(context, part, signal, 0), value_at(context, part, signal, 2), value_at(context, part, signal, 3),
        value_at(context, part, signal, 5), value_at(context, part, signal, 6),
    )  # fmt: skip


@inlined
def interpolant(
    context: Context, part: Subinterval, signal: int, sign: float
) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
    """The polynomial of degree 4 through a signal times a sign: its value in the middle, and the coefficients of s,
    s^2, s^3, s^4 for s from -1 to 1."""
    a, b, c, d, e = lobatto_values(context, part, signal)
    o, p, q, r = through(sign * a, sign * b, sign * c, sign * d, sign * e)
    return sign * c, o, p, q, r


@apart
def interpolation_error(context: Context, part: Subinterval, signal: int) -> tuple[Lanes, Lanes, Lanes]:
    """The largest error of the interpolant in the nodes beside Lobatto's, the spread of a signal over all nodes, and
    its largest size there. Where it is undefined in some nodes, but not in all, the error is infinite."""
    a, b, c, d, e = lobatto_values(context, part, signal)
    first, least, most = missed(node(1), a, b, c, d, e, value_at(context, part, signal, 1))
    second, lower, upper = missed(node(4), a, b, c, d, e, value_at(context, part, signal, 4))
    least, most = choose(lower < least, lower, least), maximum(upper, most)
    defined = splat(0.0)
    for k in range(NODES):
        x = value_at(context, part, signal, k)
        defined = defined + choose(x == x, splat(1.0), 0.0)
    error = choose((defined > 0.0) & (defined < float(NODES)), splat(1e300), maximum(first, second))
    return error, most - least, maximum(absolute(most), absolute(least))


@apart
def needs_refinement(context: Context, part: Subinterval, signal: int) -> Mask:
    """Where the interpolant of a signal does not show its course, by more than roundoff."""
    error, spread, size = interpolation_error(context, part, signal)
    roundoff = ROUNDOFF_RTOL * maximum(load(signals(context, LARGEST_SIZES), signal), size)
    return error > maximum(INTERPOLATION_RTOL * spread, roundoff)
