"""The kernels of a step: as one, or stage by stage for large mechanisms."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import Algebra, State
from lienumba.integrators import layout
from lienumba.integrators.codes import PARADOX, verdict
from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import Chart, Coordinates
from lienumba.integrators.methods.step_control import joined
from lienumba.integrators.tracing.measuring.signals import Signals
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import absolute, maximum, minimum, where

INLINE = 6000  # operations of all stages up to which a step is traced as a whole; beyond, it calls the stages
VectorField = Callable[[Sequence[State], Number], Sequence[Algebra]]


@dataclass
class Reports:
    """What the stages of a step report beside their slopes."""

    nonsingular: list[Number] = field(default_factory=list)
    power: list[Number] = field(default_factory=list)
    margin: list[Number] = field(default_factory=list)
    accelerations: list[Number] = field(default_factory=list)  # of the last stage
    history: list[Number] = field(default_factory=list)  # see `AugmentedState`
    signals: list[Signals] = field(default_factory=list)

    def read(self, rows: Sequence[Number], tracer: Tracer) -> None:
        """Add the rows of a stage that is known."""
        self.nonsingular.append(rows[layout.NONSINGULAR])
        self.power += [rows[layout.POWER]] if tracer.augmented.work else []
        self.margin.append(rows[layout.STAGE_MARGIN])


def step(tracer: Tracer) -> dict[str, Kernel]:
    """The step as one kernel, or as many if a stage is too long to be repeated in it; where lanes have a time of their
    own, also what the continuous extension needs."""
    stages, count, queued = tracer.tableau.stages, tracer.sizes.stages, tracer.method.queued
    if tracer.tableau.implicit:
        return {"first": _stage(tracer, first=True)}
    if not tracer.tableau.composed:
        tracer.integrands = quantities.integrands(tracer.template)
        seen = 2 * len(quantities.signals(tracer.template)) if tracer.method.adaptive else 0
        tracer.sizes = tracer.sizes._replace(integrands=len(tracer.integrands), seen=seen)
    stage = _stage(tracer, first=False)
    if stage.counts()["operations"] * count > INLINE:
        kernels = {"first": _stage(tracer, first=True)} | _by_stages(tracer, stage)
        return kernels | ({"quadrature": _quadrature(tracer)} if tracer.integrands else {})
    kernels = {"step": _inline(tracer, queued)}
    kernels |= {"quadrature": _quadrature(tracer)} if tracer.integrands and tracer.method.adaptive else {}
    if not tracer.method.extended:
        return kernels
    kernels |= {"stage": stage} if tracer.tableau.more else {}
    kernels |= _combinations(tracer, range(count + 1, len(stages)))
    kernels |= {} if queued else {"slopes": _inline(tracer, True)}
    return kernels | {"first": _stage(tracer, first=True)}


def stages(tracer: Tracer) -> dict[str, Kernel]:
    """A step as one kernel for every stage, of whatever size; the first stage is one like all others."""
    return _by_stages(tracer, _stage(tracer, first=False))


def _by_stages(tracer: Tracer, stage: Kernel) -> dict[str, Kernel]:
    count = tracer.sizes.stages
    used = [s for s, row in enumerate(tracer.tableau.stages) if any(row) and s != count]
    kernels = {"stage": stage, "advance": _advance(tracer)}
    kernels |= {"finish": _finish(tracer)} if tracer.augmented.rows else {}
    return kernels | _combinations(tracer, used if tracer.method.extended else used[: count - 1])


def _clock(graph: Graph) -> tuple[Number, Number, Number]:
    """t, h, and the time in the middle of the step."""
    t, h, within = (graph.input("clock", row) for row in (layout.TIME, layout.LENGTH, layout.MIDDLE))
    return t, h, within


def _inline(tracer: Tracer, opened: bool) -> Kernel:
    """A whole step, and what signals integrate to in it. Where lanes have a time of their own, the slopes and the
    power of all stages are kept, too; else a kernel that is `opened` says nothing but these. extra: the slopes, where a
    tolerance chooses steps, because then the first one is known."""
    graph, model = tracer.graph()
    queued = tracer.method.queued
    sizes, augmented, reports = tracer.sizes, tracer.augmented_rows(graph), Reports()
    t, h, within = _clock(graph)
    first: tuple[Coordinates, ...] = ()
    if tracer.method.adaptive:
        every = range(tracer.elements)
        first = tuple(graph.inputs("extra", sizes.coordinates, layout.slope_row(sizes, i, 0)) for i in every)
        reports.read(graph.inputs("extra", layout.REPORTS, layout.report_row(sizes, 0)), tracer)
    F = _vector_field(tracer, model, augmented, reports, h, within)
    chart = tracer.chart_of(model)
    new, rotation, square, slopes = munthe_kaas.step(
        chart,
        tracer.tableau,
        tracer.state(graph, "state"),
        t,
        h,
        lambda x, u, t: munthe_kaas.slope(chart, x, u, lambda y: F(y, t)),
        first,
    )
    nonsingular = reports.nonsingular[0]
    for other in reports.nonsingular[1:]:
        nonsingular = minimum(nonsingular, other) if tracer.structure.friction_rows else nonsingular * other
    code = verdict(tracer.strict(rotation), square, reports.nonsingular[0], nonsingular)
    if tracer.structure.friction_rows:
        code = where(nonsingular < 0.0, PARADOX, code)
    after = augmented_after(tracer, model, augmented, tracer.posture(model, new, augmented, t + h).now, h, reports)
    outputs = [*flat(new), *after, code, *(reports.margin[:1] if tracer.augmented.masks else [])]
    integrals = [] if first else _integrals(tracer, h, [x.integrands for x in reports.signals])
    rows, behind = list(range(len(outputs))), layout.first_slope(sizes)
    place = behind + (layout.quadrature_row(sizes) if queued else 0)
    outputs, rows = [*outputs, *integrals], [*rows, *(place + n for n in range(len(integrals)))]
    if opened and not queued:
        outputs, rows, behind = [], [], 0
    for s in range(1 if first else 0, sizes.stages if opened else 0):
        for i, f in enumerate(slopes):
            outputs += f[s]
            rows += [behind + layout.slope_row(sizes, i, s) + c for c in range(sizes.coordinates)]
        outputs += reports.power[s : s + 1]
        rows += [behind + layout.report_row(sizes, s) + layout.POWER] if reports.power else []
        if first:
            outputs += reports.signals[s - 1].integrands
            rows += [behind + layout.said_row(sizes, n, s) for n in range(len(tracer.integrands))]
    return tracer.kernel("step" if queued or not opened else "slopes", outputs, rows)


def _integrals(tracer: Tracer, h: Number, stages: Sequence[Sequence[Number]]) -> list[Number]:
    """What they integrate to in a step, of what they are in its stages."""
    return [_weighted(h, tracer.tableau.b, [x[n] for x in stages]) for n in range(len(tracer.integrands))]


def _weighted(h: Number, weights: Iterable[Fraction], numbers: Sequence[Number]) -> Number:
    zero: Number = 0.0
    return sum(((h * float(b)) * x for b, x in zip(weights, numbers, strict=False) if b), start=zero)


def _quadrature(tracer: Tracer) -> Kernel:
    """The integrals of signals over a step, from their values in all stages.

    Where a tolerance chooses steps, the squared error of each integral follows, then the integral if all stages were as
    large as the largest. extra: the slopes.
    """
    graph, _ = tracer.graph()
    h, sizes, every = _clock(graph)[1], tracer.sizes, range(len(tracer.integrands))
    last = [sizes.slopes - 1] if tracer.method.adaptive else []
    places = [*range(sizes.stages), *last]
    said = [[graph.input("extra", layout.said_row(sizes, n, s)) for n in every] for s in places]
    outputs = _integrals(tracer, h, said)
    for n in every if last else ():
        mine = [x[n] for x in said]
        errors = (_weighted(h, row, mine) for row in tracer.tableau.errors)
        outputs.append(joined(tuple(x * x for x in errors)))
    used = [x for x, b in zip(said, tracer.tableau.b, strict=False) if b]
    outputs += [h * reduce(maximum, [absolute(x[n]) for x in used]) for n in every if last]
    return tracer.kernel("quadrature", outputs)


def _stage(tracer: Tracer, first: bool) -> Kernel:
    """The slopes of all bodies at u about x (Terze et al. 2015, eq. 19), or of the first stage, at x; extra: u.

    Its outputs go to the rows of one stage among those of all; behind them stands what it reports, with accelerations
    that are carried on but not in the slopes.
    """
    graph, model = tracer.graph()
    sizes, reports = tracer.sizes, Reports()
    t, h, within = _clock(graph)
    node = 0.0 if first else graph.input("clock", layout.NODE)
    F = _vector_field(tracer, model, tracer.augmented_rows(graph), reports, h, within, node)
    chart, every = tracer.chart_of(model), range(tracer.elements)
    zero = munthe_kaas.origin(chart)
    u = tuple(zero if first else graph.inputs("extra", chart.size, chart.size * i) for i in every)
    f = munthe_kaas.slope(chart, tracer.state(graph, "state"), u, lambda y: F(y, t))
    margin = reports.margin if tracer.augmented.masks or tracer.weakens else []
    reported = [*reports.nonsingular, *(reports.power or [0.0]), *margin]
    rows = [layout.slope_row(sizes, i, 0) + c for i in every for c in range(chart.size)]
    rows += [layout.report_row(sizes, 0) + c for c in range(len(reported))]
    if tracer.reports_accelerations:
        reported += reports.accelerations
        rows += [layout.acceleration_row(sizes, 0) + c for c in range(tracer.velocities)]
    reported += reports.signals[0].integrands
    rows += [layout.said_row(sizes, n, 0) for n in range(len(tracer.integrands))]
    if first:
        reported += reports.signals[0].seen.values()
        rows += [layout.said_row(sizes, len(tracer.integrands) + n, 0) for n in reports.signals[0].seen]
    return tracer.kernel("first" if first else "stage", (*flat(f), *reported), rows)


def _finish(tracer: Tracer) -> Kernel:
    """What is augmented after a step; state: the new elements, and what was augmented; extra: what the stages gave."""
    graph, model = tracer.graph()
    sizes = tracer.sizes
    t, h, _ = _clock(graph)
    reports = Reports()
    for s in range(sizes.stages):
        reports.read(graph.inputs("extra", layout.REPORTS, layout.report_row(sizes, s)), tracer)
    if tracer.reports_accelerations:
        row = layout.acceleration_row(sizes, sizes.stages - 1)
        reports.accelerations = list(graph.inputs("extra", tracer.velocities, row))
    else:
        last = [layout.slope_row(sizes, i, sizes.stages) - 6 for i in range(tracer.k)]
        reports.accelerations = [x for first in last for x in graph.inputs("extra", 6, first)]
    augmented = tracer.augmented_rows(graph)
    now = tracer.posture(model, tracer.state(graph, "state"), augmented, t).now
    return tracer.kernel("finish", augmented_after(tracer, model, augmented, now, h, reports))


def _combinations(tracer: Tracer, stages: Iterable[int]) -> dict[str, Kernel]:
    """u of one body in each of these stages; extra: the body's slopes."""
    kernels = {}
    for s in stages:
        graph, model = tracer.graph()
        chart = tracer.chart_of(model)
        exponentials = tracer.tableau.exponentials(s)
        slopes = _slopes(chart, graph, s)[: len(exponentials[0])]
        u, rotation = munthe_kaas.combination(chart, _clock(graph)[1], exponentials, slopes)
        kernels[f"combine{s}"] = tracer.kernel(f"combine{s}", (*u, tracer.strict(rotation)))
    return kernels


def _advance(tracer: Tracer) -> Kernel:
    """One body at the end of a step; extra: the body's slopes."""
    graph, model = tracer.graph()
    chart, x = tracer.chart_of(model), graph.inputs("state", tracer.element)
    slopes = _slopes(chart, graph, tracer.sizes.stages)
    new, rotation, square = munthe_kaas.advanced(chart, _clock(graph)[1], tracer.tableau, x, slopes)
    return tracer.kernel("advance", (*new, tracer.strict(rotation), square))


def _slopes(chart: Chart, graph: Graph, stages: int) -> list[Coordinates]:
    return [graph.inputs("extra", chart.size, chart.size * s) for s in range(stages)]


def _vector_field(
    tracer: Tracer, model: Model, augmented: Vector, reports: Reports, h: Number, within: Number,
    node: Number | None = None,
) -> VectorField:  # fmt: skip
    """F (Terze et al. 2015, eq. 15): velocities and accelerations at a state; what each stage reports is noted aside.
    h: of the step; within: the time in its middle; node: c of the stage; by default that of the stages as they come."""
    mask = tracer.augmented.mask(augmented, tracer.structure.rows)

    def F(state: Sequence[State], t: Number) -> Sequence[Algebra]:
        posture = tracer.posture(model, state, augmented, t, within)
        c = float(tracer.tableau.c[len(reports.nonsingular)]) if node is None else node
        expected = tracer.expected(augmented, c, h)
        moving, found = tracer.moving(model, posture, mask, expected)
        reports.nonsingular.append(found.nonsingular)
        reports.margin.append(found.margin)
        if tracer.augmented.work:
            reports.power.append(dynamics.power(model, posture.now, found.multipliers))
        reports.signals.append(Signals(tracer, model, posture, mask, expected, found))
        reports.accelerations = found.accelerations
        return moving

    return F


def augmented_after(
    tracer: Tracer, model: Model, augmented: Vector, now: Instant, h: Number, reports: Reports
) -> list[Number]:
    """What is augmented after a step that ends at `now`."""
    rows = tracer.augmented.counted(model, now)
    if tracer.augmented.work:
        work = augmented[len(tracer.augmented.angles)]
        for b, power in zip(tracer.tableau.b, reports.power, strict=True):
            work = work + (h * float(b)) * power if b else work
        rows.append(work)
    if tracer.augmented.accelerations:
        rows += tracer.augmented.after(augmented, reports.accelerations, h)
    rows += reports.history
    mode = tracer.augmented.first_mode
    if tracer.augmented.masks:
        rows += [*augmented[tracer.augmented.first_mask : mode - 1], maximum(reports.margin[0], augmented[mode - 1])]
    return [*rows, *augmented[mode:]]
