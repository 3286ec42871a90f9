"""The kernels of implicit steps by collocation.

guess      state, iterate -> iterate            stages on the polynomial of the step before
newton     state, iterate -> iterate, change, whether it is regular     one iteration of Newton's method
step       state, iterate -> state, slopes, code, margin              the end, and what the continuous extension reads
close      state, new state, slopes -> the error, damped, and the factor of the controller

An iterate has of every stage its coordinates u, the accelerations a, the rates of laws' states and the multipliers mu.
Newton's method asks for accelerations and multipliers, such that a bushing of any stiffness is a term of its matrix;
the kinematics u = h A k, which are not stiff, are iterated beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from lienumba.compiler.composite import Composite
from lienumba.compiler.elimination import EliminatingKernel
from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.integrators import layout
from lienumba.integrators.codes import finite, verdict
from lienumba.integrators.methods import munthe_kaas, step_control
from lienumba.integrators.methods.charts import Coordinates
from lienumba.integrators.tracing.extension_kernels import allowed, work_error_square
from lienumba.integrators.tracing.implicit import stage_system
from lienumba.integrators.tracing.implicit.stage_system import LOOPS, Factors, System
from lienumba.integrators.tracing.linear.equations import Equations, Linear
from lienumba.integrators.tracing.step_kernels import Reports, augmented_after
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, maximum, minimum, where

SWEEPS, FIRST_SWEEPS, LAST_SWEEPS = 3, 5, 5  # of the kinematics: in an iteration, before the first, behind the last
PASSING = 0.1  # of the error of steps next to singular positions counts: it is noise, of which shorter ones have more
FARTHEST = 2.0  # how far a polynomial is followed, in lengths of its step

Iterate = tuple[list[list[Any]], list[list[Any]]]  # of every stage u by element, and the unknowns


@dataclass(frozen=True)
class _Stages:
    """A step on symbols. A: of the implicit stages; nodes: c of these."""

    tracer: Tracer
    graph: Graph
    model: Model

    @staticmethod
    def of(tracer: Tracer) -> "_Stages":
        return _Stages(tracer, *tracer.graph())

    @property
    def A(self) -> list[list[float]]:
        return [[float(x) for x in row[1:]] for row in self.tracer.tableau.A[1:]]

    @property
    def nodes(self) -> list[float]:
        return [float(c) for c in self.tracer.tableau.c[1:]]

    def clock(self, row: int) -> Any:
        return self.graph.input("clock", row)

    @property
    def h(self) -> Any:
        return self.clock(layout.LENGTH)

    def iterate(self, array: str, first: int) -> Iterate:
        """From these rows."""
        size, elements = self.tracer.chart.size, self.tracer.elements
        stages, every = [], []
        for moved, unknown in self.places(first):
            stages.append([self.graph.inputs(array, size, moved.start + size * e) for e in range(elements)])
            every.append(list(self.graph.inputs(array, len(unknown), unknown.start)))
        return stages, every

    def places(self, first: int) -> list[tuple[range, range]]:
        """Of every stage the rows of u and those of the unknowns, in an iterate from a row on."""
        moved, unknown = self.tracer.chart.size * self.tracer.elements, sum(stage_system.unknowns(self.tracer))
        starts = (first + i * (moved + unknown) for i in range(len(self.nodes)))
        return [(range(n, n + moved), range(n + moved, n + moved + unknown)) for n in starts]

    def rows(self, u: Sequence[Sequence[Coordinates]], unknown: Sequence[Sequence[Any]]) -> list[Any]:
        return [x for own, more in zip(u, unknown, strict=True) for x in (*flat(own), *more)]

    def swept(self, u: list[list[Any]], unknown: list[list[Any]], sweeps: int) -> Any:
        """u = h A k, so many times, and k."""
        tracer, chart, x = self.tracer, self.tracer.chart_of(self.model), self.tracer.state(self.graph, "state")
        n, laws, _ = stage_system.unknowns(tracer)
        k: list[list[Coordinates]] = []
        for _ in range(sweeps):
            k = []
            for own, w in zip(u, unknown, strict=True):
                at = tuple(chart.moved(body, z) for body, z in zip(x, own, strict=True))
                F = tracer.field(self.model, at, w[:n], w[n : n + laws])
                k.append([chart.slope(*each) for each in zip(x, own, at, F, strict=True)])
            u = [
                [
                    munthe_kaas.weighted([self.h * w for w in row], [slopes[e] for slopes in k])
                    for e in range(tracer.elements)
                ]
                for row in self.A
            ]
        return u, k

    def state_at(self, u: Sequence[Coordinates]) -> list[Any]:
        """All rows of the state of a stage."""
        chart, x = self.tracer.chart_of(self.model), self.tracer.state(self.graph, "state")
        moved = [chart.moved(body, z) for body, z in zip(x, u, strict=True)]
        return [*flat(moved), *self.tracer.augmented_rows(self.graph)]

    def linear(self, equations: Equations, state: list[Any], c: float, unknown: list[Any]) -> Linear:
        n, laws, _ = stage_system.unknowns(self.tracer)
        t = self.clock(layout.TIME) + c * self.h
        a, mu = unknown[:n], unknown[n + laws :]
        parameter = partial(self.graph.input, "parameters")
        return equations.at(state, t, a, mu, parameter, within=self.clock(layout.MIDDLE))

    def mask(self) -> list[Number]:
        return self.tracer.mask(self.tracer.augmented_rows(self.graph))


def rows_of(tracer: Tracer) -> int:
    """Of an iterate."""
    own = tracer.chart.size * tracer.elements + sum(stage_system.unknowns(tracer))
    return len(tracer.tableau.layers) * own


def kernels(tracer: Tracer) -> dict[str, Kernel | Composite]:
    """All of them; `tracer.sizes` has the rows of an iterate, and gets those of an eliminated matrix."""
    equations = Equations.of(tracer)
    newton, kept = _iteration(tracer, equations, None)
    simplified, _ = _iteration(tracer, equations, kept)
    rows = kept.elimination.memory if isinstance(kept, System) else len(kept.kept)
    tracer.sizes = tracer.sizes._replace(factors=rows)
    found = {"guess": _guess(tracer), "newton": newton, "simplified": simplified, "step": _step(tracer)}
    if tracer.method.adaptive:
        found["close"] = _close(tracer, equations)
        found |= {"close_along": _close(tracer, equations, along=True)} if tracer.weakens else {}
    return found


def _guess(tracer: Tracer) -> Kernel:
    """The unknowns on the polynomial of the last step, as far as that is to be trusted; else 0."""
    step = _Stages.of(tracer)
    graph, first = step.graph, layout.iterate_row(tracer.sizes)
    _, unknown = step.iterate("extra", first)
    since, span = (graph.input("extra", first + tracer.sizes.iterate + row) for row in (layout.SINCE, layout.SPAN))
    known = span > 0.0
    over = where(known, 1.0 / where(known, span, 1.0), 0.0)
    guessed = []
    for c in step.nodes:
        x = minimum(((step.clock(layout.TIME) - since) + c * step.h) * over, FARTHEST)
        weights = []
        for layer in tracer.tableau.layers:
            total: Any = float(layer[-1])
            for w in reversed(layer[:-1]):
                total = total * x + float(w)
            weights.append(total)
        extrapolated = munthe_kaas.weighted(weights, [tuple(own) for own in unknown])
        guessed.append([where(known, y, 0.0) for y in extrapolated])
    zero = [[munthe_kaas.origin(tracer.chart)] * tracer.elements for _ in step.nodes]
    u, _ = step.swept(zero, guessed, FIRST_SWEEPS)
    following = layout.following_row(tracer.sizes)
    rows = step.rows(u, guessed)
    return tracer.kernel("guess", rows, range(following, following + len(rows)))


def _iteration(
    tracer: Tracer, equations: Equations, kept: Factors | System | None
) -> tuple[Kernel | Composite, Factors | System]:
    """One of Newton's method, by a matrix of its own, which is kept behind what is found, or by one that has been."""
    step, sizes = _Stages.of(tracer), tracer.sizes
    u, unknown = step.iterate("extra", layout.iterate_row(sizes))
    u, _ = step.swept(u, unknown, SWEEPS)
    wanted = equations if kept is None else equations.only(())
    stages = [step.linear(wanted, step.state_at(own), c, w) for own, c, w in zip(u, step.nodes, unknown, strict=True)]
    n, laws, _ = stage_system.unknowns(tracer)
    mask = step.mask()
    right: list[Any] = []
    for stage, w in zip(stages, unknown, strict=True):
        right += stage.along
        right += [rate - x for rate, x in zip(stage.laws, w[n : n + laws], strict=True)]
        right += [r - (1.0 - mask[row]) * mu for r, row, mu in zip(stage.rows, tracer.used, w[n + laws :], strict=True)]
    first, place = layout.following_row(sizes), layout.factors_row(sizes)
    name, fresh = ("newton", True) if kept is None else ("simplified", False)
    if kept is None:
        system = stage_system.system(tracer, stages, step.A, step.h, mask)
        kept = system if system.elimination.products > LOOPS else system.factors
    elif isinstance(kept, Factors):
        kept = kept.again(step.graph.inputs("extra", len(kept.kept), place))
    if isinstance(kept, System):
        solution, places = kept.right(place), step.places(first)
        start: list[tuple[int, Any]] = []
        for (rows, _), own in zip(places, u, strict=True):
            start += zip(rows, flat(own), strict=True)
        start += [*zip(solution, right, strict=True), *(kept.stores(place) if fresh else [])]
        end = _Stages.of(tracer)
        new, *said = _improved(end, [end.graph.input("extra", row) for row in solution])
        found: list[tuple[int, Any]] = [*enumerate(said, first + sizes.iterate)]
        for (_, rows), w in zip(places, new, strict=True):
            found += zip(rows, w, strict=True)
        return EliminatingKernel(name, kept.elimination, place, start, found, fresh), kept
    new, *said = _improved(step, kept.solved(right))
    outputs = [*step.rows(u, new), *said]
    rows = range(first, first + len(outputs))
    outputs += kept.kept if fresh else []
    return tracer.kernel(name, outputs, [*rows, *range(place, place + len(outputs) - len(rows))]), kept


def _improved(step: _Stages, changes: Sequence[Any]) -> tuple[list[list[Any]], Any, Any]:
    """The unknowns of all stages after these changes, the size of these, and whether they are numbers."""
    _, unknown = step.iterate("extra", layout.iterate_row(step.tracer.sizes))
    size = len(changes) // len(unknown)
    by_stage = [changes[size * i : size * (i + 1)] for i in range(len(unknown))]
    new = [[x + dx for x, dx in zip(w, own, strict=True)] for w, own in zip(unknown, by_stage, strict=True)]
    return new, _size(step, by_stage), where(finite([x for own in new for x in own]), 1.0, 0.0)


def _size(step: _Stages, changes: Sequence[Sequence[Any]]) -> Any:
    """The change of the worst stage, of each coordinate, squared, as a fraction of what the tolerance allows."""
    tracer, x = step.tracer, step.tracer.state(step.graph, "state")
    n, laws, _ = stage_system.unknowns(tracer)
    moving = [[step.h * sum(w * own[m] for w, own in zip(row, changes, strict=True)) for m in range(n + laws)]
              for row in step.A]  # fmt: skip
    largest: list[Any] = [0.0] * (2 * n + laws)
    for row, own in zip(step.A, moving, strict=True):
        places = [step.h * sum(w * other[m] for w, other in zip(row, moving, strict=True)) for m in range(n)]
        largest = [maximum(absolute(y), z) for y, z in zip([*places, *own], largest, strict=True)]
    estimates = [[z] for z in tracer.gathered(largest[:n], largest[n : 2 * n], largest[2 * n :])]
    return tracer.error_square(step.graph, step.model, estimates, x, x)


def _step(tracer: Tracer) -> Kernel:
    step = _Stages.of(tracer)
    graph, model, sizes = step.graph, step.model, tracer.sizes
    chart, x, augmented = tracer.chart_of(model), tracer.state(graph, "state"), tracer.augmented_rows(graph)
    u, unknown = step.iterate("extra", layout.iterate_row(sizes))
    u, k = step.swept(u, unknown, LAST_SWEEPS)
    n, laws, _ = stage_system.unknowns(tracer)
    square: Number = 0.0
    rotation: Number = 0.0
    for own in u:
        for z in own:
            rotation = maximum(chart.rotation(z), rotation)
    new = []
    for body, z in zip(x, u[-1], strict=True):
        for c in z:
            square = square + c * c
        new.append(chart.settled(chart.moved(body, z)))
    reports = Reports(power=[0.0])
    margin = graph.input("extra", layout.report_row(sizes, 0) + layout.STAGE_MARGIN)
    reports.margin.append(margin)
    mask, t = step.mask(), step.clock(layout.TIME)
    for own, w, c in zip(u, unknown, step.nodes, strict=True):
        at = [chart.moved(body, z) for body, z in zip(x, own, strict=True)]
        posture = tracer.posture(model, at, augmented, t + c * step.h, step.clock(layout.MIDDLE))
        mu: list[Number] = [0.0] * tracer.structure.rows
        for row, m in zip(tracer.used, w[n + laws :], strict=True):
            mu[row] = m
        if tracer.augmented.work:
            every = tracer.reactions(model, posture, mask, mu)
            reports.power.append(dynamics.power(model, posture.now, every))
    reports.accelerations = tracer.carried(model, new, unknown[-1][:n])
    now = tracer.posture(model, new, augmented, t + step.h).now
    after = augmented_after(tracer, model, augmented, now, step.h, reports)
    outputs = [*flat(new), *after, verdict(tracer.strict(rotation), square, 1.0, 1.0)]
    outputs += [margin] if tracer.augmented.masks else []
    rows, behind = list(range(len(outputs))), layout.first_slope(sizes)
    for s, slopes in enumerate(k, 1):
        for i, f in enumerate(slopes):
            outputs += f
            rows += [behind + layout.slope_row(sizes, i, s) + c for c in range(sizes.coordinates)]
        if tracer.augmented.work:
            outputs.append(reports.power[s])
            rows.append(behind + layout.report_row(sizes, s) + layout.POWER)
    return tracer.kernel("step", outputs, rows)


def _close(tracer: Tracer, equations: Equations, along: bool = False) -> Kernel | Composite:
    """The error h (gamma F_0 + sum e_j f_j), of which (I - h gamma J)^-1 leaves what is not stiff; along: whether
    velocities that the constraints do not allow are left out."""
    step, name = _Stages.of(tracer), "close_along" if along else "close"
    behind = layout.first_slope(tracer.sizes)
    _, unknown = step.iterate("extra", behind + layout.iterate_row(tracer.sizes))
    n, laws, count = stage_system.unknowns(tracer)
    places, velocities, states = _rough(step)
    x0 = [*flat(tracer.state(step.graph, "state")), *tracer.augmented_rows(step.graph)]
    stage = step.linear(equations, x0, 0.0, unknown[0])
    right: list[Any] = [0.0] * (n + laws + count)
    given = {"q": [float(tracer.tableau.damping) * step.h * q for q in places]}
    for of, first in (("along", 0), ("laws", n)):
        for (row, c), value in stage.block(of, "q").items():
            right[first + row] = right[first + row] + value * given["q"][c]
    for of, first in (("along", 0), ("rows", n + laws)):
        for (row, c), value in stage.block(of, "a").items():
            right[first + row] = right[first + row] - value * velocities[c]
    for m, x in enumerate(states):
        right[n + m] = right[n + m] + x
    system = stage_system.system(tracer, [stage], [[float(tracer.tableau.damping)]], step.h, step.mask())
    if system.elimination.products <= LOOPS:
        return tracer.kernel(name, _error(step, system.factors.solved(right), along))
    first = behind + layout.factors_row(tracer.sizes)
    solution, end = system.right(first), _Stages.of(tracer)
    start = [*zip(solution, right, strict=True), *system.stores(first)]
    found = _error(end, [end.graph.input("extra", row) for row in solution], along)
    return EliminatingKernel(name, system.elimination, first, start, [*enumerate(found)])


def _rough(step: _Stages) -> tuple[list[Number], list[Number], list[Number]]:
    """The error before it is damped: of places, of velocities, of laws' states."""
    tracer, rough = step.tracer, []
    weights, behind = munthe_kaas.scaled(step.h, tracer.tableau.errors[0]), layout.first_slope(tracer.sizes)
    for i in range(tracer.elements):
        slopes = [
            step.graph.inputs("extra", tracer.chart.size, behind + layout.slope_row(tracer.sizes, i, s))
            for s in range(tracer.sizes.stages)
        ]
        rough.append(munthe_kaas.weighted(weights, slopes))
    return tracer.apart(rough)


def _error(step: _Stages, found: Sequence[Any], along: bool) -> list[Number]:
    """What `close` says, of the damped error of velocities and laws' states."""
    tracer, graph, model = step.tracer, step.graph, step.model
    n, laws, _ = stage_system.unknowns(tracer)
    places, beta = _rough(step)[0], float(tracer.tableau.damping) * step.h
    moving = allowed(tracer, graph, model, [*found[:n]]) if along else found[:n]
    moved = [q + beta * v for q, v in zip(places, moving, strict=True)]
    estimates = [[z] for z in tracer.gathered(moved, moving, found[n : n + laws])]
    square = tracer.error_square(graph, model, estimates, tracer.state(graph, "state"), tracer.state(graph, "extra"))
    if tracer.augmented.work:
        work = work_error_square(tracer, graph, model, layout.first_slope(tracer.sizes))
        square = step_control.worst([square, work])
    square = square * (PASSING * PASSING) if along else square
    return [square, *step_control.factor(square, graph.input("clock", layout.MEMORY), tracer.tableau.estimated)]
