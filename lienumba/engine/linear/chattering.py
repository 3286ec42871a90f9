"""Whether a force that jumps back and forth made steps short: said once, behind a sweep with a tolerance.

Where a force jumps as something passes 0, and on both sides pushes it back, this stays at 0 and the force would have to
take every value between (Filippov). No method has steps for that. It shows in the states of a run: what is compared in
the force is far smaller at some time than it was at others, while the branches of the force differ as much as ever.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from lienumba.batch.statuses import SUCCESS
from lienumba.compiler.symbols import Graph, Symbol, live
from lienumba.compiler.tape import replayed
from lienumba.engine.linear.course import Column, course
from lienumba.engine.simulate import Runs
from lienumba.integrators import layout
from lienumba.integrators.tracing.linear.equations import CLOCK, STATE
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.template import split
from lienumba.mechanics.system.applied_forces import generalized
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared, prepare

LEAST = 10_000  # steps of a run, below which nobody waits for it
HELD = 1e-3  # of the largest that was compared: so small, it is held at 0
AS_EVER = 0.1  # of the largest difference between the branches


@dataclass(frozen=True)
class _Jump:
    """Of a force, where it chooses: what is compared, and the two branches."""

    force: str
    compared: tuple[Any, Any]
    branches: tuple[Any, Any]


def attributes(resolved: Scenario, runs: Runs, column: Column) -> dict[str, str]:
    """What the dataset says of it: nothing, or a sentence by the name "chatters"."""
    integrator, labels = resolved.data.integrator, runs.labels
    if integrator.tolerance is None or not len(labels) or not resolved.data.model.forces:
        return {}
    steps = column("steps", labels)
    most = np.argsort(-steps, kind="stable")[:1]
    if steps[most[0]] < LEAST or column("status", labels[most])[0] != SUCCESS:
        return {}
    run, count = runs.part(most), int(steps[most[0]])
    prepared = prepare(resolved, run.labels.tolist(), run.samples, run.nominal, asked=0)
    times, states, _ = course(resolved, column, run.labels)
    force = _chatters(prepared, [(0.0, np.asarray(prepared.states)), *zip(times, states, strict=True)])
    if force is None:
        return {}
    which = f" in run {int(run.labels[0])}" if resolved.data.sweep.runs > 1 else ""
    said = (
        f"{integrator.method} took {count:,} steps{which}, {integrator.end_time / count:.2g} s long in the mean, "
        f"because the force {force} jumps back and forth where it holds the motion; give it a slope there, such as "
        "tanh(rate/1e-3), sample it by a law with every, or, where it is friction, take one with static"
    )
    return {"chatters": said}


def _chatters(prepared: Prepared, moments: Sequence[tuple[float, np.ndarray]]) -> str | None:
    """The name of the first force that does; moments: times (s) and states (1, 18 k) of a run."""
    tracer, numbers = FreedomTracer.of(prepared.model), split(prepared.model)[1]
    states = [(t, tracer.rows_at_start(prepared.model, bodies, prepared.angles)) for t, bodies in moments]
    for jump in _jumps(tracer):
        values = [*jump.compared, *jump.branches]
        with np.errstate(all="ignore"):
            found = np.array([_at(values, t, rows, numbers) for t, rows in states])
        sizes, differences = abs(found[:, 0] - found[:, 1]), abs(found[:, 2] - found[:, 3])
        held = (sizes <= HELD * sizes.max()) & (differences >= AS_EVER * differences.max())
        if np.isfinite(found).all() and differences.max() > 0.0 and held[1:].any():
            return jump.force
    return None


def _at(values: Sequence[Any], t: float, rows: Sequence[Any], numbers: Sequence[Any]) -> list[float]:
    given = {STATE: rows.__getitem__, CLOCK: lambda row: t, "parameters": numbers.__getitem__}
    return [float(np.asarray(x).reshape(-1)[0]) for x in replayed(values, partial(_input, given))]


def _input(given: Any, array: str, row: int) -> Any:
    return given[array](row)


def _jumps(tracer: FreedomTracer) -> Iterator[_Jump]:
    """Where forces choose by what the state says."""
    graph, model = tracer.graph(Graph(analytic=True))
    t, elements = graph.input(CLOCK, layout.TIME), tracer.state(graph, STATE)
    posture = tracer.posture(model, elements, tracer.augmented_rows(graph), t, graph.input(CLOCK, layout.MIDDLE))
    for force in model.forces:
        for node in live(generalized(model, posture.now, [force])):
            condition = node.args[0] if node.op == "where" else None
            if not isinstance(condition, Symbol) or condition.op not in ("<", "<="):
                continue
            compared = (condition.args[0], condition.args[1])
            if any(x.op == "input" and x.args[0] == STATE for x in live(compared)):
                yield _Jump(force.name, compared, (node.args[1], node.args[2]))
