"""The equations of motion as what they leave over, and all their partial derivatives, at any state.

    f(q, v, s, a, mu) = [ Q - M a - C^T mu ;  xi - C a ;  s' ]

along all velocities (of the bodies, or the rates of the tree where the coordinates of the joints are integrated), of
every row of C in use, and of the states s of laws. They are recorded once on an analytic graph, differentiated there
(`lienumba.compiler.derivatives`), and computed again on whatever numbers somebody has: symbols of the kernel that is
being traced, floats, or arrays of all runs. Weight, gyroscopic terms, every force, driver and law, and the geometric
stiffness of joints are in it because they are in f: nothing is derived by hand.

    df = F_q dq + F_v dv + F_s ds - M da - C^T dmu,     stiffness K = -F_q and damping D = -F_v in the first rows.

dq and dv are the local coordinates u of the chart about the state, at u = 0: its first numbers are those of the places,
the others of the velocities. So of a body on R^3 x SO(3) dq = (dr global, dtheta own axes), dv = (dv global, dw own
axes); of a tree the coordinates and rates of the moves, as their states have them. a, and the first rows of f, are
along the same velocities, so that M is symmetric; what a step of `JointChart.slope` takes are `Move.along` of these.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.derivatives import partials
from lienumba.compiler.symbols import Graph, Symbol, uncollected
from lienumba.compiler.tape import Tape
from lienumba.integrators import layout
from lienumba.integrators.tracing.tracer import Posture, Tracer
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.system import constraints
from lienumba.numerics.jets import Dual, lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

STATE, CLOCK, UNKNOWN, INPUTS = "state", "clock", "unknown", "inputs"
VIOLATIONS = "positions", "rates"  # of the constraints
FEW = 24  # runs, of which floats take less time than arrays
Row = Sequence[Any] | npt.NDArray[Any]
Block = dict[tuple[int, int], Any]  # the entries that are not exactly zero


@dataclass(frozen=True)
class Linear:
    """f at a state, and its derivatives: the numbers that the values of `equations` have, and behind them its entries;
    symbols, or floats and arrays (runs,)."""

    numbers: Row
    equations: "Equations"

    @cached_property
    def values(self) -> dict[str, list[Any]]:
        """By the names of `Equations.outputs`."""
        return {name: [self.numbers[n] for n in part] for name, part in self.equations.outputs.items()}

    @property
    def entries(self) -> Block:
        """The derivatives: (row, column) of those that are not exactly zero."""
        return dict(zip(self.equations.entries, self.numbers[len(self.equations.values) :], strict=True))

    @property
    def along(self) -> list[Any]:
        """The rows of f along the velocities."""
        return self.values["along"]

    @property
    def rows(self) -> list[Any]:
        """The rows of f of the constraints in use."""
        return self.values["rows"]

    @property
    def laws(self) -> list[Any]:
        """The rates of the states of laws."""
        return self.values["laws"]

    def block(self, of: str, by: str) -> Block:
        """The derivative of one of `Equations.outputs` by one of `Equations.columns`, numbered from 0."""
        return {(i, j): self.numbers[n] for i, j, n in zip(*self.equations.places[of, by], strict=True)}

    @cached_property
    def _table(self) -> np.ndarray:
        """The numbers (numbers, runs), or (numbers, 1) where none is an array."""
        if isinstance(self.numbers, np.ndarray):
            return self.numbers
        runs = max((x.size for x in self.numbers if isinstance(x, np.ndarray)), default=1)
        table = np.empty((len(self.numbers), runs))
        for row, x in zip(table, self.numbers, strict=True):
            row[:] = x
        return table

    def dense(self, of: str, by: str, runs: int) -> np.ndarray:
        """A block, where numbers are floats or arrays (runs,): (runs, rows, columns)."""
        whole = np.zeros((runs, len(self.equations.outputs[of]), len(self.equations.columns[by])))
        rows, columns, numbers = self.equations.places[of, by]
        whole[:, rows, columns] = self._table[numbers].T
        return whole

    def vector(self, of: str, runs: int) -> np.ndarray:
        """Values (runs, rows)."""
        part = self.equations.outputs[of]
        whole = np.empty((runs, len(part)))
        whole[:] = self._table[part.start : part.stop].T
        return whole


@dataclass(frozen=True)
class More:
    """What is differentiated beside f: inputs that are added to the model, here none, and other outputs, here Phi and
    Phi' of the rows in use."""

    @property
    def inputs(self) -> int:
        """How many inputs there are."""
        return 0

    def model(self, model: Model, t: Any, inputs: Sequence[Any]) -> Model:
        """The model with the inputs, at this time."""
        return model

    def outputs(self, model: Model, posture: Posture, mask: list[Any], used: Sequence[int]) -> dict[str, list[Any]]:
        """The outputs by name."""
        levels = constraints.residual(model, posture.now), constraints.rates(model, posture.now)
        return {name: [mask[row] * x[row] for row in used] for name, x in zip(VIOLATIONS, levels, strict=True)}


@dataclass(frozen=True)
class Equations:
    """f and its derivatives as recorded. outputs: which values are "along", "rows" and "laws", and others that somebody
    wanted; columns: which columns are by "q", "v", "laws", "a", "mu" (of the rows in use, in the order of `used`) and
    "inputs"."""

    values: list[Any]
    entries: Block
    outputs: Mapping[str, range]
    columns: Mapping[str, range]
    used: tuple[int, ...]
    _parts: dict[Any, "Equations"] = field(default_factory=dict, init=False, repr=False, compare=False)

    @staticmethod
    @uncollected()
    def of(tracer: Tracer, more: More | None = None) -> "Equations":
        """Record the equations of a mechanism, with the rows of C of `tracer.structure`."""
        graph, model = tracer.graph(Graph(analytic=True))
        t, inputs = graph.input(CLOCK, layout.TIME), graph.inputs(INPUTS, more.inputs if more else 0)
        model = more.model(model, t, inputs) if more else model
        elements, augmented = tracer.state(graph, STATE), tracer.augmented_rows(graph)
        posture = tracer.posture(model, elements, augmented, t, graph.input(CLOCK, layout.MIDDLE))
        used = tracer.used
        a = graph.inputs(UNKNOWN, tracer.velocities)
        mu: list[Number] = [0.0] * tracer.structure.rows
        for n, row in enumerate(used):
            mu[row] = graph.input(UNKNOWN, tracer.velocities + n)
        mask = tracer.mask(augmented)
        residuals = tracer.missing(model, posture, mask, a, mu, used)
        laws = tracer.law_rates(model, posture.now)
        q, v = _directions(tracer, graph)
        s: list[dict[Symbol, Number]] = [{graph.input(STATE, row): 1.0} for row in tracer.law_rows()[: len(laws)]]
        unknown = [{graph.input(UNKNOWN, n): 1.0} for n in range(tracer.velocities + len(used))]
        others = more.outputs(model, posture, mask, used) if more else {}
        values = [*residuals, *laws, *(x for own in others.values() for x in own)]
        sizes = {"along": tracer.velocities, "rows": len(used), "laws": len(laws)}
        return Equations(
            values,
            partials(values, [*q, *v, *s, *unknown, *({x: 1.0} for x in inputs)]),
            _ranges(**sizes, **{name: len(own) for name, own in others.items()}),
            _ranges(q=len(q), v=len(v), laws=len(s), a=tracer.velocities, mu=len(used), inputs=len(inputs)),
            used,
        )

    @cached_property
    def places(self) -> dict[tuple[str, str], tuple[list[int], list[int], list[int]]]:
        """The entries of each block: their rows and columns there, and their places in the numbers of a `Linear`."""
        rows = {row: (name, n) for name, own in self.outputs.items() for n, row in enumerate(own)}
        columns = {column: (name, n) for name, own in self.columns.items() for n, column in enumerate(own)}
        places: dict[tuple[str, str], tuple[list[int], list[int], list[int]]]
        places = {(of, by): ([], [], []) for of in self.outputs for by in self.columns}
        for number, (row, column) in enumerate(self.entries, len(self.values)):
            (of, i), (by, j) = rows[row], columns[column]
            for numbers, n in zip(places[of, by], (i, j, number), strict=True):
                numbers.append(n)
        return places

    @cached_property
    def _tape(self) -> Tape:
        return Tape.of([*self.values, *self.entries.values()])

    @property
    def moving(self) -> Any:
        """The states of laws, by their numbers, that move by themselves: what is sampled or held does not."""
        rates = [self.values[row] for row in self.outputs["laws"]]
        return np.array([n for n, x in enumerate(rates) if not is_zero(x)], int)

    def only(self, columns: Sequence[str], outputs: Sequence[str] | None = None) -> "Equations":
        """With these derivatives alone; outputs: with these values alone, by default with all."""
        key = tuple(columns), None if outputs is None else tuple(outputs)
        if key not in self._parts:
            kept = self.outputs if outputs is None else outputs
            rows = {row: n for n, row in enumerate(row for name in kept for row in self.outputs[name])}
            wanted = {column for name in columns for column in self.columns[name]}
            self._parts[key] = replace(
                self,
                values=[self.values[row] for row in rows],
                entries={(rows[i], j): x for (i, j), x in self.entries.items() if i in rows and j in wanted},
                outputs=_ranges(**{name: len(self.outputs[name]) for name in kept}),
            )
        return self._parts[key]

    def at(
        self,
        state: Row,
        t: Any,
        a: Row,
        mu: Row,
        parameter: Callable[[int], Any],
        inputs: Sequence[Any] = (),
        within: Any = None,
    ) -> Linear:
        """f and its derivatives on other numbers.

        Parameters
        ----------
        state : the rows of a state, as kernels have them: the elements, and what is augmented
        t : the time (s)
        a, mu : accelerations along the velocities; multipliers of the rows `used`
        parameter : the number of the model in a row of the parameters, such as `partial(graph.input, "parameters")`
        inputs : of somebody's own; 0 by default
        within : a time (s) that tells on which side of a jump t lies, by default t itself
        """
        inputs = inputs or [0.0] * len(self.columns[INPUTS])
        clock = {layout.TIME: t, layout.MIDDLE: t if within is None else within}
        given = {STATE: state.__getitem__, CLOCK: clock.__getitem__, UNKNOWN: [*a, *mu].__getitem__}
        given |= {"parameters": parameter, INPUTS: inputs.__getitem__}
        return Linear(self._tape.replayed(lambda array, row: given[array](row)), self)

    def of_runs(self, state: Row, t: float, a: Row, mu: Row, numbers: "RunsNumbers") -> Linear:
        """`at` on arrays (runs,) and floats. Of few runs one by one on floats, to the same bits: an operation on short
        arrays takes as long as on some thirty floats."""
        if numbers.by_run is None:
            return self.at(state, t, a, mu, numbers.every.__getitem__)
        given = zip(*(_by_run(x, numbers.runs) for x in (state, a, mu)), numbers.by_run, strict=True)
        each = [self.at(rows, t, own_a, own_mu, own.__getitem__).numbers for rows, own_a, own_mu, own in given]
        return Linear(np.array(each, float).T, self)


@dataclass(frozen=True)
class RunsNumbers:
    """Every number of the model of some runs: a float, an array (runs,), or what a table holds."""

    every: Sequence[Any]
    runs: int

    @cached_property
    def by_run(self) -> list[Sequence[Any]] | None:
        """The floats of each run; None of many runs, and of runs with samples of their own."""
        few = 0 < self.runs <= FEW and not any(isinstance(x, RunNumbers) for x in self.every)
        return _by_run(self.every, self.runs) if few else None


def _by_run(numbers: Row, runs: int) -> list[Sequence[Any]]:
    if isinstance(numbers, np.ndarray):
        rows: list[Sequence[Any]] = numbers.T.tolist()
        return rows
    each = [x.ravel().tolist() * (runs // x.size) if isinstance(x, np.ndarray) else [x] * runs for x in numbers]
    return [[own[run] for own in each] for run in range(runs)]


def _directions(tracer: Tracer, graph: Graph) -> tuple[list[dict[Symbol, Number]], list[dict[Symbol, Number]]]:
    """How the rows of the state change along each coordinate of the chart: of the places, of the velocities."""
    chart = tracer.chart_of(tracer.graph(graph)[1])
    places, velocities = tracer.coordinates
    q: list[dict[Symbol, Number]] = []
    v: list[dict[Symbol, Number]] = []
    for element in tracer.state(graph, STATE)[: tracer.moving_elements]:
        for n in (*places, *velocities):
            u = [Dual(0.0, 1.0) if m == n else 0.0 for m in range(chart.size)]
            moved = (lift(x).b for x in chart.moved(element, tuple(u)))
            change = {x: dx for x, dx in zip(element, moved, strict=True) if not is_zero(dx)}
            (q if n in places else v).append(change)
    return q, v


def _ranges(**sizes: int) -> dict[str, range]:
    """One behind the other."""
    ranges, first = {}, 0
    for name, size in sizes.items():
        ranges[name] = range(first, first + size)
        first += size
    return ranges
