"""The memo of recorded equations. Equations of one structure are recorded and differentiated once per process, for any
numbers; the memo also holds their blocks (`only`) and compiled tapes."""

from lienumba.compiler.memo import Memo, content
from lienumba.integrators.tracing.compiled import key_of
from lienumba.integrators.tracing.linear.equations import Equations, More
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.keys.registry import Registry

RECORDED: Memo[Equations] = Memo(4)  # the equations used last; large ones take tens of MiB


def recorded(tracer: FreedomTracer, more: More) -> Equations:
    """Record the equations of a mechanism, or take them from the memo; more: what is differentiated beside them."""
    key = key_of(tracer.template, tracer.method, UNIQUE, False)
    if key is None:
        return Equations.of(tracer, more)
    return RECORDED.get((Registry.changes, type(tracer), key, content(more)), lambda: Equations.of(tracer, more))
