"""The kernels of generalised-alpha steps (`lienumba.integrators.methods.generalized_alpha`).

guess      state, iterate -> iterate            what the step before has found
newton     state, iterate -> iterate, change, whether it is regular     one iteration of Newton's method
step       state, iterate -> state, slopes, code, margin              the end, and what the continuous extension reads

An iterate has the accelerations, the rates of laws' states and the multipliers at the end of a step, and eta, which
holds positions (`alpha_system`); projections find what rounding leaves over.
What is carried on: the length of the last step, the rates (v', those of laws' states, the power) at its end, and the
algorithmic ones, all in the coordinates of the chart. Where there is no last step, F at the start says the rates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import count
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.loops.composite import Composite
from lienumba.compiler.loops.elimination import EliminatingKernel
from lienumba.compiler.symbols import Graph
from lienumba.integrators import layout
from lienumba.integrators.codes import finite, verdict
from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import Coordinates
from lienumba.integrators.methods.generalized_alpha import Weights, weights
from lienumba.integrators.tracing.implicit import alpha_system, stage_system
from lienumba.integrators.tracing.implicit.stage_system import Blocks
from lienumba.integrators.tracing.linear.equations import Equations, More
from lienumba.integrators.tracing.step_kernels import Reports, augmented_after
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, where

SWEEPS = 3  # of charts in which rates depend on the place


def rows_of(tracer: Tracer) -> int:
    """Of an iterate."""
    return sum(stage_system.unknowns(tracer)) + len(alpha_system.holding(tracer))


def kernels(tracer: Tracer) -> dict[str, Kernel | Composite]:
    """All of them; `tracer.sizes` has the rows of an iterate."""
    equations = Equations.of(tracer, More())
    return {"guess": _guess(tracer), "newton": _newton(tracer, equations), "step": _step(tracer, equations)}


@dataclass(frozen=True)
class _Step:
    """On symbols."""

    tracer: Tracer
    equations: Equations
    graph: Graph
    model: Model

    @staticmethod
    def of(tracer: Tracer, equations: Equations) -> "_Step":
        return _Step(tracer, equations, *tracer.graph())

    def clock(self, row: int) -> Any:
        return self.graph.input("clock", row)

    @property
    def h(self) -> Any:
        return self.clock(layout.LENGTH)

    @property
    def end(self) -> Any:
        return self.clock(layout.TIME) + self.h

    @cached_property
    def state(self) -> Any:
        return self.tracer.state(self.graph, "state")

    @cached_property
    def augmented(self) -> Any:
        return self.tracer.augmented_rows(self.graph)

    @cached_property
    def unknown(self) -> list[list[Any]]:
        """Accelerations, the rates of laws' states, multipliers of the rows in use, and eta."""
        return iterate(self.tracer, self.graph)

    @cached_property
    def G(self) -> alpha_system.Columns:
        """How eta moves places."""
        n, _, count = stage_system.unknowns(self.tracer)
        only = self.equations.only(("mu",))
        rows = [*flat(self.state), *self.augmented]
        t, parameter = self.clock(layout.TIME), partial(self.graph.input, "parameters")
        within = self.clock(layout.MIDDLE)
        start = only.at(rows, t, [0.0] * n, [0.0] * count, parameter, within=within)
        return alpha_system.columns(start, alpha_system.holding(self.tracer))

    @cached_property
    def history(self) -> tuple[Any, list[Any], list[Any]]:
        """The last length; the rates, and the algorithmic ones, at the start."""
        sizes, augmented = self.tracer.sizes, self.tracer.augmented
        last, *rows = self.augmented[augmented.first_history : augmented.first_mask]
        count = len(rows) // 2
        known = last > 0.0
        slopes = [self.graph.inputs("extra", self.tracer.chart.size, layout.slope_row(sizes, i, 0))
                  for i in range(self.tracer.elements)]  # fmt: skip
        _, velocities, laws = self.tracer.apart(slopes)
        at_start = [*velocities, *laws]
        if augmented.work:
            at_start.append(self.graph.input("extra", layout.report_row(sizes, 0) + layout.POWER))
        rates, algorithmic = (
            [where(known, x, y) for x, y in zip(own, at_start, strict=True)] for own in (rows[:count], rows[count:])
        )
        return last, rates, algorithmic

    @cached_property
    def weights(self) -> Weights:
        rho = self.tracer.method.rho
        assert rho is not None
        return weights(rho, self.history[0] / self.h)

    def mixed(self, own: Sequence[Any], rates: Sequence[Any]) -> list[Any]:
        """Of the rates at the start, the algorithmic ones, and these at the end."""
        _, start, algorithmic = self.history
        x, y, z = own
        return [x * a + y * b + z * c for a, b, c in zip(start, algorithmic, rates, strict=False)]

    @cached_property
    def ends(self) -> tuple[list[Coordinates], list[Any], list[Coordinates], list[Any]]:
        """The coordinates of the end, its elements, the slopes there, and the rates of velocities and laws' states."""
        tracer, chart = self.tracer, self.tracer.chart_of(self.model)
        a, laws, _, eta = self.unknown
        zero = munthe_kaas.origin(tracer.chart)
        u: list[Coordinates] = [zero] * tracer.elements
        velocity: list[Number] = []
        for sweep in range(1 if chart.plain else SWEEPS):
            at = list(self.state) if sweep == 0 else [chart.moved(x, z) for x, z in zip(self.state, u, strict=True)]
            F = tracer.field(self.model, at, a, laws)
            slopes = [chart.slope(*each) for each in zip(self.state, u, at, F, strict=True)]
            places, velocities, own = tracer.apart(slopes)
            velocity = velocity or places  # at the start
            rates = [*velocities, *own]
            n = len(places)
            dq, dv = self.mixed(self.weights.dq, rates[:n]), self.mixed(self.weights.dv, rates)
            moved = _shifted(self.G, [self.h * (v + self.h * x) for v, x in zip(velocity, dq, strict=True)], eta)
            changed = [self.h * x for x in dv]
            u = tracer.gathered(moved, changed[:n], changed[n:])
        at = [chart.moved(x, z) for x, z in zip(self.state, u, strict=True)]
        F = tracer.field(self.model, at, a, laws)
        slopes = [chart.slope(*each) for each in zip(self.state, u, at, F, strict=True)]
        _, velocities, own = tracer.apart(slopes)
        return u, at, slopes, [*velocities, *own]

    @property
    def mask(self) -> list[Number]:
        return self.tracer.mask(self.augmented)


def iterate(tracer: Tracer, graph: Graph) -> list[list[Any]]:
    """Its parts."""
    row, found = layout.iterate_row(tracer.sizes), []
    for size in (*stage_system.unknowns(tracer), len(alpha_system.holding(tracer))):
        found.append(list(graph.inputs("extra", size, row)))
        row += size
    return found


def _guess(tracer: Tracer) -> Kernel:
    graph, _ = tracer.graph()
    sizes, following = tracer.sizes, layout.following_row(tracer.sizes)
    known = graph.input("extra", layout.iterate_row(sizes) + sizes.iterate + layout.SPAN) > 0.0
    rows = [where(known, x, 0.0) for own in iterate(tracer, graph) for x in own]
    return tracer.kernel("guess", rows, range(following, following + len(rows)))


def _newton(tracer: Tracer, equations: Equations) -> Kernel | EliminatingKernel:
    """An iteration. Of a large system the part that writes the matrix hands G to the one that reads the solution."""
    step = _Step.of(tracer, equations)
    a, _, mu, _ = step.unknown
    _, at, _, _ = step.ends
    linear = equations.at(
        [*flat(at), *step.augmented], step.end, a, mu, lambda row: step.graph.input("parameters", row),
        within=step.clock(layout.MIDDLE),
    )  # fmt: skip
    weights, first = (step.weights.dq[2], step.weights.dv[2]), layout.following_row(tracer.sizes)
    system = alpha_system.system(tracer, linear, step.G, weights, step.h, step.mask, step.unknown)
    blocks = Blocks.of_rows(system.rows, system.order, layout.factors_row(tracer.sizes))
    if blocks is None:
        rows = _improved(step, stage_system.Factors.of(system.rows, system.order).solved(system.right), step.G)
        return tracer.kernel("newton", rows, range(first, first + len(rows)))
    matrix, end = (
        [*zip(blocks.vector, system.right, strict=True), *blocks.entries(system.rows)],
        _Step.of(tracer, equations),
    )
    behind, G = count(blocks.first + blocks.elimination.memory), alpha_system.Columns()
    for e, own in step.G.items():
        places = dict(zip(own, behind, strict=False))
        matrix += [(row, own[q]) for q, row in places.items()]
        G[e] = {q: end.graph.input("extra", row) for q, row in places.items()}
    found = _improved(end, [end.graph.input("extra", row) for row in blocks.vector], G)
    memory = next(behind) - blocks.first
    tracer.sizes = tracer.sizes._replace(factors=memory)
    return EliminatingKernel(
        "newton", blocks.elimination, blocks.first, {"matrix": matrix, "end": [*enumerate(found, first)]}
    )


def _improved(step: _Step, solution: Sequence[Any], G: alpha_system.Columns) -> list[Any]:
    """The iterate after these changes, the size of these, and whether it is numbers."""
    tracer, change = step.tracer, alpha_system.apart(step.tracer, solution)
    places, velocities = step.weights.dq[2], step.weights.dv[2]
    n = len(change[0])
    moved = [step.h * velocities * x for own in change[:2] for x in own]
    shifted = _shifted(G, [step.h * step.h * places * x for x in change[0]], change[3])
    estimates = [[z] for z in tracer.gathered(shifted, moved[:n], moved[n:])]
    size = tracer.error_square(step.graph, step.model, estimates, step.state, step.state)
    new = [x + dx for own, more in zip(step.unknown, change, strict=True) for x, dx in zip(own, more, strict=True)]
    return [*new, size, where(finite(new), 1.0, 0.0)]


def _shifted(G: alpha_system.Columns, places: list[Any], eta: Sequence[Any]) -> list[Any]:
    """These places, moved by eta."""
    for own, x in zip(G.values(), eta, strict=True):
        for row, c in own.items():
            places[row] = places[row] + c * x
    return places


def _step(tracer: Tracer, equations: Equations) -> Kernel:
    step = _Step.of(tracer, equations)
    chart, sizes, h = tracer.chart_of(step.model), tracer.sizes, step.h
    u, at, slopes, rates = step.ends
    a, laws, multipliers, _ = step.unknown
    new = [chart.settled(x) for x in at]
    now = tracer.posture(step.model, new, step.augmented, step.end).now
    margin = step.graph.input("extra", layout.report_row(sizes, 0) + layout.STAGE_MARGIN)
    reports = Reports(margin=[margin], accelerations=tracer.carried(step.model, new, a))
    if tracer.augmented.work:
        mu: list[Number] = [0.0] * tracer.structure.rows
        for row, m in zip(tracer.used, multipliers, strict=True):
            mu[row] = m
        posture = tracer.posture(step.model, at, step.augmented, step.end, step.clock(layout.MIDDLE))
        every = tracer.reactions(step.model, posture, step.mask, mu)
        rates = [*rates, dynamics.power(step.model, posture.now, every)]
        reports.power = [step.history[1][-1], step.mixed(step.weights.dv, rates)[-1], rates[-1]]
    reports.history = [h, *rates, *step.mixed(step.weights.a, rates)]
    after = augmented_after(tracer, step.model, step.augmented, now, h, reports)
    rotation: Number = 0.0
    square: Number = 0.0
    for z in u:
        rotation = maximum(chart.rotation(z), rotation)
        for c in z:
            square = square + c * c
    outputs = [*flat(new), *after, verdict(tracer.strict(rotation), square, 1.0, 1.0)]
    outputs += [margin] if tracer.augmented.masks else []
    rows, behind = list(range(len(outputs))), layout.first_slope(sizes)
    zero = munthe_kaas.origin(tracer.chart)
    F = tracer.field(step.model, step.state, a, laws)  # whose places alone are those of the start
    own = [chart.slope(x, zero, x, f) for x, f in zip(step.state, F, strict=True)]
    places, n = tracer.apart(own)[0], tracer.velocities
    at_start = step.history[1]
    start = tracer.gathered(places, at_start[:n], at_start[n : n + len(laws)])
    for s, kept in enumerate((start, [munthe_kaas.weighted([1.0 / h], [z]) for z in u], slopes)):
        for i in range(tracer.elements):
            outputs += kept[i]
            rows += [behind + layout.slope_row(sizes, i, s) + c for c in range(sizes.coordinates)]
        if tracer.augmented.work:
            outputs.append(reports.power[s])
            rows.append(behind + layout.report_row(sizes, s) + layout.POWER)
    return tracer.kernel("step", outputs, rows)
