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
axes); of a tree the coordinates and rates of the moves. a and the first rows of f are along the same velocities, but of
a free body in a tree along its own axes (`lienumba.mechanics.mechanism.moves`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lienumba.compiler.derivatives import partials, replayed
from lienumba.compiler.symbols import Graph, Symbol
from lienumba.integrators import layout
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.numerics.jets import Dual, lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

STATE, CLOCK, UNKNOWN = "state", "clock", "unknown"
Block = dict[tuple[int, int], Any]  # the entries that are not exactly zero


@dataclass(frozen=True)
class Linear:
    """f at a state, and its derivatives: (row, column) of the entries that are not exactly zero.

    along, rows, laws: f along the velocities, of the rows of C in use, and the rates of the states of laws; the blocks
    of the derivatives are those of `Equations.block`."""

    along: list[Any]
    rows: list[Any]
    laws: list[Any]
    entries: Block
    equations: "Equations"

    def block(self, of: str, by: str) -> Block:
        """The derivative of one of `Equations.outputs` by one of `Equations.columns`, numbered from 0."""
        row, column = self.equations.outputs[of], self.equations.columns[by]
        return {(i - row.start, j - column.start): x for (i, j), x in self.entries.items() if i in row and j in column}


@dataclass(frozen=True)
class Equations:
    """f and its derivatives as recorded. outputs: which of f are "along", "rows" and "laws"; columns: which columns
    are by "q", "v", "laws", "a" and "mu" (of the rows in use, in the order of `used`)."""

    values: list[Any]
    entries: Block
    outputs: Mapping[str, range]
    columns: Mapping[str, range]
    used: tuple[int, ...]

    @staticmethod
    def of(tracer: Tracer) -> "Equations":
        """Of a mechanism; of the rows of C those of `tracer.structure`."""
        graph, model = tracer.graph(Graph(analytic=True))
        elements, augmented = tracer.state(graph, STATE), tracer.augmented_rows(graph)
        posture = tracer.posture(model, elements, augmented, graph.input(CLOCK, layout.TIME))
        used = tuple(sorted(row - 6 * tracer.structure.bodies for row in tracer.structure.order))
        used = tuple(row for row in used if row >= 0)
        a = graph.inputs(UNKNOWN, tracer.velocities)
        mu: list[Number] = [0.0] * tracer.structure.rows
        for n, row in enumerate(used):
            mu[row] = graph.input(UNKNOWN, tracer.velocities + n)
        found = tracer.missing(model, posture, tracer.mask(augmented), a, mu, used)
        laws = tracer.law_rates(model, posture.now)
        q, v = _directions(tracer, graph)
        s: list[dict[Symbol, Number]] = [{graph.input(STATE, row): 1.0} for row in tracer.law_rows()[: len(laws)]]
        unknown = [{graph.input(UNKNOWN, n): 1.0} for n in range(tracer.velocities + len(used))]
        values = [*found, *laws]
        return Equations(
            values,
            partials(values, [*q, *v, *s, *unknown]),
            _ranges(along=tracer.velocities, rows=len(used), laws=len(laws)),
            _ranges(q=len(q), v=len(v), laws=len(s), a=tracer.velocities, mu=len(used)),
            used,
        )

    def at(
        self,
        state: Sequence[Any],
        t: Any,
        a: Sequence[Any],
        mu: Sequence[Any],
        parameter: Callable[[int], Any],
        functions: Mapping[str, Callable[..., Any]] | None = None,
    ) -> Linear:
        """f and its derivatives on other numbers.

        Parameters
        ----------
        state : the rows of a state, as kernels have them: the elements, and what is augmented
        t : the time (s)
        a, mu : accelerations along the velocities; multipliers of the rows `used`
        parameter : the number of the model in a row of the parameters, such as `partial(graph.input, "parameters")`
        functions : what computes an operation, if not `lienumba.compiler.series.FUNCTIONS`
        """
        given = {STATE: state.__getitem__, CLOCK: lambda _: t, UNKNOWN: [*a, *mu].__getitem__, "parameters": parameter}
        every = [*self.values, *self.entries.values()]
        more = {} if functions is None else {"functions": functions}
        found = replayed(every, lambda array, row: given[array](row), **more)
        values, slopes = found[: len(self.values)], found[len(self.values) :]
        along, rows, laws = ([values[n] for n in part] for part in self.outputs.values())
        return Linear(along, rows, laws, dict(zip(self.entries, slopes, strict=True)), self)


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
    found, first = {}, 0
    for name, size in sizes.items():
        found[name] = range(first, first + size)
        first += size
    return found
