"""The kernels of one mechanism and one method: what the driver calls.

    step       state -> state, code, margin         one Munthe-Kaas step (clock: t, h), or for large mechanisms
      first, stage     state, u -> slopes, sound, ...    the slopes of one stage
      combine1, ...    slopes of a body -> u, rotation   the argument of a stage
      advance          state, slopes of a body -> state, rotation, square
      finish           state, what the stages report -> what is held beside the bodies
    position   q^, (state, x) -> state, x+, violation, code     one Gauss-Newton iteration of the position projection
    velocity   state -> state, violation, code      the velocity projection
    observe    state -> what is stored beside the state
    exchange   state -> S of the rows that may be exchanged (see `lienumba.integrators.exchange`)

A state is 18 rows per body and what is held behind them (`lienumba.integrators.held`).
Every row is a vector of W runs. A code of 0 is good; see `lienumba.integrators.codes`. Each kernel has a graph of its
own, so that what is observed can never change how a step is computed.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ALGEBRA, ELEMENT
from lienumba.integrators import codes, munthe_kaas
from lienumba.integrators.held import Held, counted_angles
from lienumba.integrators.tableaus import TABLEAUS
from lienumba.mechanics import constraints, dynamics, kkt, projection
from lienumba.mechanics.model import Model, map_numbers
from lienumba.mechanics.motion import Instant, is_zero
from lienumba.operations import maximum, where

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
    held: Held
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


@dataclass
class _Reports:
    """What the stages of a step report beside their slopes."""

    sound: list[Any] = field(default_factory=list)
    power: list[Any] = field(default_factory=list)
    margin: list[Any] = field(default_factory=list)
    accelerations: list[Any] = field(default_factory=list)  # of the last stage


class _Tracer:
    """Runs the mechanics on symbols, one graph per kernel."""

    def __init__(self, model: Model, method: Method, masked: tuple[int, ...]) -> None:
        self.template, self.values = split(model)
        self.structure = kkt.Structure.of(model, masked)
        self.tableau = TABLEAUS[method.tableau]
        self.method = method
        self.k = len(model.bodies)
        self.rows = len(self.values)  # of parameters and what is hoisted behind them
        accelerations = 6 * self.k if self.structure.looped else 0
        self.held = Held(counted_angles(model), False, accelerations, masked)
        self.held = replace(self.held, work=not is_zero(self._any_power()))

    def _any_power(self) -> Any:
        """The power at any state: zero by its structure if nothing ever works on the system."""
        graph, model = self.graph()
        now, _ = self.now(graph)
        return dynamics.power(model, now, list(graph.inputs("extra", self.structure.rows)))

    def graph(self) -> tuple[Graph, Model]:
        graph = Graph()
        model = map_numbers(self.template, lambda x, _: graph.input("parameters", x.row) if isinstance(x, Slot) else x)
        return graph, model

    def kernel(self, name: str, outputs: Any, rows: tuple[int, ...] | None = None) -> Kernel:
        kernel = Kernel(name, tuple(outputs), self.rows, rows)
        self.rows += len(kernel.hoisted)
        return kernel

    def bodies(self, graph: Graph, array: str) -> tuple[Any, ...]:
        return tuple(graph.inputs(array, ELEMENT, ELEMENT * i) for i in range(self.k))

    def now(self, graph: Graph) -> tuple[Instant, list[Any]]:
        """The state at the clock's time, and the mask of its rows."""
        held = self.held_rows(graph)
        instant = self.held.instant(self.bodies(graph, "state"), held, graph.input("clock", 0))
        return instant, self.held.mask(held, self.structure.rows)

    def held_rows(self, graph: Graph) -> tuple[Any, ...]:
        return tuple(graph.inputs("state", self.held.rows, ELEMENT * self.k))

    def field(self, model: Model, held: tuple[Any, ...], reports: _Reports) -> Callable[[Any, Any], Any]:
        """F of eq. (15): velocities and accelerations at a state; what each stage reports is noted aside."""
        mask, expected = self.held.mask(held, self.structure.rows), self.held.expected(held)

        def F(bodies: Any, t: Any) -> Any:
            now = self.held.instant(bodies, held, t)
            solution = dynamics.accelerations(model, self.structure, now, mask, expected)
            reports.sound.append(solution.sound)
            reports.margin.append(solution.margin)
            if self.held.work:
                reports.power.append(dynamics.power(model, now, solution.mu))
            reports.accelerations = a = solution.x
            return tuple((*x[12:18], *a[6 * i : 6 * i + 6]) for i, x in enumerate(bodies))

        return F

    def held_after(self, model: Model, held: tuple[Any, ...], now: Instant, h: Any, reports: _Reports) -> list[Any]:
        """What is held after a step that ends at `now`."""
        rows = self.held.counted(model, now)
        if self.held.work:
            work = held[len(self.held.angles)]
            for b, power in zip(self.tableau.b, reports.power, strict=True):
                work = work + (h * float(b)) * power if b else work
            rows.append(work)
        if self.held.accelerations:
            rows += reports.accelerations
        if self.held.masks:
            rows += [*held[self.held.first_mask : -1], maximum(reports.margin[0], held[-1])]
        return rows

    def step(self) -> dict[str, Kernel]:
        """The step as one kernel, or as many if a stage is too long to be repeated in it."""
        before = self.rows
        stage = self.stage("stage")
        if stage.counts()["operations"] > INLINE:
            kernels = {"stage": stage, "first": self.stage("first")} | self.body_kernels()
            return kernels | ({"finish": self.finish()} if self.held.rows else {})
        self.rows = before
        graph, model = self.graph()
        held, reports = self.held_rows(graph), _Reports()
        F = self.field(model, held, reports)
        t, h = graph.inputs("clock", 2)
        order = self.tableau.order
        new, rotation, square = munthe_kaas.step(
            self.tableau,
            self.bodies(graph, "state"),
            t,
            h,
            lambda x, u, t: F(x, t) if u is None else munthe_kaas.slope(x, u, lambda y: F(y, t), order),
        )
        every = reports.sound[0]
        for sound in reports.sound[1:]:
            every = every * sound
        code = munthe_kaas.verdict(rotation, square, reports.sound[0], every)
        after = self.held_after(model, held, self.held.instant(new, held, t + h), h, reports)
        margin = reports.margin[:1] if self.held.masks else []
        return {"step": self.kernel("step", (*flat(new), *after, code, *margin))}

    def stage(self, name: str) -> Kernel:
        """The slopes of all bodies at x exp(u), or with the name "first" at x; extra: u.

        Its outputs go to the rows of one stage among those of all (see `slope_row`); behind them stands what it
        reports: whether the KKT was sound, the power, the margin.
        """
        graph, model = self.graph()
        reports = _Reports()
        F, x = self.field(model, self.held_rows(graph), reports), self.bodies(graph, "state")
        t = graph.input("clock", 0)
        u = tuple(graph.inputs("extra", ALGEBRA, ALGEBRA * i) for i in range(self.k))
        f = F(x, t) if name == "first" else munthe_kaas.slope(x, u, lambda y: F(y, t), self.tableau.order)
        said = [*reports.sound, *(reports.power or [0.0]), *(reports.margin if self.held.masks else [])]
        stages = len(self.tableau.b)
        rows = [slope_row(i, stages) + c for i in range(self.k) for c in range(ALGEBRA)]
        rows += [slope_row(self.k, stages) + c for c in range(len(said))]
        return self.kernel(name, (*flat(f), *said), tuple(rows))

    def finish(self) -> Kernel:
        """What is held after a step; state: the new bodies, and what was held; extra: what the stages gave."""
        graph, model = self.graph()
        t, h = graph.inputs("clock", 2)
        stages = len(self.tableau.b)
        said = [graph.inputs("extra", codes.REPORTS, slope_row(self.k, stages) + ALGEBRA * s) for s in range(stages)]
        last = [slope_row(i, stages) + ALGEBRA * (stages - 1) + 6 for i in range(self.k)]
        reports = _Reports(
            power=[x[1] for x in said],
            margin=[x[2] for x in said],
            accelerations=[x for first in last for x in graph.inputs("extra", 6, first)],
        )
        held = self.held_rows(graph)
        now = self.held.instant(self.bodies(graph, "state"), held, t)
        return self.kernel("finish", self.held_after(model, held, now, h, reports))

    def body_kernels(self) -> dict[str, Kernel]:
        """What a step does with one body: u of each stage but the first, and the end; extra: the body's slopes."""
        kernels = {}
        for s, row in enumerate(self.tableau.A):
            if any(row):
                graph, _ = self.graph()
                u, rotation = munthe_kaas.combination(graph.input("clock", 1), row, self.slopes(graph, s))
                kernels[f"combine{s}"] = self.kernel(f"combine{s}", (*u, rotation))
        graph, _ = self.graph()
        x = tuple(graph.inputs("state", ELEMENT))
        slopes = self.slopes(graph, len(self.tableau.b))
        new, rotation, square = munthe_kaas.advanced(graph.input("clock", 1), self.tableau, x, slopes)
        return kernels | {"advance": self.kernel("advance", (*new, rotation, square))}

    def slopes(self, graph: Graph, stages: int) -> list[Any]:
        return [graph.inputs("extra", ALGEBRA, ALGEBRA * s) for s in range(stages)]

    def position(self) -> Kernel:
        graph, model = self.graph()
        hat, now = self.now(graph)[0], self.bodies(graph, "extra")
        held = self.held_rows(graph)
        mask = self.held.mask(held, self.structure.rows)
        x = graph.inputs("extra", 6 * self.k, ELEMENT * self.k)
        at = self.held.instant(now, held, hat.t)
        solution = projection.position_correction(model, self.structure, at, list(x), mask)
        rotation = munthe_kaas.promised([(0.0, 0.0, 0.0, *solution.x[6 * i + 3 : 6 * i + 6]) for i in range(self.k)])
        new = projection.placed(hat.bodies, solution.x)
        counts = projection.counted(solution, mask) if self.structure.looped else None
        violation = projection.position_violation(model, self.held.instant(new, held, hat.t), counts)
        code = where(rotation < munthe_kaas.LARGEST_STAGE, 0.0, codes.NOT_CONVERGED)
        code = where(solution.sound > 0.0, code, codes.SINGULAR)
        code = where(finite(solution.x), code, codes.NON_FINITE)
        return self.kernel("position", (*flat(new), *solution.x, violation, code))

    def velocity(self) -> Kernel:
        graph, model = self.graph()
        now, mask = self.now(graph)
        solution = projection.velocity_correction(model, self.structure, now, self.method.velocity, mask)
        new = tuple(
            body[0:12] + tuple(v + x for v, x in zip(body[12:18], solution.x[6 * i : 6 * i + 6], strict=True))
            for i, body in enumerate(now.bodies)
        )
        counts = projection.counted(solution, mask) if self.structure.looped else None
        violation = projection.velocity_violation(model, Instant(new, now.t, now.angles), counts)
        code = where(solution.sound > 0.0, 0.0, codes.SINGULAR)
        code = where(finite(solution.x), code, codes.NON_FINITE)
        return self.kernel("velocity", (*flat(new), violation, code))

    def exchange(self) -> Kernel:
        graph, model = self.graph()
        now, _ = self.now(graph)
        triangle, scales = kkt.exchange(
            self.structure, dynamics.mass_matrix(model), constraints.jacobian(model, now)
        )
        return self.kernel("exchange", (*triangle, *scales))

    def observe(self) -> tuple[Kernel, dict[str, tuple[int, int]]]:
        graph, model = self.graph()
        now, mask = self.now(graph)
        expected = self.held.expected(self.held_rows(graph))
        mu = dynamics.accelerations(model, self.structure, now, mask, expected).mu
        if self.held.masks:
            mu = kkt.least_multipliers(self.structure, constraints.jacobian(model, now), mu)
        kinetic, potential = dynamics.energies(model, now)
        force, torque = constraints.loads(model, now, mu)
        driven = constraints.rows_of(model)[len(model.joints) :]
        named = {
            "kinetic_energy": [kinetic],
            "potential_energy": [potential],
            "position_violation": [constraints.largest(constraints.residual(model, now))],
            "velocity_violation": [constraints.largest(constraints.rate_and_bias(model, now)[0])],
            "multiplier": mu,
            "joint_force": force,
            "joint_torque": torque,
            "driver_effort": [-x for rows in driven for x in mu[rows]],
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


def build(model: Model, method: Method, masked: tuple[int, ...] = ()) -> Program:
    """Trace every kernel that this mechanism and method need; `masked`: the rows of C that may be exchanged."""
    tracer = _Tracer(model, method, masked)
    kernels = tracer.step()
    levels = {constraint.level for constraint in constraints.constraints_of(model)}
    if "position" in levels and method.position != "none":
        kernels["position"] = tracer.position()
    if levels and method.velocity != "none":
        kernels["velocity"] = tracer.velocity()
    if masked:
        kernels["exchange"] = tracer.exchange()
    kernels["observe"], observed = tracer.observe()
    nodes = [float(c) for c in tracer.tableau.c]
    return Program(tracer.k, tracer.held, tracer.values, tracer.rows, kernels, nodes, observed)
