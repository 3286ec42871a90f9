"""The states of runs at times up to which they are simulated."""

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from lienumba.batch.execute import Cost, execute, tasks, usable_cores
from lienumba.batch.integrate import Chunk
from lienumba.batch.records import per_run
from lienumba.engine.programs import batch_of, by_joints, compiled_of
from lienumba.errors import ScenarioError
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import state_rows
from lienumba.integrators.tracing.law_states import NUMBERS
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.program import Outline
from lienumba.scenario.base.timegrid import count, nearest_multiple
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import Prepared


@dataclass(frozen=True)
class Records:
    """The rows of states (runs, times, rows) as a program has them; tree: whether they are those of moves."""

    program: Outline
    states: np.ndarray
    tree: bool
    times: list[float]

    def rows(self, tracer: FreedomTracer, prepared: Prepared, t: float) -> tuple[list[Any], np.ndarray]:
        """The rows of the state at one of the times, and which runs are there."""
        own, at = self.program.augmented, self.states[:, self.times.index(t)]
        elements = at[:, : at.shape[1] - own.rows]
        behind = list(at[:, at.shape[1] - own.rows :].T)
        augmented = list(np.zeros((tracer.augmented.rows, len(at))))
        for n, which in enumerate(tracer.augmented.angles):
            augmented[n] = behind[own.angles.index(which)]
        augmented[tracer.augmented.first_mode :] = behind[own.first_mode :]
        good = np.isfinite(at).all(axis=1)
        if self.tree:
            return [*elements.T, *augmented], good
        bodies = ELEMENT * len(prepared.model.bodies)
        numbers = [bodies + ELEMENT * (n // len(NUMBERS)) + NUMBERS[n % len(NUMBERS)] for n in range(tracer.laws)]
        laws = tracer.law_states.apart([elements[:, n] for n in numbers])
        return tracer.rows(prepared.model, elements[:, :bodies], laws, augmented), good


def simulated(scenario: Scenario, prepared: Prepared, times: list[float]) -> dict[float, Records]:
    """The runs up to the last of these times, in the steps of the scenario; and, for each time that is none of their
    ends, in steps that are a little shorter. At t = 0 all has changed that changes there."""
    h, end = scenario.data.integrator.step, scenario.data.integrator.end_time
    between = [t for t in times if h is not None and count(t, h) is None]
    records_at = {}
    if 0.0 in times:
        records_at[0.0] = _run(resolve({**scenario.to_dict(), "output": {"times": [end]}}), prepared, [0.0])
    if common := [t for t in times if t > 0.0 and t not in between]:
        records = _run(resolve({**scenario.to_dict(), "output": {"times": common}}), prepared, common)
        records_at.update(dict.fromkeys(common, records))
    for t in between:
        assert h is not None
        data = scenario.to_dict()
        shorter = data["integrator"] | {"step": t / ceil(t / h), "end_time": t}
        try:
            finer = resolve({**data, "integrator": shorter, "output": {"times": [t]}})
        except ScenarioError:
            rule = f"must be a whole number of steps of integrator.step = {h:g} s, which cannot be shortened here"
            raise ScenarioError.at("at", rule, f"give {nearest_multiple(t, h):g}", t) from None
        records_at[t] = _run(finer, prepared, [t])
    return records_at


def _run(scenario: Scenario, prepared: Prepared, times: list[float]) -> Records:
    """The runs of a scenario up to the last of these times."""
    again = prepared._replace(nominal=prepared.nominal._replace(scenario=scenario))
    program, machine = compiled_of(scenario, again, False)
    batch = replace(batch_of(scenario, again, program, machine), until=times[-1])
    states = np.full((batch.runs, len(times), state_rows(program.sizes)), np.nan)

    def taken(chunk: Chunk) -> Chunk:
        records = chunk.records[:, :1] if times == [0.0] else chunk.records[:, -len(times) :]
        states[chunk.runs] = per_run(records[:, :, : states.shape[2]], len(chunk.codes))
        return chunk

    workers = usable_cores()
    for _ in execute(tasks(batch, workers, taken, Cost()), workers, lambda _: None):
        pass
    return Records(program, states, by_joints(scenario), times)
