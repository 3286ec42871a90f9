"""The kernels of one mechanism and one method: what the driver calls.

    step       state -> state, code                 one Munthe-Kaas step (clock: t, h)
    position   q^, (state, x) -> state, x+, violation, code     one Gauss-Newton iteration of the position projection
    velocity   state -> state, violation, code      the velocity projection
    observe    state -> what is stored beside the state

Every row is a vector of W runs. A code of 0 is good; see `lienumba.integrators.codes`. Each kernel has a graph of its
own, so that what is observed can never change how a step is computed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ALGEBRA, ELEMENT
from lienumba.integrators import codes, munthe_kaas
from lienumba.integrators.tableaus import TABLEAUS
from lienumba.mechanics import constraints, dynamics, kkt, projection
from lienumba.mechanics.model import Model, map_numbers
from lienumba.operations import where

INLINE = 1500  # operations of a stage up to which a step is traced as a whole; beyond, it calls the stage
HUGE = 1e300


@dataclass(frozen=True)
class Method:
    """What beside the mechanism shapes the kernels."""

    tableau: str
    position: str  # "local" or "none"
    velocity: str  # "mass", "identity" or "none"


@dataclass(frozen=True)
class Slot:
    """A number of the model that is read at run time, from this row of the parameters."""

    row: int


@dataclass
class Program:
    """`parameters`: the model's numbers behind the slots (floats or arrays); `observed`: name -> (first row, rows)."""

    bodies: int
    parameters: list[Any]
    parameter_rows: int
    kernels: dict[str, Kernel]
    observed: dict[str, tuple[int, int]]


def split(model: Model) -> tuple[Model, list[Any]]:
    """The model with slots for its parameters, and their values. Exact 0, 1, -1 in structural places stay."""
    values: list[Any] = []

    def number(value: Any, structural: bool) -> Any:
        if structural and isinstance(value, float | int) and value in (0, 1, -1):
            return float(value)
        values.append(value)
        return Slot(len(values) - 1)

    return map_numbers(model, number), values


class _Tracer:
    """Runs the mechanics on symbols, one graph per kernel."""

    def __init__(self, model: Model, method: Method) -> None:
        self.template, self.values = split(model)
        self.structure = kkt.Structure.of(model)
        self.tableau = TABLEAUS[method.tableau]
        self.method = method
        self.k = len(model.bodies)
        self.rows = len(self.values)  # of parameters and what is hoisted behind them

    def graph(self) -> tuple[Graph, Model]:
        graph = Graph()
        model = map_numbers(self.template, lambda x, _: graph.input("parameters", x.row) if isinstance(x, Slot) else x)
        return graph, model

    def kernel(self, name: str, outputs: Any) -> Kernel:
        kernel = Kernel(name, tuple(outputs), self.rows)
        self.rows += len(kernel.hoisted)
        return kernel

    def state(self, graph: Graph, array: str) -> tuple[Any, ...]:
        return tuple(graph.inputs(array, ELEMENT, ELEMENT * i) for i in range(self.k))

    def field(self, model: Model, margins: list[Any]) -> Callable[[Any], Any]:
        """F of eq. (15): velocities and accelerations at a state; the margins of the KKT are noted aside."""

        def F(bodies: Any) -> Any:
            solution = dynamics.accelerations(model, self.structure, bodies)
            margins.append(solution.margin)
            a = solution.x
            return tuple((*x[12:18], *a[6 * i : 6 * i + 6]) for i, x in enumerate(bodies))

        return F

    def stage(self, name: str) -> Kernel:
        """The slope at x exp(u), or with the name "first" at x, as a kernel of its own; extra: u.

        Its last output is the KKT's margin.
        """
        graph, model = self.graph()
        margins: list[Any] = []
        F, x = self.field(model, margins), self.state(graph, "state")
        u = tuple(graph.inputs("extra", ALGEBRA, ALGEBRA * i) for i in range(self.k))
        f = F(x) if name == "first" else munthe_kaas.slope(x, u, F, self.tableau.order)
        return self.kernel(name, (*flat(f), margins[0]))

    def step(self) -> Kernel:
        before = self.rows
        stage = self.stage("stage")
        graph, model = self.graph()
        margins: list[Any] = []
        if stage.counts()["operations"] <= INLINE:
            self.rows = before
            F = self.field(model, margins)

            def slope(x: Any, u: Any, t: Any) -> Any:
                return F(x) if u is None else munthe_kaas.slope(x, u, F, self.tableau.order)

        else:
            first = self.stage("first")

            def slope(x: Any, u: Any, t: Any) -> Any:
                kernel, arguments = (first, ()) if u is None else (stage, tuple(flat(u)))
                *f, margin = graph.call(kernel, arguments, ALGEBRA * self.k + 1)
                margins.append(margin)
                return tuple(tuple(f[ALGEBRA * i : ALGEBRA * (i + 1)]) for i in range(self.k))

        t, h = graph.inputs("clock", 2)
        x = self.state(graph, "state")
        new, rotation, square = munthe_kaas.step(self.tableau, x, t, h, slope)
        code = where(rotation < munthe_kaas.LARGEST_STAGE, 0.0, codes.ROTATION)
        if self.structure.rows:
            code = where(margins[0] > 0.0, code, codes.SINGULAR)
        return self.kernel("step", (*flat(new), where(square < HUGE, code, codes.NON_FINITE)))

    def position(self) -> Kernel:
        graph, model = self.graph()
        hat, now = self.state(graph, "state"), self.state(graph, "extra")
        x = graph.inputs("extra", 6 * self.k, ELEMENT * self.k)
        solution = projection.position_correction(model, self.structure, now, list(x))
        rotation = munthe_kaas.promised([(0.0, 0.0, 0.0, *solution.x[6 * i + 3 : 6 * i + 6]) for i in range(self.k)])
        new = projection.placed(hat, solution.x)
        violation = projection.largest(constraints.residual(model, new))
        violation = where(violation <= projection.position_floor(new), 0.0, violation)
        code = where(rotation < munthe_kaas.LARGEST_STAGE, 0.0, codes.NOT_CONVERGED)
        code = where(solution.margin > 0.0, code, codes.SINGULAR)
        code = where(finite(solution.x), code, codes.NON_FINITE)
        return self.kernel("position", (*flat(new), *solution.x, violation, code))

    def velocity(self) -> Kernel:
        graph, model = self.graph()
        state = self.state(graph, "state")
        solution = projection.velocity_correction(model, self.structure, state, self.method.velocity)
        new = tuple(
            body[0:12] + tuple(v + x for v, x in zip(body[12:18], solution.x[6 * i : 6 * i + 6], strict=True))
            for i, body in enumerate(state)
        )
        violation = projection.largest(constraints.rate_and_bias(model, new)[0])
        violation = where(violation <= projection.velocity_floor(new), 0.0, violation)
        code = where(solution.margin > 0.0, 0.0, codes.SINGULAR)
        code = where(finite(solution.x), code, codes.NON_FINITE)
        return self.kernel("velocity", (*flat(new), violation, code))

    def observe(self) -> tuple[Kernel, dict[str, tuple[int, int]]]:
        graph, model = self.graph()
        state = self.state(graph, "state")
        solution = dynamics.accelerations(model, self.structure, state)
        kinetic, potential = dynamics.energies(model, state)
        force, torque = constraints.loads(model, state, solution.mu)
        named = {
            "kinetic_energy": [kinetic],
            "potential_energy": [potential],
            "position_violation": [projection.largest(constraints.residual(model, state))],
            "velocity_violation": [projection.largest(constraints.rate_and_bias(model, state)[0])],
            "multiplier": solution.mu,
            "joint_force": force,
            "joint_torque": torque,
        }
        observed: dict[str, tuple[int, int]] = {}
        outputs: list[Any] = []
        for name, rows in named.items():
            observed[name] = (len(outputs), len(rows))
            outputs += rows
        return self.kernel("observe", outputs), observed


def flat(bodies: Any) -> list[Any]:
    return [x for body in bodies for x in body]


def finite(rows: list[Any]) -> Any:
    """Whether the sum of squares is an ordinary number: false for NaN and for infinities."""
    total: Any = 0.0
    for row in rows:
        total = total + row * row
    return total < HUGE


def build(model: Model, method: Method) -> Program:
    """Trace every kernel that this mechanism and method need."""
    tracer = _Tracer(model, method)
    kernels = {"step": tracer.step()}
    if tracer.structure.rows and method.position != "none":
        kernels["position"] = tracer.position()
    if tracer.structure.rows and method.velocity != "none":
        kernels["velocity"] = tracer.velocity()
    kernels["observe"], observed = tracer.observe()
    return Program(tracer.k, tracer.values, tracer.rows, kernels, observed)
