"""The kernels of free lanes beyond a step: what its error is, and the state between its ends.

close      state, new state and slopes behind it -> F at the end about x, the error, the factors of the controller
dense      state, slopes -> the state at a fraction of the step, on the continuous extension
"""

from collections.abc import Sequence
from typing import Any, cast

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.methods import munthe_kaas, step_control
from lienumba.integrators.methods.charts import Exponential
from lienumba.integrators.tracing.law_states import RATES, SLOTS
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.numerics.operations import maximum, where


def close(tracer: Tracer) -> Kernel:
    graph, _ = tracer.graph()
    h, tableau, behind = graph.input("clock", codes.LENGTH), tracer.tableau, tracer.state_rows
    estimates = []
    for i in range(tracer.elements):
        slopes = _slopes(tracer, graph, i, behind)[: tracer.stages]
        if any(len(row) > tracer.stages for row in tableau.errors):
            slopes.append(_end(tracer, graph, i, behind))
        estimates.append([munthe_kaas.weighted(munthe_kaas.scaled(h, row), slopes) for row in tableau.errors])
    new = [graph.inputs("extra", ELEMENT, ELEMENT * i) for i in range(tracer.elements)]
    square = _error_square(tracer, graph, estimates, tracer.state(graph, "state"), new)
    said = (square, *step_control.factors(square, graph.input("clock", codes.MEMORY), tableau.order))
    return tracer.kernel("close", said)


def end(tracer: Tracer) -> Kernel:
    graph, _ = tracer.graph()
    every = range(tracer.elements)
    rows = [tracer.slope_row(i, tracer.stages) + c for i in every for c in range(tracer.chart.size)]
    return tracer.kernel("end", flat(_end(tracer, graph, i, 0) for i in every), tuple(rows))


def _end(tracer: Tracer, graph: Graph, element: int, behind: int) -> Any:
    """The slope at the end of the step, about its start."""
    h, slopes = graph.input("clock", codes.LENGTH), _slopes(tracer, graph, element, behind)
    u, _ = munthe_kaas.combination(tracer.chart, h, (tracer.tableau.b,), slopes[: tracer.stages])
    last = behind + tracer.slope_row(element, tracer.slots - 1)
    return cast(Exponential, tracer.chart).back(u, graph.inputs("extra", tracer.chart.size, last))


def dense(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    t, h = graph.inputs("clock", 2)
    fraction = graph.input("clock", codes.FRACTION)
    weights = [h * w for w in tracer.tableau.extension(fraction, float)]
    x, held = tracer.state(graph, "state"), tracer.held_rows(graph)
    moved = []
    for i, body in enumerate(x):
        u = munthe_kaas.weighted(weights, _slopes(tracer, graph, i, 0))
        tracer.chart.rotation(u)
        moved.append(tracer.chart.moved(body, u))
    after = list(held)
    after[: len(tracer.held.angles)] = tracer.held.counted(model, tracer.instant(moved, held, t + fraction * h))
    if tracer.held.work:
        slots = [*range(tracer.stages), tracer.slots - 1, *range(tracer.stages + 1, tracer.slots - 1)]
        power = [(graph.input("extra", tracer.slope_row(tracer.elements, s) + 1),) for s in slots]
        place = len(tracer.held.angles)
        after[place] = after[place] + munthe_kaas.weighted(weights, power)[0]
    return tracer.kernel("dense", (*flat(moved), *after))


def _slopes(tracer: Tracer, graph: Graph, element: int, behind: int) -> list[Any]:
    """Of all stages; behind: the rows before them."""
    slots = range(tracer.slots - 1)
    return [graph.inputs("extra", tracer.chart.size, behind + tracer.slope_row(element, s)) for s in slots]


def _error_square(tracer: Tracer, graph: Graph, estimates: list[Any], x: Sequence[Any], y: Sequence[Any]) -> Any:
    """Of all elements the worst; infinite if one is not finite."""
    tolerance = graph.inputs("clock", len(step_control.Tolerance.__dataclass_fields__), codes.TOLERANCE)
    squares = [
        step_control.error_square(z, a, b, tolerance) for z, a, b in zip(estimates[: tracer.k], x, y, strict=False)
    ]
    for z, a, b in zip(estimates[tracer.k :], x[tracer.k :], y[tracer.k :], strict=True):
        for rate, slot in zip(RATES, SLOTS, strict=True):
            squares.append(step_control.state_error_square([e[rate] for e in z], a[slot], b[slot], tolerance))
    worst, total = squares[0], squares[0]
    for square in squares[1:]:
        worst, total = maximum(square, worst), total + square
    return where(total < codes.HUGE, worst, codes.HUGE)
