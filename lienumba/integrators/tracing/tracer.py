"""Runs the mechanics of one mechanism on symbols, one graph per kernel."""

from dataclasses import dataclass, replace
from math import pi
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS, LARGEST_STAGE, Chart
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.tracing.augmented_state import Held, counted_angles
from lienumba.integrators.tracing.law_states import Carried
from lienumba.integrators.tracing.row_selection import Choice
from lienumba.mechanics.mechanism.kinematics import Instant, is_zero
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.system import dynamics, kkt


@dataclass(frozen=True)
class Method:
    """What beside the mechanism shapes the kernels."""

    tableau: str
    position: str  # "local", "embedded" or "none"
    velocity: str  # "mass", "identity" or "none"
    dexpinv: int | str | None = None  # terms of its series, or "closed"; None: as many as the method's order needs
    chord: bool = False  # whether the position projection keeps the elimination of its first iteration
    group: str = "R3xSO3"  # or another of GROUPS
    coordinates: str = "lie"  # or one of COORDINATES
    baumgarte: float | None = None  # rate (1/s)
    free: bool = False  # whether every lane has its own time
    paced: bool = False  # whether a tolerance chooses the steps; then lanes are free, too

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
    of the rows in use; `whole`: of all rows, of which the exchangeable ones may be masked; `held`; k: the number of
    bodies, of the elements of S with what is `carried` behind them; `stages` of a step; `slots`: slopes kept of each
    element: of the stages, where lanes are free also of F at the end and of the extension's stages; there the last one
    is F at the end as the next step has it."""

    def __init__(self, template: Model, parameters: int, method: Method, choice: Choice, fixed: bool) -> None:
        self.template = template
        graph, model = self.graph()
        self.whole = kkt.Structure.of(model, choice.rows, (), choice.singular)
        self.structure = kkt.Structure.of(model, (), choice.dropped, choice.singular) if fixed else self.whole
        self.tableau = METHODS[method.tableau]
        self.method = method
        self.chart = method.chart()
        self.stages = len(self.tableau.b)
        self.slots = len(self.tableau.stages) + 1 if method.free else self.stages
        self.k = len(model.bodies)
        bodies = tuple(graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(self.k))
        self.carried = Carried.of(model, Instant(bodies, graph.input("clock", 0)))
        self.elements = self.k + self.carried.elements
        self.rows = parameters  # and what is hoisted behind them
        self.held = Held(
            angles=counted_angles(model),
            work=False,
            accelerations=12 * self.k if self.structure.looped else 0,
            masks=choice.rows if self.structure.looped else (),
            fixed=dict(zip(choice.rows, choice.masks, strict=True)) if fixed else {},
        )
        self.held = replace(self.held, work=not is_zero(self._any_power()))

    @property
    def reported(self) -> bool:
        """Whether stages report the accelerations that are held, because slopes in this chart are others."""
        return bool(self.held.accelerations) and not self.chart.plain

    @property
    def reported_row(self) -> int:
        """The first row of these accelerations, seen from the first row of the stage's slopes."""
        return self.slope_row(self.elements + 1) + codes.REPORTS + codes.CONTROL

    def strict(self, rotation: Any) -> Any:
        """A squared rotation of a body in a step (rad^2). Where turns are counted, it is made so much larger that the
        limit is a quarter of a turn: two bodies then turn by less than half a turn relative to each other."""
        return rotation * (LARGEST_STAGE / (0.5 * pi) ** 2) if self.held.angles else rotation

    def expected(self, held: tuple[Any, ...], node: Any, h: Any) -> list[Any] | None:
        """The accelerations to be expected in a stage at t + node h; None if they are not held."""
        return self.held.expected(held, (node + (1.0 - float(self.tableau.c[-1]))) * h)

    def _any_power(self) -> Any:
        """The power at any state: zero by its structure if nothing ever works on the system."""
        graph, model = self.graph()
        now, _ = self.now(graph)
        return dynamics.power(model, now, list(graph.inputs("extra", self.structure.rows)))

    def graph(self) -> tuple[Graph, Model]:
        return symbolic(self.template)

    @property
    def state_rows(self) -> int:
        """See `scratch.state_rows`: where the slopes begin behind a state."""
        return ELEMENT * self.elements + self.held.rows + 4

    def slope_row(self, element: int, slot: int = 0) -> int:
        """See `scratch.slope_row`."""
        return self.chart.size * (self.slots * element + slot)

    def kernel(self, name: str, outputs: Any, rows: tuple[int, ...] | None = None) -> Kernel:
        kernel = Kernel(name, tuple(outputs), self.rows, rows)
        self.rows += len(kernel.hoisted)
        return kernel

    def state(self, graph: Graph, array: str) -> tuple[Any, ...]:
        """The elements of S: bodies, and behind them what is carried."""
        return tuple(graph.inputs(array, ELEMENT, ELEMENT * i) for i in range(self.elements))

    def instant(self, state: Any, held: tuple[Any, ...], t: Any, within: Any = None) -> Instant:
        angles = dict(zip(self.held.angles, held, strict=False))
        return Instant(tuple(state[: self.k]), t, angles, within, self.carried.read(state[self.k :]))

    def now(self, graph: Graph) -> tuple[Instant, list[Any]]:
        """The state at the clock's time, and the mask of its rows."""
        held = self.held_rows(graph)
        instant = self.instant(self.state(graph, "state"), held, graph.input("clock", 0))
        return instant, self.held.mask(held, self.structure.rows)

    def held_rows(self, graph: Graph) -> tuple[Any, ...]:
        return tuple(graph.inputs("state", self.held.rows, ELEMENT * self.elements))

    def with_carried(self, graph: Graph, bodies: Any) -> list[Any]:
        """The rows of these bodies, and of what the state carries."""
        return flat((*bodies, *self.state(graph, "state")[self.k :]))


def flat(bodies: Any) -> list[Any]:
    return [x for body in bodies for x in body]


def finite(rows: list[Any]) -> Any:
    """Whether the sum of squares is an ordinary number: false for NaN and for infinities."""
    total: Any = 0.0
    for row in rows:
        total = total + row * row
    return total < codes.HUGE
