"""The kernels of a step: as one, or stage by stage for large mechanisms."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import Chart
from lienumba.integrators.tracing.law_states import rates
from lienumba.integrators.tracing.tracer import Tracer, flat
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.numerics.operations import maximum

INLINE = 6000  # operations of all stages up to which a step is traced as a whole; beyond, it calls the stages


@dataclass
class _Reports:
    """What the stages of a step report beside their slopes."""

    sound: list[Any] = field(default_factory=list)
    power: list[Any] = field(default_factory=list)
    margin: list[Any] = field(default_factory=list)
    accelerations: list[Any] = field(default_factory=list)  # of the last stage

    def read(self, rows: Sequence[Any], tracer: Tracer) -> None:
        """Those of a stage that is known: whether its KKT was sound, the power, the margin."""
        self.sound.append(rows[0])
        self.power += [rows[1]] if tracer.held.work else []
        self.margin.append(rows[2])


def step(tracer: Tracer) -> dict[str, Kernel]:
    """The step as one kernel, or as many if a stage is too long to be repeated in it; where lanes are free, also what
    the continuous extension needs."""
    before, stages = tracer.rows, tracer.tableau.stages
    stage = _stage(tracer, "stage")
    if stage.counts()["operations"] * tracer.stages > INLINE:
        used = [s for s, row in enumerate(stages) if any(row) and s != tracer.stages]
        kernels = {"stage": stage, "first": _stage(tracer, "first"), "advance": _advance(tracer)}
        kernels |= {"finish": _finish(tracer)} if tracer.held.rows else {}
        return kernels | _combinations(tracer, used if tracer.method.free else used[: tracer.stages - 1])
    if not tracer.method.free:
        tracer.rows = before
        return {"step": _inline(tracer)}
    kernels = {"stage": stage} if tracer.tableau.more else {}
    kernels |= _combinations(tracer, range(tracer.stages + 1, len(stages)))
    return kernels | {"first": _stage(tracer, "first"), "step": _inline(tracer)}


def _inline(tracer: Tracer) -> Kernel:
    """A whole step. Where lanes are free, the slopes and the power of all stages are kept; extra: these, where a
    tolerance chooses steps, because then the first one is known."""
    graph, model = tracer.graph()
    held, reports = tracer.held_rows(graph), _Reports()
    t, h = graph.inputs("clock", 2)
    first: tuple[Any, ...] = ()
    if tracer.method.paced:
        first = tuple(graph.inputs("extra", tracer.chart.size, tracer.slope_row(i)) for i in range(tracer.elements))
        reports.read(graph.inputs("extra", codes.REPORTS, tracer.slope_row(tracer.elements)), tracer)
    F = _vector_field(tracer, model, held, reports, h, graph.input("clock", codes.MIDDLE))
    new, rotation, square, slopes = munthe_kaas.step(
        tracer.chart,
        tracer.tableau,
        tracer.state(graph, "state"),
        t,
        h,
        lambda x, u, t: munthe_kaas.slope(tracer.chart, x, u, lambda y: F(y, t)),
        first,
    )
    every = reports.sound[0]
    for sound in reports.sound[1:]:
        every = every * sound
    code = munthe_kaas.verdict(tracer.strict(rotation), square, reports.sound[0], every)
    after = _held_after(tracer, model, held, tracer.instant(new, held, t + h), h, reports)
    margin = reports.margin[:1] if tracer.held.masks else []
    outputs = [*flat(new), *after, code, *margin]
    if not tracer.method.free:
        return tracer.kernel("step", outputs)
    rows, behind = list(range(len(outputs))), tracer.state_rows
    for s in range(1 if first else 0, tracer.stages):
        for i, f in enumerate(slopes):
            outputs += f[s]
            rows += [behind + tracer.slope_row(i, s) + c for c in range(tracer.chart.size)]
        outputs += reports.power[s : s + 1]
        rows += [behind + tracer.slope_row(tracer.elements, s) + 1] if reports.power else []
    return tracer.kernel("step", outputs, tuple(rows))


def _stage(tracer: Tracer, name: str) -> Kernel:
    """The slopes of all bodies at u about x, or with the name "first" at x; extra: u.

    Its outputs go to the rows of one stage among those of all (see `scratch.slope_row`); behind them stands what it
    reports: whether the KKT was sound, the power, the margin, and accelerations that are held but not in the slopes.
    """
    graph, model = tracer.graph()
    reports = _Reports()
    t = graph.input("clock", codes.TIME)
    node = 0.0 if name == "first" else graph.input("clock", codes.NODE)
    h, within = graph.input("clock", codes.LENGTH), graph.input("clock", codes.MIDDLE)
    F = _vector_field(tracer, model, tracer.held_rows(graph), reports, h, within, node)
    chart, every = tracer.chart, range(tracer.elements)
    zero = munthe_kaas.origin(chart)
    u = tuple(zero if name == "first" else graph.inputs("extra", chart.size, chart.size * i) for i in every)
    f = munthe_kaas.slope(chart, tracer.state(graph, "state"), u, lambda y: F(y, t))
    said = [*reports.sound, *(reports.power or [0.0]), *(reports.margin if tracer.held.masks else [])]
    rows = [tracer.slope_row(i) + c for i in every for c in range(chart.size)]
    rows += [tracer.slope_row(tracer.elements) + c for c in range(len(said))]
    if tracer.reported:
        said += reports.accelerations
        rows += [tracer.reported_row + c for c in range(6 * tracer.k)]
    return tracer.kernel(name, (*flat(f), *said), tuple(rows))


def _finish(tracer: Tracer) -> Kernel:
    """What is held after a step; state: the new bodies, and what was held; extra: what the stages gave."""
    graph, model = tracer.graph()
    t, h = graph.inputs("clock", 2)
    said = [graph.inputs("extra", codes.REPORTS, tracer.slope_row(tracer.elements, s)) for s in range(tracer.stages)]
    last = [tracer.slope_row(i, tracer.stages) - 6 for i in range(tracer.k)]
    if tracer.reported:
        first = tracer.reported_row + tracer.chart.size * (tracer.stages - 1)
        last = [first + 6 * i for i in range(tracer.k)]
    reports = _Reports(
        power=[x[1] for x in said],
        margin=[x[2] for x in said],
        accelerations=[x for first in last for x in graph.inputs("extra", 6, first)],
    )
    held = tracer.held_rows(graph)
    now = tracer.instant(tracer.state(graph, "state"), held, t)
    return tracer.kernel("finish", _held_after(tracer, model, held, now, h, reports))


def _combinations(tracer: Tracer, stages: Iterable[int]) -> dict[str, Kernel]:
    """u of one body in each of these stages; extra: the body's slopes."""
    kernels, chart = {}, tracer.chart
    for s in stages:
        graph, _ = tracer.graph()
        exponentials = tracer.tableau.exponentials(s)
        slopes = _slopes(chart, graph, s)[: len(exponentials[0])]
        u, rotation = munthe_kaas.combination(chart, graph.input("clock", codes.LENGTH), exponentials, slopes)
        kernels[f"combine{s}"] = tracer.kernel(f"combine{s}", (*u, tracer.strict(rotation)))
    return kernels


def _advance(tracer: Tracer) -> Kernel:
    """One body at the end of a step; extra: the body's slopes."""
    graph, _ = tracer.graph()
    x = tuple(graph.inputs("state", ELEMENT))
    slopes = _slopes(tracer.chart, graph, tracer.stages)
    new, rotation, square = munthe_kaas.advanced(
        tracer.chart, graph.input("clock", codes.LENGTH), tracer.tableau, x, slopes
    )
    return tracer.kernel("advance", (*new, tracer.strict(rotation), square))


def _slopes(chart: Chart, graph: Graph, stages: int) -> list[Any]:
    return [graph.inputs("extra", chart.size, chart.size * s) for s in range(stages)]


def _vector_field(
    tracer: Tracer, model: Model, held: tuple[Any, ...], reports: _Reports, h: Any, within: Any, node: Any = None
) -> Callable[[Any, Any], Any]:
    """F of eq. (15): velocities and accelerations at a state; what each stage reports is noted aside. h: of the step;
    within: the time in its middle; node: c of the stage; by default that of the stages as they come."""
    mask = tracer.held.mask(held, tracer.structure.rows)

    def F(state: Any, t: Any) -> Any:
        now = tracer.instant(state, held, t, within)
        c = float(tracer.tableau.c[len(reports.sound)]) if node is None else node
        expected = tracer.expected(held, c, h)
        solution = dynamics.accelerations(model, tracer.structure, now, mask, expected, tracer.method.baumgarte)
        reports.sound.append(solution.sound)
        reports.margin.append(solution.margin)
        if tracer.held.work:
            reports.power.append(dynamics.power(model, now, solution.mu))
        reports.accelerations = a = solution.x
        moving = [(*x[12:18], *a[6 * i : 6 * i + 6]) for i, x in enumerate(now.bodies)]
        return (*moving, *tracer.carried.slopes(rates(model, now)))

    return F


def _held_after(
    tracer: Tracer, model: Model, held: tuple[Any, ...], now: Instant, h: Any, reports: _Reports
) -> list[Any]:
    """What is held after a step that ends at `now`."""
    rows = tracer.held.counted(model, now)
    if tracer.held.work:
        work = held[len(tracer.held.angles)]
        for b, power in zip(tracer.tableau.b, reports.power, strict=True):
            work = work + (h * float(b)) * power if b else work
        rows.append(work)
    if tracer.held.accelerations:
        rows += tracer.held.after(held, reports.accelerations, h)
    if tracer.held.masks:
        rows += [*held[tracer.held.first_mask : -1], maximum(reports.margin[0], held[-1])]
    return rows
