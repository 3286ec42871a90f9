"""The states of runs at some of their times, by the freedoms of the joints, whatever a scenario integrates."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.execute import Cost, execute, tasks
from lienumba.batch.integrate import Chunk
from lienumba.batch.records import per_run
from lienumba.batch.statuses import GOOD, SUCCESS
from lienumba.engine.cores import usable_cores
from lienumba.engine.programs import batch_of, by_joints, compiled_of
from lienumba.engine.select_run import check_run
from lienumba.errors import ScenarioError
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import state_rows
from lienumba.integrators.tracing.law_states import NUMBERS
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.program import Outline
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.integrators.tracing.tracer import split
from lienumba.scenario.base.arguments import labels_of
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.reading.run_tables import tables_of
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import Prepared, check_initial, design, prepare
from lienumba.store import provenance
from lienumba.store.form import scenario_tables

if TYPE_CHECKING:
    import xarray as xr

END = "end"
At = float | str | Sequence[float | str]


@dataclass(frozen=True)
class States:
    """Runs at a time t (s): labels (runs,), good: whether a run is there at all (runs,), rows: of the state, and the
    numbers of the model, each a float or an array (runs,)."""

    labels: np.ndarray
    good: np.ndarray
    t: float
    rows: list[Any]
    numbers: list[Any]

    def part(self, which: slice) -> "States":
        """Of these runs alone."""
        some = [[x[which] if np.ndim(x) else x for x in own] for own in (self.rows, self.numbers)]
        return States(self.labels[which], self.good[which], self.t, *some)


@dataclass(frozen=True)
class Asked:
    """Runs of a scenario: their labels, samples by path (runs,), and the times (s) that are looked at."""

    scenario: Scenario
    labels: list[int]
    samples: dict[str, np.ndarray]
    times: list[float]

    @staticmethod
    def of(
        source: "Any | xr.Dataset",
        at: At,
        runs: Sequence[int] | None = None,
        overrides: Mapping[str, Any] | None = None,
        allow_code: bool = False,
    ) -> "Asked":
        """Of a scenario, or of a dataset or its file, whose runs are simulated again as far as that is needed."""
        if _is_dataset(source):
            from lienumba.store.files import reading

            with reading(source) as (ds, where):
                check_allowed(scenario_tables(ds, where), where, "a linearisation", allow_code)
                scenario = resolve(tables_of(ds, where), overrides=overrides)
                labels = ds["run"].values.tolist() if runs is None else list(runs)
                for label in labels:
                    check_run(ds, where, label)
                own = ds.sel(run=labels)
                samples = {str(n): x.values for n, x in own.coords.items() if x.attrs.get("role") == "input"}
        else:
            scenario = resolve(source, overrides=overrides, allow_code=allow_code)
            labels = list(labels_of(runs, scenario.labels))
            samples = design(scenario, labels)
        if scenario.plan is not None:
            raise ScenarioError("a study has no states of its own to be linearised; leave study out")
        return Asked(scenario, list(labels), samples, _times(at, scenario.data.integrator.end_time))

    def attributes(self, what: str) -> dict[str, Any]:
        """Of a dataset that is made of these."""
        own = self.scenario
        title = ": ".join(filter(None, [own.data.title, what]))
        seed = own.data.sweep.seed
        return dict(provenance.attributes(title, own.to_toml(), own.sha256(), seed, provenance.command()))

    def prepared(self) -> Prepared:
        """These runs at their start."""
        return prepare(self.scenario, self.labels, self.samples, check_initial(self.scenario))

    def states(self, tracer: FreedomTracer, prepared: Prepared) -> Iterator[States]:
        """At each of the times."""
        numbers, labels = split(prepared.model)[1], np.asarray(self.labels)
        later = sorted({t for t in self.times if t > 0.0})
        records = _simulated(self.scenario, prepared, later) if later else None
        for t in self.times:
            if t == 0.0 or records is None:
                bodies = np.asarray(prepared.states)
                laws = tracer.law_states.initial(prepared.model)
                augmented = list(tracer.augmented.start(prepared.angles, UNIQUE, len(labels)).T)
                rows, good = tracer.rows(prepared.model, bodies, laws, augmented), prepared.codes == SUCCESS
            else:
                rows, good = records.rows(tracer, prepared, later.index(t))
            yield States(labels, good, t, rows, numbers)


def _is_dataset(source: object) -> bool:
    if isinstance(source, str | os.PathLike):
        return os.fspath(source).endswith(".nc")
    return hasattr(source, "data_vars")


def _times(at: At, end: float) -> list[float]:
    found: list[float] = []
    for x in [at] if isinstance(at, float | int | str) else at:
        try:
            t = end if x == END else float(x)
        except (TypeError, ValueError):
            raise ScenarioError.at("at", "must be times in s", 'give numbers such as 0 and 1.5, or "end"', x) from None
        if not isfinite(t) or not 0.0 <= t <= end:
            raise ScenarioError.at("at", f"must lie from 0 to integrator.end_time = {end:g} s", "give such times", x)
        found.append(t)
    if not found:
        raise ScenarioError.at("at", "must have at least one time", 'give numbers such as 0 and 1.5, or "end"')
    return found


@dataclass(frozen=True)
class _Records:
    """The rows of states (runs, times, rows) as a program has them; codes and ends (runs,)."""

    program: Outline
    states: np.ndarray
    tree: bool
    good: np.ndarray

    def rows(self, tracer: FreedomTracer, prepared: Prepared, time: int) -> tuple[list[Any], np.ndarray]:
        own, at = self.program.augmented, self.states[:, time]
        elements = at[:, : at.shape[1] - own.rows]
        behind = list(at[:, at.shape[1] - own.rows :].T)
        augmented = list(np.zeros((tracer.augmented.rows, len(at))))
        for n, which in enumerate(tracer.augmented.angles):
            augmented[n] = behind[own.angles.index(which)]
        augmented[tracer.augmented.first_mode :] = behind[own.first_mode :]
        good = self.good & np.isfinite(at).all(axis=1)
        if self.tree:
            return [*elements.T, *augmented], good
        bodies = ELEMENT * len(prepared.model.bodies)
        numbers = [bodies + ELEMENT * (n // len(NUMBERS)) + NUMBERS[n % len(NUMBERS)] for n in range(tracer.laws)]
        laws = tracer.law_states.apart([elements[:, n] for n in numbers])
        return tracer.rows(prepared.model, elements[:, :bodies], laws, augmented), good


def _simulated(scenario: Scenario, prepared: Prepared, times: list[float]) -> _Records:
    """The runs up to these times."""
    scenario = resolve({**scenario.to_dict(), "output": {"times": times}})
    again = replace(prepared, nominal=replace(prepared.nominal, scenario=scenario))
    program, machine = compiled_of(scenario, again, False)
    batch = batch_of(scenario, again, program, machine)
    found = np.full((batch.runs, len(times), state_rows(program.sizes)), np.nan)
    good = np.zeros(batch.runs, bool)

    def taken(chunk: Chunk) -> Chunk:
        records = chunk.records[:, -len(times) :, : found.shape[2]]
        found[chunk.runs] = per_run(records, len(chunk.codes))
        good[chunk.runs] = np.isin(chunk.codes, GOOD)
        return chunk

    workers = usable_cores()
    for _ in execute(tasks(batch, workers, taken, Cost()), workers, lambda _: None):
        pass
    return _Records(program, found, by_joints(scenario), good)
