"""The kernels of lanes with a time of their own beyond a step: what its error is, and the state between its ends.

close      state, new state and slopes behind it -> F at the end about x, the error, the factor of the controller
close_along    the same near singular positions: what is across the constraints hardly counts
dense      state, slopes -> the state at a fraction of the step, on the continuous extension
watch      the same -> the conditions there, where no accelerations decide about these
"""

from typing import cast

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import State
from lienumba.integrators import layout
from lienumba.integrators.methods import munthe_kaas, step_control
from lienumba.integrators.methods.charts import Chart, Coordinates, Exponential
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.numerics.number import Number

ACROSS = 1e-3  # of the error of velocities across the constraints: about for how long (s) positions go along with it


def close(tracer: Tracer, along: bool = False) -> Kernel:
    """along: whether what the constraints do not allow hardly counts."""
    graph, model = tracer.graph()
    chart = tracer.chart_of(model)
    h, tableau, behind = graph.input("clock", layout.LENGTH), tracer.tableau, layout.first_slope(tracer.sizes)
    estimates = []
    for i in range(tracer.elements):
        slopes = _slopes(tracer, graph, i, behind)[: tracer.sizes.stages]
        if any(len(row) > tracer.sizes.stages for row in tableau.errors):
            slopes.append(_end(tracer, chart, graph, i, behind))
        estimates.append([munthe_kaas.weighted(munthe_kaas.scaled(h, row), slopes) for row in tableau.errors])
    if along:
        every = [_along(tracer, graph, model, [z[n] for z in estimates]) for n in range(len(tableau.errors))]
        estimates = [list(z) for z in zip(*every, strict=True)]
    square = tracer.error_square(graph, model, estimates, tracer.state(graph, "state"), tracer.state(graph, "extra"))
    if tracer.augmented.work:
        square = step_control.worst([square, work_error_square(tracer, graph, model, behind)])
    said = (square, *step_control.factor(square, graph.input("clock", layout.MEMORY), tableau.estimated))
    return tracer.kernel("close_along" if along else "close", said)


def allowed(tracer: Tracer, graph: Graph, model: Model, v: list[Number]) -> list[Number]:
    """The part of changes of the velocities that the constraints at the end of the step allow."""
    rows = graph.inputs("extra", tracer.augmented.rows, layout.element_rows(tracer.sizes))
    after = tracer.posture(model, tracer.state(graph, "extra"), rows, graph.input("clock", layout.TIME))
    return tracer.allowed(model, after, tracer.mask(rows), v)


def _along(tracer: Tracer, graph: Graph, model: Model, z: list[Coordinates]) -> list[Coordinates]:
    """An error estimate of every element with little of the error of velocities across the constraints."""
    q, v, laws = tracer.apart(z)
    v = [x + ACROSS * (y - x) for x, y in zip(allowed(tracer, graph, model, v), v, strict=True)]
    return tracer.gathered(q, v, laws)


def work_error_square(tracer: Tracer, graph: Graph, model: Model, behind: int) -> Number:
    """The squared error of the work in a step. Prescribed motion is as exact at a kink of a force as elsewhere, so that
    nothing but the power of its driver shows the kink."""
    h, sizes, place = graph.input("clock", layout.LENGTH), tracer.sizes, len(tracer.augmented.angles)
    stages = [*range(sizes.stages), sizes.slopes - 1]
    power = [(graph.input("extra", behind + layout.report_row(sizes, s) + layout.POWER),) for s in stages]
    estimates = tuple(munthe_kaas.weighted(munthe_kaas.scaled(h, row), power)[0] for row in tracer.tableau.errors)
    work, after = (
        graph.inputs(array, tracer.augmented.rows, layout.element_rows(sizes)) for array in ("state", "extra")
    )
    now = tracer.posture(model, tracer.state(graph, "extra"), after, graph.input("clock", layout.TIME)).now
    kinetic = dynamics.energies(model, now)[0]
    tolerance = graph.inputs("clock", layout.TOLERANCES, layout.TOLERANCE)
    return step_control.work_error_square(estimates, work[place], after[place], kinetic, tolerance)


def end(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    chart, every, sizes = tracer.chart_of(model), range(tracer.elements), tracer.sizes
    rows = [layout.slope_row(sizes, i, sizes.stages) + c for i in every for c in range(sizes.coordinates)]
    return tracer.kernel("end", flat(_end(tracer, chart, graph, i, 0) for i in every), rows)


def _end(tracer: Tracer, chart: Chart, graph: Graph, element: int, behind: int) -> Coordinates:
    """The slope at the end of the step, about its start."""
    h, slopes = graph.input("clock", layout.LENGTH), _slopes(tracer, graph, element, behind)
    u, _ = munthe_kaas.combination(chart, h, (tracer.tableau.b,), slopes[: tracer.sizes.stages])
    last = behind + layout.slope_row(tracer.sizes, element, tracer.sizes.slopes - 1)
    return cast(Exponential, chart).back(u, graph.inputs("extra", chart.size, last))


def dense(tracer: Tracer) -> Kernel:
    graph, model = tracer.graph()
    moved, after = _within(tracer, graph, model)
    return tracer.kernel("dense", (*flat(moved), *after))


def watch(tracer: Tracer) -> Kernel:
    """Conditions of events that are no matter of accelerations; those of joints and locks never come true."""
    graph, model = tracer.graph()
    moved, after = _within(tracer, graph, model)
    t, h, fraction = (graph.input("clock", row) for row in (layout.TIME, layout.LENGTH, layout.FRACTION))
    now = tracer.posture(model, moved, tuple(after), t + fraction * h).now
    outputs = [*quantities.conditions(model, now, None), *quantities.condition_rates(model, now, None, {})]
    never, first = layout.conditions(tracer.sizes), layout.rate_row(tracer.sizes)
    outputs[len(model.events) : len(model.events)] = [0.0] * (never - len(model.events))
    rows = [*range(never), *range(first, first + len(model.events))]
    return tracer.kernel("watch", outputs, rows)


def _within(tracer: Tracer, graph: Graph, model: Model) -> tuple[list[State], list[Number]]:
    """The elements at a fraction of the step, and what is augmented."""
    t, h = graph.input("clock", layout.TIME), graph.input("clock", layout.LENGTH)
    sizes = tracer.sizes
    fraction = graph.input("clock", layout.FRACTION)
    weights = [h * w for w in tracer.tableau.extension(fraction, float)]
    x, augmented = tracer.state(graph, "state"), tracer.augmented_rows(graph)
    moved: list[State] = []
    chart = tracer.chart_of(model)
    starts = _starts(tracer, graph, model)
    places = [h * w for w in tracer.tableau.places(fraction, float)]
    for i, body in enumerate(x):
        slopes = _slopes(tracer, graph, i, 0)
        u = list(munthe_kaas.weighted(weights, slopes))
        if i in starts:
            moving = munthe_kaas.weighted(places, [starts[i], *slopes[1:]])
            for n in tracer.coordinates[0]:
                u[n] = moving[n]
        moved.append(chart.moved(body, tuple(u)))
    after = list(augmented)
    after[: len(tracer.augmented.angles)] = tracer.augmented.counted(
        model, tracer.posture(model, moved, augmented, t + fraction * h).now
    )
    if tracer.augmented.work:
        stages = [*range(sizes.stages), sizes.slopes - 1, *range(sizes.stages + 1, sizes.slopes - 1)]
        power = [(graph.input("extra", layout.report_row(sizes, s) + layout.POWER),) for s in stages]
        place = len(tracer.augmented.angles)
        after[place] = after[place] + munthe_kaas.weighted(weights, power)[0]
    return moved, after


def _slopes(tracer: Tracer, graph: Graph, element: int, behind: int) -> list[Coordinates]:
    """The slopes of all stages; behind: the rows before them."""
    every, size = range(tracer.sizes.slopes - 1), tracer.chart.size
    return [graph.inputs("extra", size, behind + layout.slope_row(tracer.sizes, element, s)) for s in every]


def _starts(tracer: Tracer, graph: Graph, model: Model) -> dict[int, Coordinates]:
    """How places change at the start of a step of a method by collocation, whose first stage does not say it: by
    element; accelerations are left out."""
    if not tracer.tableau.begun:
        return {}
    chart, zero, x = tracer.chart_of(model), munthe_kaas.origin(tracer.chart), tracer.state(graph, "state")
    laws = sum(tracer.law_states.sizes.values())
    F = tracer.field(model, x, [0.0] * tracer.velocities, [0.0] * laws)
    slopes = [chart.slope(*each) for each in zip(x, [zero] * len(x), x, F, strict=True)]
    return dict(enumerate(slopes[: tracer.moving_elements]))
