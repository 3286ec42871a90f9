"""Runs the mechanics of one mechanism on symbols, one graph per kernel."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol

from lienumba.compiler.emit import Kernel
from lienumba.compiler.series import Linear
from lienumba.compiler.symbols import Graph
from lienumba.groups import so3
from lienumba.groups.state import ELEMENT, Algebra, State
from lienumba.integrators import codes, layout
from lienumba.integrators.methods import METHODS, step_control
from lienumba.integrators.methods.charts import Chart
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing.augmented_state import AugmentedState, counted_angles
from lienumba.integrators.tracing.law_states import NUMBERS, RATES, LawStates, sampled
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.integrators.tracing.template import symbolic
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Counted, Model
from lienumba.mechanics.system import axes_choice, constraints, dynamics, kkt, projection
from lienumba.mechanics.system.body_axes import GLOBAL, Axes
from lienumba.mechanics.system.switches import modes_of, permanent, resting, switches_of
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero

BODIES = "bodies"  # their states, where what is integrated does not have them


class Correction(Protocol):
    """A solution of a projection, see `kkt.Solution`."""

    @property
    def x(self) -> list[Any]: ...
    @property
    def mu(self) -> list[Any]: ...
    @property
    def nonsingular(self) -> Any: ...
    @property
    def row_weights(self) -> list[Any]: ...


class Part(NamedTuple):
    """Rows of a state of one kind: see `step_control.Tolerance`. A rotation is a matrix, or a cosine and a sine."""

    kind: int
    rows: range


class Posture(Protocol):
    """A mechanism at a state."""

    @property
    def now(self) -> Instant: ...
    def resting(self) -> "Posture":
        """The mechanism with no joint sliding with friction."""
        ...


@dataclass(frozen=True)
class Still:
    """Bodies as they are."""

    now: Instant

    def resting(self) -> "Still":
        return Still(replace(self.now, modes=resting(self.now.modes)))


@dataclass(frozen=True)
class Dynamics:
    """accelerations: of all velocities, as closed loops carry them on; multipliers of all rows; nonsingular and
    margin: see `kkt.Solution`."""

    accelerations: list[Number]
    multipliers: list[Number]
    nonsingular: Number
    margin: Number


class Tracer:
    """`template`: all that is known of the model (see `split`), so that its numbers cannot shape a kernel; `structure`:
    of the rows in use; `whole`: of all permanent rows, of which the exchangeable ones may be masked; `augmented`,
    `law_states`: what a state has beside the bodies; `k`: bodies, `elements`: of S, those of the bodies first; `sizes`:
    see `Sizes`, without what only finished kernels tell; `integrands`: the numbers of the signals that a step
    integrates by the weights of its stages."""

    def __init__(self, template: Model, method: Method, selection: RowSelection, fixed: bool) -> None:
        self.template = template
        self.graphs: list[Graph] = []
        self.integrands: tuple[int, ...] = ()
        graph, model = self.graph()
        self.whole = kkt.Structure.of(permanent(model), selection.rows, (), selection.singular)
        self.tableau = METHODS[method.tableau]
        self.method = method
        self.k = len(model.bodies)
        bodies = tuple(graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(self.k))
        now = Instant(bodies, graph.input("clock", layout.TIME))
        self.law_states = LawStates.of(model, now)
        coasts = method.adaptive and not method.order
        self.structure = replace(self._structure(model, selection, fixed), coasts=coasts)
        self.elements, self.element, self.velocities = self._elements(model)
        looped, stages = self.structure.looped, len(self.tableau.b)
        slopes = len(self.tableau.stages) + 1 if method.extended else stages
        angles = counted_angles(model, now, method.joint_coordinates)
        works = self._works(angles)
        rates = self.velocities + sum(self.law_states.sizes.values()) + works
        self.augmented = AugmentedState(
            angles=angles,
            work=works,
            accelerations=2 * self.velocities if looped else 0,
            masks=selection.rows if looped else (),
            fixed=dict(zip(selection.rows, selection.masks, strict=True)) if fixed else {},
            switches=switches_of(model),
            permanent=constraints.permanent_rows(model),
            history=1 + 2 * rates if self.tableau.carries else 0,
        )
        self.chart = self.chart_of(model)
        self.sizes = Sizes(
            elements=self.elements, element=self.element, augmented=self.augmented.rows,
            first_mask=self.augmented.first_mask, exchangeable=len(self.augmented.masks),
            fixed=int(bool(self.augmented.fixed)), coordinates=self.chart.size, stages=stages,
            slopes=slopes, events=len(model.events),
            correction=sum(self.correction_rows),
            first_mode=self.augmented.first_mode, switched=self.augmented.switched,
            switches=len(self.augmented.switches), memory=self.augmented.memory,
            work=len(angles), values=sum(len(event.numbers) for event in model.events),
            history=self.augmented.history, first_history=self.augmented.first_history, weakens=int(self.weakens),
        )  # fmt: skip

    def _structure(self, model: Model, selection: RowSelection, fixed: bool) -> kkt.Structure:
        masked, dropped = ((), selection.dropped) if fixed else (selection.rows, ())
        return kkt.Structure.of(model, masked, dropped, selection.singular)

    def _elements(self, model: Model) -> tuple[int, int, int]:
        """How many elements of S there are, their rows, and how many velocities."""
        return self.k + self.law_states.elements, ELEMENT, 6 * self.k

    def chart_of(self, model: Model) -> Chart:
        """The chart of each element, for this model on symbols."""
        return self.method.chart()

    @cached_property
    def axes(self) -> Axes:
        """The axes of the equations of bodies, in steps and in projections."""
        if not self.chart.orthogonal:
            return GLOBAL
        graph, model = self.graph()
        dropped = [row for row, used in self.augmented.fixed.items() if not used]
        return axes_choice.cheapest(graph, model, self.structure, self.now(graph, model)[0].now, dropped)

    @property
    def correction_rows(self) -> tuple[int, int]:
        """The rows of a correction of positions: local coordinates from q^, and the multipliers of a chord method."""
        x = self.velocities if self.method.position == "local" else 0
        return x, self.structure.rows if self.method.chord else 0

    @property
    def weakens(self) -> bool:
        """Whether it is looked at where constraints may lose their rank, because steps are chosen: by their errors, or
        such that implicit ones do not end there."""
        return self.structure.looped and (self.method.adaptive or self.tableau.implicit)

    @property
    def reports_accelerations(self) -> bool:
        """Whether stages report the accelerations that are carried on, because slopes in this chart are others."""
        return bool(self.augmented.accelerations) and not self.chart.plain

    def strict(self, rotation: Number) -> Number:
        """A squared rotation of a body in a step (rad^2) as `codes.strict` has it."""
        contacts = self.template.contacts
        return codes.strict(rotation, bool(self.augmented.angles), any(CONTACTS[x.type].turns(x) for x in contacts))

    def expected(self, augmented: Vector, node: Number, h: Number) -> list[Number] | None:
        """The accelerations to be expected in a stage at t + node h; None if they are not carried on."""
        return self.augmented.expected(augmented, (node + (1.0 - float(self.tableau.c[-1]))) * h)

    def _works(self, angles: tuple[Counted, ...]) -> bool:
        """Whether anything ever works on the system: else the power is zero by its structure."""
        graph, model = self.graph()
        bodies = tuple(graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(self.k))
        switches = switches_of(model)
        memory = sum(switch.memories for switch in switches)
        more = len(angles) + sum(self.law_states.sizes.values()) + len(switches) + memory
        others = iter(graph.inputs("extra", self.structure.rows + more))
        mu = [next(others) for _ in range(self.structure.rows)]
        near = {joint: next(others) for joint in angles}
        states = {name: tuple(next(others) for _ in range(size)) for name, size in self.law_states.sizes.items()}
        modes = modes_of(model, [next(others) for _ in switches], [next(others) for _ in range(memory)])
        now = Instant(bodies, graph.input("clock", layout.TIME), near, None, states, modes)
        return bool(switches or model.held) or not is_zero(dynamics.power(model, now, mu))

    def graph(self, graph: Graph | None = None) -> tuple[Graph, Model]:
        graph, model = symbolic(self.template, graph)
        self.graphs.append(graph)
        return graph, model

    def close(self) -> None:
        """Every kernel is traced."""
        for graph in self.graphs:
            graph.close()

    def kernel(self, name: str, outputs: Iterable[Number], rows: Sequence[int] | None = None) -> Kernel:
        """A kernel that puts its outputs into these rows, by default one after the other. Where its
        invariants go, is said last."""
        return Kernel(name, tuple(outputs), 0, None if rows is None else tuple(rows))

    def state(self, graph: Graph, array: str) -> tuple[State, ...]:
        """The elements of S: bodies, and behind them the states of laws."""
        return tuple(graph.inputs(array, self.element, self.element * i) for i in range(self.elements))

    def posture(
        self, model: Model, state: Sequence[State], augmented: Vector, t: Number, within: Number | None = None
    ) -> Posture:
        """The mechanism at a state."""
        angles = dict(zip(self.augmented.angles, augmented, strict=False))
        states, modes = self.law_states.read(state[self.k :]), self.augmented.modes(model, augmented)
        return Still(Instant(tuple(state[: self.k]), t, angles, within, states, modes))

    def now(self, graph: Graph, model: Model, leans: bool = False) -> tuple[Posture, list[Number]]:
        """The mechanism at the clock's time, and the mask of its rows; leans: at an end of a step as seen from it."""
        augmented, t = self.augmented_rows(graph), graph.input("clock", layout.TIME)
        within = t + graph.input("clock", layout.LEAN) if leans else None
        return self.posture(model, self.state(graph, "state"), augmented, t, within), self.mask(augmented)

    def mask(self, augmented: Vector) -> list[Number]:
        """1 or 0 for each row of C."""
        return self.augmented.mask(augmented, self.structure.rows)

    def augmented_rows(self, graph: Graph) -> Vector:
        return graph.inputs("state", self.augmented.rows, self.element * self.elements)

    def moving(
        self, model: Model, posture: Posture, mask: list[Number], expected: list[Number] | None
    ) -> tuple[list[Algebra], Dynamics]:
        """F (Terze et al. 2015, eq. 15) of every element, and what is known with it."""
        now, damping = posture.now, self.method.baumgarte
        solution = dynamics.accelerations(model, self.structure, now, mask, expected, damping, self.axes)
        a = solution.x
        moving = [(*x[12:18], *a[6 * i : 6 * i + 6]) for i, x in enumerate(now.bodies)]
        found = Dynamics(a, solution.mu, solution.nonsingular, solution.margin)
        return [*moving, *self.law_states.slopes(law_states.rates(model, now))], found

    def missing(
        self, model: Model, posture: Posture, mask: list[Number], a: Sequence[Number], mu: Sequence[Number],
        used: Sequence[int],
    ) -> list[Number]:  # fmt: skip
        """What the equations of motion leave over along all velocities of the chart and of the rows in use, for any
        rates of these and multipliers of all rows."""
        now, rates = posture.now, self.carried(model, posture.now.bodies, a)
        found = dynamics.missing(model, self.structure, now, mask, rates, mu, self.method.baumgarte)
        along = [self.chart.along(x, tuple(found[6 * i : 6 * i + 6])) for i, x in enumerate(now.bodies)]
        return [*flat(along), *(found[self.velocities + row] for row in used)]

    def reactions(self, model: Model, posture: Posture, mask: list[Number], mu: Sequence[Number]) -> list[Number]:
        """The multipliers of all rows from those of the rows in use."""
        return dynamics.reactions(model, self.structure, posture.now, mask, mu)

    @property
    def coordinates(self) -> tuple[range, range]:
        """The numbers of the coordinates of the chart that are places, and of those that are velocities."""
        return range(self.chart.size - 6), range(self.chart.size - 6, self.chart.size)

    @property
    def moving_elements(self) -> int:
        """Without those that are states of laws alone."""
        return self.k

    @cached_property
    def used(self) -> tuple[int, ...]:
        """The rows of C in use, ascending."""
        rows = (v - 6 * self.structure.bodies for v in self.structure.order)
        return tuple(sorted(row for row in rows if row >= 0))

    def field(self, model: Model, state: Sequence[State], a: Sequence[Number], laws: Sequence[Number]) -> list[Vector]:
        """F of every element, from the rates of the velocities of the chart and of laws' states."""
        own = self.carried(model, state, a)
        moving = [(*x[12:18], *own[6 * i : 6 * i + 6]) for i, x in enumerate(state[: self.k])]
        return [*moving, *self.law_states.slopes(self.law_states.apart(laws))]

    def gathered(self, q: Sequence[Number], v: Sequence[Number], laws: Sequence[Number]) -> list[Vector]:
        """The coordinates of every element, from those of the places and velocities and from laws' states."""
        places, velocities = (len(part) for part in self.coordinates)
        own = [(*q[places * i : places * (i + 1)], *v[velocities * i : velocities * (i + 1)]) for i in range(self.k)]
        return [*own, *self.law_states.slopes(self.law_states.apart(laws))]

    def apart(self, u: Sequence[Vector]) -> tuple[list[Number], list[Number], list[Number]]:
        """The places, the velocities and laws' states among the coordinates of every element."""
        places, velocities = self.coordinates
        laws = [x for element in u[self.k :] for x in (element[row] for row in RATES)]
        q, v = (
            [x for element in u[: self.k] for x in element[part.start : part.stop]] for part in (places, velocities)
        )
        return q, v, laws[: sum(self.law_states.sizes.values())]

    def carried(self, model: Model, state: Sequence[State], a: Sequence[Number]) -> list[Number]:
        """Accelerations as closed loops carry them on, from the rates of the velocities of the chart."""
        return flat(self.chart.accelerations(x, tuple(a[6 * i : 6 * i + 6])) for i, x in enumerate(state[: self.k]))

    def law_rates(self, model: Model, now: Instant) -> list[Number]:
        """The rates of the states of all laws; 0 of those that are sampled or held."""
        return self.law_states.together(law_states.rates(model, now))

    def law_rows(self) -> list[int]:
        """The rows of a state in which the states of laws are."""
        first = ELEMENT * self.k
        numbers = range(sum(self.law_states.sizes.values()))
        return [first + ELEMENT * (n // len(NUMBERS)) + NUMBERS[n % len(NUMBERS)] for n in numbers]

    def held(self) -> tuple[int, ...]:
        """The rows of a state in which held numbers are."""
        rows = self.law_rows()
        return tuple(rows[n] for n in self.law_states.held())

    def rates(self, model: Model, state: Sequence[State], F: Sequence[Vector]) -> list[Number]:
        """How every row of the elements changes, where F is of them."""
        found: list[Number] = []
        for n, (x, f) in enumerate(zip(state, F, strict=True)):
            if n < self.k:
                found += [*f[0:3], *so3.turning(x[3:12], f[3:6]), *f[6:12]]
            else:
                found += [f[RATES[NUMBERS.index(i)]] if i in NUMBERS else 0.0 for i in range(self.element)]
        return found

    def parts(self, model: Model) -> list[Part]:
        """What the rows of the elements are."""
        found: list[Part] = []
        for first in range(0, ELEMENT * self.k, ELEMENT):
            every = zip((0, 1, 2, 3), ((0, 3), (3, 12), (12, 15), (15, 18)), strict=True)
            found += [Part(kind, range(first + a, first + b)) for kind, (a, b) in every]
        behind = range(self.k, self.elements)
        return [*found, *(Part(4, range(ELEMENT * i + n, ELEMENT * i + n + 1)) for i in behind for n in NUMBERS)]

    def moving_implicitly(
        self, graph: Graph, model: Model, posture: Posture, mask: list[Number]
    ) -> tuple[list[Vector], Dynamics, Linear] | None:
        """As `moving`, with the accelerations as numbers that equations say; None where they are eliminated in every
        order."""
        return None

    def velocity_rows(self, model: Model) -> list[int]:
        """Where the velocities are in the elements."""
        return [ELEMENT * i + n for i in range(self.k) for n in range(12, 18)]

    def observed(
        self, model: Model, posture: Posture, mask: list[Number], expected: list[Number] | None
    ) -> tuple[list[Number], list[Number]]:
        """The accelerations of all bodies (6 k), and the multipliers of all rows."""
        solution = dynamics.accelerations(model, self.structure, posture.now, mask, expected, self.method.baumgarte)
        return solution.x, solution.mu

    def reported(
        self, model: Model, posture: Posture, mask: list[Number], expected: list[Number] | None, found: Dynamics
    ) -> tuple[list[Number], list[Number]]:
        """The accelerations of all bodies and the multipliers of all rows, from what `moving` has found."""
        return found.accelerations, constraints.globally(model, posture.now, found.multipliers, self.axes)

    def error_square(
        self, graph: Graph, model: Model, estimates: Sequence[Sequence[Vector]], x: Sequence[State], y: Sequence[State]
    ) -> Number:
        """The squared error of a step from x to y as a fraction of what is allowed: of all elements the worst; infinite
        if one is not finite. estimates: of each element one or two (see `step_control.error_square`)."""
        tolerance = graph.inputs("clock", layout.TOLERANCES, layout.TOLERANCE)
        squares = [
            step_control.error_square(z, a, b, tolerance) for z, a, b in zip(estimates[: self.k], x, y, strict=False)
        ]
        for z, a, b in zip(estimates[self.k :], x[self.k :], y[self.k :], strict=True):
            for rate, number in zip(RATES, NUMBERS, strict=True):
                changes = tuple(e[rate] for e in z)
                squares.append(step_control.state_error_square(changes, a[number], b[number], tolerance))
        return step_control.worst(squares)

    def allowed(self, model: Model, posture: Posture, mask: list[Number], change: list[Number]) -> list[Number]:
        """The part of a change of the velocities of the chart that the constraints allow."""
        now, bodies = posture.now, posture.now.bodies
        still = self.carried(model, bodies, [0.0] * self.velocities)
        own = [a - b for a, b in zip(self.carried(model, bodies, change), still, strict=True)]
        found = projection.tangential(model, self.structure, now, mask, own, self.axes)
        return flat(self.chart.along(x, tuple(found[6 * i : 6 * i + 6])) for i, x in enumerate(bodies))

    def sampled(self, graph: Graph, model: Model, posture: Posture) -> list[Number]:
        """The elements after the laws whose time has come were sampled."""
        elements = self.law_states.placed(sampled(model, posture.now))
        return flat((*posture.now.bodies, *elements))

    def velocity_projected(
        self, graph: Graph, model: Model, posture: Posture, mask: list[Number]
    ) -> tuple[list[Number], Correction]:
        """The rows of the elements whose velocities fulfil the constraints, and the correction."""
        now, weight = posture.now, projection.WEIGHTS[self.method.velocity]
        solution = projection.velocity_correction(model, self.structure, now, weight, mask, self.axes)
        return self._pushed(graph, now.bodies, solution.x), solution

    def border(
        self, model: Model, posture: Posture, mask: list[Number], expected: list[Number] | None
    ) -> tuple[list[list[Number]], list[Number]]:
        """See `dynamics.border`."""
        return dynamics.border(model, self.structure, posture.now, mask, expected, self.method.baumgarte)

    def kicked(
        self, graph: Graph, model: Model, posture: Posture, mask: list[Number], impulses: Sequence[Number]
    ) -> tuple[list[Number], list[Number]]:
        """The rows of the elements after impulses along the switched rows, and the multipliers of all rows."""
        solution = dynamics.kicked(model, self.structure, posture.now, mask, impulses)
        return self._pushed(graph, posture.now.bodies, solution.x), solution.mu

    def _pushed(self, graph: Graph, bodies: Sequence[State], x: Sequence[Number]) -> list[Number]:
        """The rows of the elements with velocities changed by x."""
        new = tuple(
            body[0:12] + tuple(v + dv for v, dv in zip(body[12:18], x[6 * i : 6 * i + 6], strict=True))
            for i, body in enumerate(bodies)
        )
        return self.with_law_states(graph, new)

    def schur(self, model: Model, posture: Posture) -> tuple[list[Number], list[Number]]:
        """See `kkt.schur_complement`."""
        C = constraints.jacobian(permanent(model), posture.now)
        return kkt.schur_complement(self.whole, dynamics.shapes(model), C)

    def counted(self, solution: Correction, mask: list[Number], level: str) -> list[Number]:
        """See `projection.counted`."""
        return projection.counted(solution.row_weights, mask, level, self.structure.switched)

    def levels(self) -> set[str]:
        """On which levels there is something to be projected."""
        return {constraint.level for constraint in constraints.constraints_of(self.graph()[1]) if constraint.rows}

    def shown(self, now: Instant) -> dict[str, list[Number]]:
        """What is stored because the state does not say it as it is."""
        return {}

    def with_law_states(self, graph: Graph, bodies: Sequence[State]) -> list[Number]:
        """The rows of these bodies, and of the law states as they are."""
        return flat((*bodies, *self.state(graph, "state")[self.k :]))


def flat(elements: Iterable[Vector]) -> list[Number]:
    return [x for element in elements for x in element]
