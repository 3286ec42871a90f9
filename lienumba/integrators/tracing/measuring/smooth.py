"""Which signals neither their formulas nor any force gives a kink or a jump."""

from lienumba.compiler.symbols import Graph, live
from lienumba.integrators import layout
from lienumba.integrators.tracing.observed import observed, reads_observed
from lienumba.integrators.tracing.series_kernels import compared
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism import kinematics


def smooth(tracer: Tracer, wanted: set[int]) -> set[int]:
    """The wanted signals (by their numbers) without kinks and jumps."""
    if not wanted:
        return set()
    graph, model = tracer.graph(Graph(analytic=True))
    posture, mask = tracer.now(graph, model)
    t, every = graph.input("clock", layout.TIME), quantities.signals(model)
    view = kinematics.still(posture.now, tuple(range(len(model.bodies))))
    known = None
    if reads_observed(model, [every[n] for n in wanted]):
        known = observed(tracer, graph, model, posture, mask)[0]
    values = {n: [quantities.evaluate(model, every[n], view, known)] for n in wanted}
    plain = {n for n, x in values.items() if not any(node.op == "gather" for node in live(x))}
    return {n for n in plain if not compared(tracer, graph, model, t, None, values[n])}
