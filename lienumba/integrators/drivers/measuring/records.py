"""What a subinterval adds to a record, in which neither its value nor its condition has a kink or crosses zero."""

from lienumba.compiler.lanes import Mask, any_lane, choose, load, splat
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.measuring.extremes import record_extreme
from lienumba.integrators.drivers.measuring.integrals import mean
from lienumba.integrators.drivers.measuring.points import Record, Subinterval, put, time_of, value_at
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.hysteresis import settled
from lienumba.integrators.layout import COUNTS, INTEGRATES, KEEPS_FIRST, KEEPS_LAST, KEPT_TIME, KEPT_VALUE, NODES
from lienumba.numerics.operations import absolute, maximum


@inlined
def _where_it_holds(context: Context, record: Record, part: Subinterval, lanes: Mask) -> Mask:
    """Where the condition of a record holds: by its largest value in a node, beside whether it held before. Where it
    is undefined in a node, so is the record, unless the first time is known or the last one ends the subinterval."""
    rows, kind, strongest, defined = record.rows, record.kind, splat(0.0), splat(1.0)
    for k in range(NODES):
        x = value_at(context, part, record.condition, k)
        strongest, defined = choose(absolute(x) > absolute(strongest), x, strongest), choose(x == x, defined, 0.0)
    before, unknown = load(rows, layout.KEPT_PEAK), lanes & (defined == 0.0)
    counts = settled(strongest, before, load(rows, layout.KEPT_SIZE))
    if any_lane(unknown):
        edge = value_at(context, part, record.condition, NODES - 1 if kind == KEEPS_LAST else 0)
        known = choose(edge > 0.0, splat(1.0), 0.0) if KEEPS_FIRST <= kind <= KEEPS_LAST else splat(0.0)
        if kind == KEEPS_FIRST:
            known = choose(load(rows, KEPT_TIME) >= 0.0, splat(1.0), known)
        counts = choose(unknown, edge, counts)
        put(rows, layout.KEPT_UNDEFINED, unknown & (known == 0.0), splat(1.0))
    holds = lanes & (counts > 0.0)
    if kind == COUNTS:
        put(rows, KEPT_VALUE, holds & (before == 0.0), load(rows, KEPT_VALUE) + 1.0)
    put(rows, layout.KEPT_PEAK, lanes, choose(holds, maximum(before, counts), 0.0))
    return holds


@apart
def add(context: Context, record: Record, part: Subinterval, lanes: Mask) -> None:
    """Add a subinterval to a record."""
    rows, kind, signal, holds = record.rows, record.kind, record.signal, lanes
    if record.condition >= 0:
        holds = _where_it_holds(context, record, part, lanes)
    if kind == COUNTS or not any_lane(holds):
        return
    begin, end = time_of(context.at, part, part.low), time_of(context.at, part, part.high)
    value, time = load(rows, KEPT_VALUE), load(rows, KEPT_TIME)
    if kind == INTEGRATES:
        if signal >= 0:
            put(rows, KEPT_VALUE, holds, value + mean(context, part, signal) * (end - begin))
        put(rows, KEPT_TIME, holds, time + (end - begin))
    elif kind == KEEPS_FIRST:
        first = holds & (choose(time >= 0.0, 1.0, 0.0) == 0.0)  # it is NaN as long as there is none
        put(rows, KEPT_TIME, first, begin)
        if signal >= 0:
            put(rows, KEPT_VALUE, first, value_at(context, part, signal, 0))
    elif kind == KEEPS_LAST:
        put(rows, layout.KEPT_UNDEFINED, holds, splat(0.0))
        put(rows, KEPT_TIME, holds, end)
        if signal >= 0:
            put(rows, KEPT_VALUE, holds, value_at(context, part, signal, NODES - 1))
    else:
        record_extreme(context, record, part, -1.0 if kind == layout.SMALLEST else 1.0, holds)
