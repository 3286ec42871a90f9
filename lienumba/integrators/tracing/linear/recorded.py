"""The memo of recorded equations: those of one structure are recorded and differentiated once in a process, whatever
numbers it has; so are the parts of them that are looked at alone, and the functions that their tapes become."""

from lienumba.compiler.memo import Memo, content
from lienumba.integrators.tracing.compiled import key_of
from lienumba.integrators.tracing.linear.equations import Equations, More
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.keys.registry import Registry

RECORDED: Memo[Equations] = Memo(4)  # kept in a process, those used last; a large one takes tens of MiB


def recorded(tracer: FreedomTracer, more: More) -> Equations:
    """The equations of a mechanism; more: what is differentiated beside them, which is data."""
    key = key_of(tracer.template, tracer.method, UNIQUE, False)
    if key is None:
        return Equations.of(tracer, more)
    return RECORDED.get((Registry.changes, type(tracer), key, content(more)), lambda: Equations.of(tracer, more))
