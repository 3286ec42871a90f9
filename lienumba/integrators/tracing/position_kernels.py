"""The kernels of the position projection: one iteration, and as a chord method one by the elimination of the first.

An iterate is a state, the correction from q^ and the multipliers as far as they are needed (see `Tracer`), the
violation, and the code. Behind them the first iteration leaves the numbers of its elimination, where the chord
iterations, which write to the same rows, find them.
"""

from dataclasses import dataclass
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph, Symbol
from lienumba.groups import so3
from lienumba.groups.state import State
from lienumba.integrators import codes, layout
from lienumba.integrators.tracing.joint.chart import displacement
from lienumba.integrators.tracing.tracer import Correction, Posture, Tracer
from lienumba.mechanics.elements.events import ENGAGE
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import embedded, kkt, projection
from lienumba.mechanics.tolerances import SINGULAR_VIOLATION
from lienumba.mechanics.tree import equations, posture
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import at_most, maximum, where


def position(tracer: Tracer) -> tuple[dict[str, Kernel], int]:
    """The kernel `position`, and `chord` where it is asked for; how many numbers of the elimination are kept."""
    first = _iteration(tracer)
    solution = first.solution()
    outputs = first.outputs(solution)
    if not tracer.method.chord:
        return {"position": tracer.kernel("position", outputs)}, 0
    numbers = solution.by.numbers()
    kept = list({x.id: x for x in numbers if isinstance(x, Symbol)}.values())
    kernels = {"position": tracer.kernel("position", (*outputs, *kept))}
    later = _iteration(tracer)
    found = {x.id: later.graph.input("out", len(outputs) + row) for row, x in enumerate(kept)}
    by = solution.by.with_numbers([found[x.id] if isinstance(x, Symbol) else x for x in numbers])
    kernels["chord"] = tracer.kernel("chord", later.outputs(later.chord(by)))
    return kernels, len(kept)


def closure(tracer: Tracer) -> Kernel:
    """An iteration that closes joints over gaps: bodies move least by their masses, so that the mass centre of what
    nothing else holds stays, in any unit of length."""
    iteration = _iteration(tracer, masses=True)
    return tracer.kernel("closure", iteration.outputs(iteration.solution()))


def closes(tracer: Tracer) -> bool:
    """Whether an event closes a joint, and corrections are of coordinates that have masses."""
    engages = any(event.action == ENGAGE.name for event in tracer.template.events)
    return engages and (tracer.method.coordinates == "joint" or tracer.method.position == "local")


def _iteration(tracer: Tracer, masses: bool = False) -> "_Iteration":
    graph, model = tracer.graph()
    (there, mask), augmented = tracer.now(graph, model), tracer.augmented_rows(graph)
    here = tracer.posture(model, tracer.state(graph, "extra"), augmented, graph.input("clock", layout.TIME))
    x_rows, mu_rows = tracer.correction_rows
    behind = tracer.element * tracer.elements
    x: list[Number] = list(graph.inputs("extra", x_rows, behind))
    mu: list[Number] = list(graph.inputs("extra", mu_rows, behind + x_rows))
    if mu:
        mu = projection.masked(mu, projection.position_mask(model, mask))
    form = tracer.method.coordinates if tracer.method.coordinates in FORMS else tracer.method.position
    return FORMS[form](tracer, graph, model, augmented, mask, there, here, x, mu, masses)


@dataclass(frozen=True)
class _Iteration:
    """What an iteration begins with: q^ `there`, the iterate `here`, its correction x and multipliers mu; masses:
    whether corrections are small by these."""

    tracer: Tracer
    graph: Graph
    model: Model
    augmented: Vector
    mask: list[Number]
    there: Posture
    here: Posture
    x: list[Number]
    mu: list[Number]
    masses: bool

    @property
    def hat(self) -> Instant:
        return self.there.now

    @property
    def now(self) -> Instant:
        return self.here.now

    def solution(self) -> Any:
        """The next correction, a `tracer.Correction`."""
        raise NotImplementedError

    def chord(self, by: kkt.Eliminated) -> kkt.Solution:
        """The next correction, by an earlier elimination."""
        raise NotImplementedError

    def moved(self, x: list[Number]) -> tuple[tuple[State, ...], Number]:
        """The elements that this correction leads to, and its largest squared rotation."""
        raise NotImplementedError

    def violation(self, now: Instant, counts: list[Number]) -> Number:
        """The largest of what the tolerance limits."""
        return projection.position_violation(self.model, now, counts)

    def outputs(self, solution: Correction) -> list[Number]:
        """The iterate that follows."""
        tracer = self.tracer
        new, rotation = self.moved(solution.x)
        time = self.graph.input("clock", layout.TIME)
        there = tracer.posture(self.model, new, self.augmented, time).now
        counts = tracer.counted(solution, self.mask, "position")
        violation = self.violation(there, counts)
        code = where(rotation < codes.LARGEST_STAGE, 0.0, codes.NOT_CONVERGED)
        if tracer.structure.looped:
            lost = projection.lost(self.model, there, counts)
            code = where(lost < SINGULAR_VIOLATION, code, codes.SINGULAR)
        code = where(solution.nonsingular > 0.0, code, codes.SINGULAR)
        code = where(codes.finite(solution.x), code, codes.NON_FINITE)
        x_rows, mu_rows = tracer.correction_rows
        return [*tracer.with_law_states(self.graph, new), *solution.x[:x_rows], *solution.mu[:mu_rows], violation, code]


class _Joint(_Iteration):
    def solution(self) -> Any:
        assert isinstance(self.here, posture.Posture)
        structure, x = self.tracer.structure, self.x
        if self.masses:
            return equations.closure(self.here, structure, self.mask, x, self.hat)
        return equations.position_correction(self.here, structure, self.mask, x)

    def moved(self, x: list[Number]) -> tuple[tuple[State, ...], Number]:
        assert isinstance(self.there, posture.Posture)
        chart, element = self.tracer.chart_of(self.model), self.tracer.state(self.graph, "state")[0]
        u = displacement(self.there.tree, element, tuple(x), chart.size)
        return (chart.moved(element, u),), chart.rotation(u)


class _Local(_Iteration):
    def solution(self) -> kkt.Solution:
        t = self.tracer
        return projection.position_correction(self.model, t.structure, self.now, self.x, self.mask, t.axes, self.masses)

    def chord(self, by: kkt.Eliminated) -> kkt.Solution:
        axes = self.tracer.axes
        return projection.chord_correction(self.model, by, self.now, self.x, self.mu, self.mask, axes)

    def moved(self, x: list[Number]) -> tuple[tuple[State, ...], Number]:
        rotation: Number = 0.0
        for i in range(self.tracer.k):
            u = tuple(x[6 * i + 3 : 6 * i + 6])
            rotation = maximum(at_most(so3.dot(u, u), codes.LARGEST_STAGE), rotation)
        return projection.placed(self.hat.bodies, x), rotation


class _Embedded(_Iteration):
    def solution(self) -> kkt.Solution:
        return embedded.correction(self.model, self.tracer.structure, self.now, self.hat.bodies, self.mask)

    def chord(self, by: kkt.Eliminated) -> kkt.Solution:
        return embedded.chord_correction(self.model, by, self.now, self.hat.bodies, self.mu, self.mask)

    def moved(self, x: list[Number]) -> tuple[tuple[State, ...], Number]:
        return embedded.placed(self.now.bodies, x), 0.0

    def violation(self, now: Instant, counts: list[Number]) -> Number:
        return maximum(embedded.violation(now.bodies), super().violation(now, counts))


FORMS: dict[str, type[_Iteration]] = {"joint": _Joint, "local": _Local, "embedded": _Embedded}
