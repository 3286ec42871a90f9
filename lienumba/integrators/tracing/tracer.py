"""Runs the mechanics of one mechanism on symbols, one graph per kernel."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ELEMENT, State
from lienumba.integrators import codes, layout
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS, Chart
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.tracing.augmented_state import AugmentedState, counted_angles
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.system import dynamics, kkt
from lienumba.numerics.number import Condition, Number, Vector
from lienumba.numerics.operations import is_zero


@dataclass(frozen=True)
class Method:
    """What beside the mechanism shapes the kernels."""

    tableau: str
    position: str  # "local", "embedded" or "none"
    velocity: str  # one of projection.WEIGHTS, or "none"
    dexpinv: int | str | None = None  # terms of its series, or "closed"; None: as many as the method's order needs
    chord: bool = False  # whether the position projection keeps the elimination of its first iteration
    group: str = "R3xSO3"  # or another of GROUPS
    coordinates: str = "lie"  # or one of COORDINATES
    baumgarte: float | None = None  # rate (1/s)
    queued: bool = False  # whether every lane has its own time and takes its runs from a queue
    adaptive: bool = False  # whether a tolerance chooses the steps; then lanes are queued, too

    def chart(self) -> Chart:
        """A method of order p needs ad^j in dexpinv up to j = p - 2; one with several exponentials has no dexpinv."""
        if self.coordinates != "lie":
            return COORDINATES[self.coordinates]
        tableau = METHODS[self.tableau]
        terms = 0 if tableau.composed else max(tableau.order - 2, 0)
        given = None if self.dexpinv == "closed" else int(terms if self.dexpinv is None else self.dexpinv)
        return GROUPS[self.group](given)


@dataclass(frozen=True)
class Slot:
    """A number of the model that is read at run time, from this row of the parameters."""

    row: int


def split(model: Model) -> tuple[Model, list[Any]]:
    """The template of a model, with slots for its parameters, and their values. Exact 0, 1, -1 in structural places
    stay."""
    values: list[Any] = []

    def slot(value: Any) -> Slot:
        values.append(value)
        return Slot(len(values) - 1)

    def number(value: Any, structural: bool) -> Any:
        known = structural and isinstance(value, float | int) and value in (0, 1, -1)
        return float(value) if known else slot(value)

    return map_numbers(model, number, slot), values


def symbolic(template: Model) -> tuple[Graph, Model]:
    """A graph, and the model with its inputs in the slots."""
    graph = Graph()

    def number(x: Any, structural: bool = False) -> Any:
        return graph.input("parameters", x.row) if isinstance(x, Slot) else x

    return graph, map_numbers(template, number, number)


class Tracer:
    """`template`: all that is known of the model (see `split`), so that its numbers cannot shape a kernel; `structure`:
    of the rows in use; `whole`: of all rows, of which the exchangeable ones may be masked; `augmented`, `law_states`:
    what a state has beside the bodies; `k`: bodies, `elements`: of S, those of the bodies first; `sizes`: see
    `layout.Sizes`, without what only finished kernels tell."""

    def __init__(self, template: Model, method: Method, selection: RowSelection, fixed: bool) -> None:
        self.template = template
        graph, model = self.graph()
        self.whole = kkt.Structure.of(model, selection.rows, (), selection.singular)
        self.structure = kkt.Structure.of(model, (), selection.dropped, selection.singular) if fixed else self.whole
        self.tableau = METHODS[method.tableau]
        self.method = method
        self.chart = method.chart()
        self.k = len(model.bodies)
        bodies = tuple(graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(self.k))
        now = Instant(bodies, graph.input("clock", layout.TIME))
        self.law_states = LawStates.of(model, now)
        self.elements = self.k + self.law_states.elements
        looped, angles, stages = self.structure.looped, counted_angles(model, now), len(self.tableau.b)
        self.augmented = AugmentedState(
            angles=angles,
            work=self._works(angles),
            accelerations=12 * self.k if looped else 0,
            masks=selection.rows if looped else (),
            fixed=dict(zip(selection.rows, selection.masks, strict=True)) if fixed else {},
        )
        self.sizes = layout.Sizes(
            elements=self.elements, augmented=self.augmented.rows,
            first_mask=self.augmented.first_mask, exchangeable=len(self.augmented.masks),
            fixed=int(bool(self.augmented.fixed)), coordinates=self.chart.size, stages=stages,
            slopes=len(self.tableau.stages) + 1 if method.queued else stages, events=len(model.events),
            correction=sum(self.correction_rows),
        )  # fmt: skip

    @property
    def correction_rows(self) -> tuple[int, int]:
        """Of the correction of positions from q^ in local coordinates, six for every element; of the multipliers, as a
        chord method."""
        x = 6 * self.elements if self.method.position == "local" else 0
        return x, self.structure.rows if self.method.chord else 0

    @property
    def reports_accelerations(self) -> bool:
        """Whether stages report the accelerations that are carried on, because slopes in this chart are others."""
        return bool(self.augmented.accelerations) and not self.chart.plain

    def strict(self, rotation: Number) -> Number:
        """A squared rotation of a body in a step (rad^2). Where turns are counted, it is made so much larger that the
        limit is a quarter of a turn: two bodies then turn by less than half a turn relative to each other."""
        return rotation * (codes.LARGEST_STAGE / (0.5 * pi) ** 2) if self.augmented.angles else rotation

    def expected(self, augmented: Vector, node: Number, h: Number) -> list[Number] | None:
        """The accelerations to be expected in a stage at t + node h; None if they are not carried on."""
        return self.augmented.expected(augmented, (node + (1.0 - float(self.tableau.c[-1]))) * h)

    def _works(self, angles: tuple[int, ...]) -> bool:
        """Whether anything ever works on the system: else the power is zero by its structure."""
        graph, model = self.graph()
        state, t = self.state(graph, "state"), graph.input("clock", layout.TIME)
        near = dict(zip(angles, graph.inputs("state", len(angles), ELEMENT * self.elements), strict=True))
        now = Instant(state[: self.k], t, near, None, self.law_states.read(state[self.k :]))
        return not is_zero(dynamics.power(model, now, list(graph.inputs("extra", self.structure.rows))))

    def graph(self) -> tuple[Graph, Model]:
        return symbolic(self.template)

    def kernel(self, name: str, outputs: Iterable[Number], rows: Sequence[int] | None = None) -> Kernel:
        """A kernel that puts its outputs into these rows, by default one after the other. Where its
        invariants go, is said last."""
        return Kernel(name, tuple(outputs), 0, None if rows is None else tuple(rows))

    def state(self, graph: Graph, array: str) -> tuple[State, ...]:
        """The elements of S: bodies, and behind them the states of laws."""
        return tuple(graph.inputs(array, ELEMENT, ELEMENT * i) for i in range(self.elements))

    def instant(self, state: Sequence[State], augmented: Vector, t: Number, within: Number | None = None) -> Instant:
        angles = dict(zip(self.augmented.angles, augmented, strict=False))
        return Instant(tuple(state[: self.k]), t, angles, within, self.law_states.read(state[self.k :]))

    def now(self, graph: Graph) -> tuple[Instant, list[Number]]:
        """The state at the clock's time, and the mask of its rows."""
        augmented = self.augmented_rows(graph)
        instant = self.instant(self.state(graph, "state"), augmented, graph.input("clock", layout.TIME))
        return instant, self.augmented.mask(augmented, self.structure.rows)

    def augmented_rows(self, graph: Graph) -> Vector:
        return graph.inputs("state", self.augmented.rows, ELEMENT * self.elements)

    def with_law_states(self, graph: Graph, bodies: Sequence[State]) -> list[Number]:
        """The rows of these bodies, and of the law states as they are."""
        return flat((*bodies, *self.state(graph, "state")[self.k :]))


def flat(elements: Iterable[Vector]) -> list[Number]:
    return [x for element in elements for x in element]


def finite(rows: Iterable[Number]) -> Condition:
    """Whether the sum of squares is an ordinary number: false for NaN and for infinities."""
    total: Number = 0.0
    for row in rows:
        total = total + row * row
    return total < codes.HUGE
