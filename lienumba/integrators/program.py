"""The kernels of one mechanism and one method: what the driver calls.

    step       state -> state, code                 one Munthe-Kaas step (clock: t, h), or for large mechanisms
      first, stage     state, u -> slopes, sound         the slopes of one stage
      combine1, ...    slopes of a body -> u, rotation   the argument of a stage
      advance          state, slopes of a body -> state, rotation, square
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
    """`parameters`: the model's numbers behind the slots (floats or arrays); `nodes`: c of the tableau;
    `observed`: name -> (first row, rows)."""

    bodies: int
    parameters: list[Any]
    parameter_rows: int
    kernels: dict[str, Kernel]
    nodes: list[float]
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

    def kernel(self, name: str, outputs: Any, rows: tuple[int, ...] | None = None) -> Kernel:
        kernel = Kernel(name, tuple(outputs), self.rows, rows)
        self.rows += len(kernel.hoisted)
        return kernel

    def state(self, graph: Graph, array: str) -> tuple[Any, ...]:
        return tuple(graph.inputs(array, ELEMENT, ELEMENT * i) for i in range(self.k))

    def field(self, model: Model, sound: list[Any]) -> Callable[[Any], Any]:
        """F of eq. (15): velocities and accelerations at a state; whether each KKT was sound is noted aside."""

        def F(bodies: Any) -> Any:
            solution = dynamics.accelerations(model, self.structure, bodies)
            sound.append(solution.sound)
            a = solution.x
            return tuple((*x[12:18], *a[6 * i : 6 * i + 6]) for i, x in enumerate(bodies))

        return F

    def step(self) -> dict[str, Kernel]:
        """The step as one kernel, or as many if a stage is too long to be repeated in it."""
        before = self.rows
        stage = self.stage("stage")
        if stage.counts()["operations"] > INLINE:
            return {"stage": stage, "first": self.stage("first")} | self.body_kernels()
        self.rows = before
        graph, model = self.graph()
        sound: list[Any] = []
        F = self.field(model, sound)
        t, h = graph.inputs("clock", 2)
        new, rotation, square = munthe_kaas.step(
            self.tableau,
            self.state(graph, "state"),
            t,
            h,
            lambda x, u, t: F(x) if u is None else munthe_kaas.slope(x, u, F, self.tableau.order),
        )
        every = sound[0]
        for stage_sound in sound[1:]:
            every = every * stage_sound
        code = munthe_kaas.verdict(rotation, square, sound[0], every)
        return {"step": self.kernel("step", (*flat(new), code))}

    def stage(self, name: str) -> Kernel:
        """The slopes of all bodies at x exp(u), or with the name "first" at x; extra: u.

        Its outputs go to the rows of one stage among those of all (see `slope_row`); behind them stands whether the
        KKT was sound.
        """
        graph, model = self.graph()
        sound: list[Any] = []
        F, x = self.field(model, sound), self.state(graph, "state")
        u = tuple(graph.inputs("extra", ALGEBRA, ALGEBRA * i) for i in range(self.k))
        f = F(x) if name == "first" else munthe_kaas.slope(x, u, F, self.tableau.order)
        rows = [slope_row(i, len(self.tableau.b)) + c for i in range(self.k) for c in range(ALGEBRA)]
        return self.kernel(name, (*flat(f), sound[0]), (*rows, slope_row(self.k, len(self.tableau.b))))

    def body_kernels(self) -> dict[str, Kernel]:
        """What a step does with one body: u of each stage but the first, and the end; extra: the body's slopes."""
        kernels = {}
        for s, row in enumerate(self.tableau.A):
            if any(row):
                graph, _ = self.graph()
                u, rotation = munthe_kaas.combination(graph.input("clock", 1), row, self.slopes(graph, s))
                kernels[f"combine{s}"] = self.kernel(f"combine{s}", (*u, rotation))
        graph, _ = self.graph()
        x = graph.inputs("state", ELEMENT)
        slopes = self.slopes(graph, len(self.tableau.b))
        new, rotation, square = munthe_kaas.advanced(graph.input("clock", 1), self.tableau, x, slopes)
        return kernels | {"advance": self.kernel("advance", (*new, rotation, square))}

    def slopes(self, graph: Graph, stages: int) -> list[Any]:
        return [graph.inputs("extra", ALGEBRA, ALGEBRA * s) for s in range(stages)]

    def position(self) -> Kernel:
        graph, model = self.graph()
        hat, now = self.state(graph, "state"), self.state(graph, "extra")
        x = graph.inputs("extra", 6 * self.k, ELEMENT * self.k)
        solution = projection.position_correction(model, self.structure, now, list(x))
        rotation = munthe_kaas.promised([(0.0, 0.0, 0.0, *solution.x[6 * i + 3 : 6 * i + 6]) for i in range(self.k)])
        new = projection.placed(hat, solution.x)
        violation = projection.position_violation(model, new)
        code = where(rotation < munthe_kaas.LARGEST_STAGE, 0.0, codes.NOT_CONVERGED)
        code = where(solution.sound > 0.0, code, codes.SINGULAR)
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
        violation = projection.velocity_violation(model, new)
        code = where(solution.sound > 0.0, 0.0, codes.SINGULAR)
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
            "position_violation": [constraints.largest(constraints.residual(model, state))],
            "velocity_violation": [constraints.largest(constraints.rate_and_bias(model, state)[0])],
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


def slope_row(body: int, stages: int) -> int:
    """The first row of a body's slopes: 12 rows per stage, all stages of a body side by side."""
    return ALGEBRA * stages * body


def flat(bodies: Any) -> list[Any]:
    return [x for body in bodies for x in body]


def finite(rows: list[Any]) -> Any:
    """Whether the sum of squares is an ordinary number: false for NaN and for infinities."""
    total: Any = 0.0
    for row in rows:
        total = total + row * row
    return total < codes.HUGE


def build(model: Model, method: Method) -> Program:
    """Trace every kernel that this mechanism and method need."""
    tracer = _Tracer(model, method)
    kernels = tracer.step()
    if tracer.structure.rows and method.position != "none":
        kernels["position"] = tracer.position()
    if tracer.structure.rows and method.velocity != "none":
        kernels["velocity"] = tracer.velocity()
    kernels["observe"], observed = tracer.observe()
    nodes = [float(c) for c in tracer.tableau.c]
    return Program(tracer.k, tracer.values, tracer.rows, kernels, nodes, observed)
