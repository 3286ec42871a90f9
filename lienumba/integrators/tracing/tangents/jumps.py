"""Where forces jump as the state changes: comparisons in force laws whose two sides do not meet.

A step goes over such a place as over others, but the derivative of the motion changes there at once. The loads of a
mechanism are recorded as a graph, and evaluated for all states of a run at once.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lienumba.compiler.series import FUNCTIONS
from lienumba.compiler.symbols import COMPARISONS, Graph, Symbol, live, uncollected
from lienumba.compiler.tangents import tangents
from lienumba.integrators import layout
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing.joint.tracer import JointTracer
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import dynamics
from lienumba.numerics.number import Number

UNKNOWN = ("call", "part", "gather")  # operations that are not evaluated here
MEETS = 1e-3  # of the difference of two sides a step away: where it is smaller at the place itself, they meet
PARTS, DIVISIONS = 1024, 6  # of a line on which a comparison turns: its place is known to 2^-60 of it
JUMP, KINK, NOTHING = "jump", "kink", "nothing"


@dataclass(frozen=True)
class Where:
    """A state (rows,) with its parameters (slots,) at a time (s)."""

    state: np.ndarray
    parameters: np.ndarray
    t: float

    def towards(self, other: "Where", part: float) -> "Where":
        """On the straight line to another one."""
        state = self.state + part * (other.state - self.state)
        return Where(state, self.parameters, self.t + part * (other.t - self.t))


@dataclass(frozen=True)
class Jumps:
    """outputs: the loads and the rates of laws' states; comparisons: nodes that depend on the state, and the difference
    of what each compares; changes: the tangents of these; rows: of a state, slots: parameters; orders: in which
    nodes are evaluated."""

    outputs: tuple[Number, ...]
    comparisons: tuple[Symbol, ...]
    guards: tuple[Number, ...]
    changes: tuple[Number, ...]
    rows: int
    slots: int
    orders: dict[tuple[int | None, ...], list[Symbol]] = field(default_factory=dict)

    @staticmethod
    @uncollected()
    def of(model: Model, method: Method, selection: RowSelection, fixed: bool) -> "Jumps":
        """Of a mechanism."""
        template, values = split(model)
        tracer = (JointTracer if method.coordinates == JOINT else Tracer)(template, method, selection, fixed)
        graph, model = tracer.graph(Graph(analytic=True))
        now = tracer.now(graph, model)[0].now
        outputs = [*dynamics.loads(model, now)] if model.forces else []
        outputs += [x for rates in law_states.rates(model, now).values() for x in rates]
        nodes = live(outputs)
        unknown = {node.id for node in nodes if node.op in UNKNOWN}
        for node in nodes:
            if any(isinstance(x, Symbol) and x.id in unknown for x in node.args):
                unknown.add(node.id)
        found = [
            node
            for node in nodes
            if node.op in COMPARISONS and not node.invariant and node.id not in graph.alike | unknown
        ]
        guards = [node.args[0] - node.args[1] for node in found]
        rows = layout.state_rows(tracer.sizes)
        seeds: dict[Symbol, Number] = {}
        for node in live(guards):
            if node.op == "input":
                first = {"state": 0, "parameters": rows, "clock": rows + len(values)}[node.args[0]]
                if node.args[0] != "clock" or node.args[1] == layout.TIME:
                    seeds[node] = graph.input("extra", first + node.args[1])
        known = [x for x in outputs if not (isinstance(x, Symbol) and x.id in unknown)]
        return Jumps(tuple(known), tuple(found), tuple(guards), tuple(tangents(guards, seeds)), rows, len(values))

    def holding(self, states: np.ndarray, parameters: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Which comparisons hold (comparisons, states); states (states, rows)."""
        found = self._evaluated(self.guards, {"state": states.T, "parameters": parameters, "clock": [times]})
        return np.stack([np.broadcast_to(np.asarray(x) < 0.0, times.shape) for x in found])

    def place(self, n: int, begin: Where, end: Where) -> tuple[float, str]:
        """Where between two states a comparison turns, as a part of the line, and what the loads do there: one of
        `JUMP`, `KINK`, `NOTHING`."""

        def guards(parts: np.ndarray) -> np.ndarray:
            state = begin.state[:, None] + parts * (end.state - begin.state)[:, None]
            inputs = {"state": state, "parameters": begin.parameters, "clock": [begin.t + parts * (end.t - begin.t)]}
            return np.broadcast_to(self._evaluated(self.guards[n : n + 1], inputs)[0], parts.shape)

        low, width = 0.0, 1.0
        before = guards(np.zeros(1))[0] < 0.0
        for _ in range(DIVISIONS):
            width /= PARTS
            turned = (guards(low + width * np.arange(1.0, PARTS)) < 0.0) != before
            low += width * (int(turned.argmax()) if turned.any() else PARTS - 1)
        there, aside, behind = (self._step_at(n, begin.towards(end, x)) for x in (low, 0.0, 1.0))
        if there > MEETS * max(aside, behind):
            return low, JUMP
        return low, KINK if max(aside, behind) > 0.0 else NOTHING

    def _step_at(self, n: int, where: Where) -> float:
        """By how much the loads differ on both sides of a comparison at a state; rounding is nothing."""
        holds, fails = (self._at(self.outputs, where, {self.comparisons[n].id: x}) for x in (True, False))
        with np.errstate(invalid="ignore"):
            size = float(np.nanmax(np.abs(np.array(holds) - np.array(fails)), initial=0.0))
            return size if size > 1e-12 * float(np.nanmax(np.abs(holds), initial=0.0)) else 0.0

    def value(self, n: int, where: Where) -> float:
        """The difference that a comparison is about."""
        return float(self._at(self.guards[n : n + 1], where)[0])

    def moves(self, n: int, where: Where, state: np.ndarray, parameters: np.ndarray, t: np.ndarray) -> np.ndarray:
        """The tangent (W,) of the difference that a comparison is about, from those of the state (rows, W), the
        parameters (slots, W) and the time (W,)."""
        extra = np.concatenate([state, parameters, t[None]])
        found = self._at(self.changes[n : n + 1], where, None, extra)[0]
        return np.broadcast_to(np.asarray(found, float), t.shape)

    def _at(
        self, outputs: tuple[Number, ...], where: Where, forced: Mapping[int, bool] | None = None, extra: Any = None
    ) -> list[Any]:
        inputs = {"state": where.state, "parameters": where.parameters, "clock": [where.t], "extra": extra}
        return self._evaluated(outputs, inputs, forced)

    def _evaluated(
        self, outputs: tuple[Number, ...], inputs: Mapping[str, Any], forced: Mapping[int, bool] | None = None
    ) -> list[Any]:
        """The outputs on arrays; forced: comparisons that hold, or do not."""
        known: dict[int, Any] = {}
        with np.errstate(all="ignore"):
            for node in self._ordered(outputs):
                if node.op == "input":
                    array, row = node.args
                    known[node.id] = inputs[array][row] if array != "clock" or row == 0 else np.nan
                elif forced is not None and node.id in forced:
                    known[node.id] = forced[node.id]
                else:
                    given = [known[x.id] if isinstance(x, Symbol) else x for x in node.args]
                    known[node.id] = FUNCTIONS[node.op](*given)
        return [known[x.id] if isinstance(x, Symbol) else x for x in outputs]

    def _ordered(self, outputs: tuple[Number, ...]) -> list[Symbol]:
        """The nodes that outputs need, in their order; found once."""
        key = tuple(x.id if isinstance(x, Symbol) else None for x in outputs)
        if key not in self.orders:
            self.orders[key] = live(outputs)
        return self.orders[key]
