"""The states of runs at some of their times, by the freedoms of the joints, whatever a scenario integrates."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.statuses import SUCCESS
from lienumba.engine.linear.simulated import simulated
from lienumba.engine.linear.stored import Stored
from lienumba.engine.select_run import check_run
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.linear.systems import States
from lienumba.integrators.tracing.template import split
from lienumba.scenario.base.arguments import labels_of, several
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.reading.run_tables import tables_of
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.design import weights
from lienumba.scenario.start.prepare import Prepared, check_initial, design, prepare
from lienumba.store import provenance
from lienumba.store.form import scenario_tables
from lienumba.store.layout import RUN
from lienumba.store.linear_layout import GIVEN, KIND, ORIGINS, SIMULATED, STORED, dataset

if TYPE_CHECKING:
    import xarray as xr

END = "end"
At = float | str | Sequence[float | str]


@dataclass(frozen=True)
class Asked:
    """Runs of a scenario: their labels, samples by path (runs,), and the times (s) that are looked at; stored: what a
    dataset has of them."""

    scenario: Scenario
    labels: list[int]
    samples: dict[str, np.ndarray]
    times: list[float]
    stored: Stored | None = None

    @staticmethod
    def of(
        source: "Any | xr.Dataset",
        at: At,
        runs: Sequence[int] | None = None,
        overrides: Mapping[str, Any] | None = None,
        allow_code: bool = False,
    ) -> "Asked":
        """Read a scenario, or a dataset or its file, of which the states are taken as far as it holds them."""
        stored = None
        if _is_dataset(source):
            from lienumba.store.files import reading

            with reading(source) as (ds, where):
                check_allowed(scenario_tables(ds, where), where, "a linearisation", allow_code)
                scenario = resolve(tables_of(ds, where), overrides=overrides)
                labels = []
                for label in ds["run"].values.tolist() if runs is None else several(runs):
                    check_run(ds, where, label)
                    labels.append(label)
                own = ds.sel(run=labels)
                samples = {str(n): x.values for n, x in own.coords.items() if x.attrs.get("role") == "input"}
                if not overrides:
                    stored = Stored.of(ds, scenario, labels, _times(at, scenario.data.integrator.end_time))
        else:
            scenario = resolve(source, overrides=overrides, allow_code=allow_code)
            labels = list(labels_of(runs, scenario.labels))
            samples = design(scenario, labels)
        if scenario.plan is not None:
            raise ScenarioError("a study has no states of its own to be linearised; leave study out")
        return Asked(scenario, list(labels), samples, _times(at, scenario.data.integrator.end_time), stored)

    def dataset(
        self, kind: str, variables: Mapping[str, Any], coordinates: Mapping[str, Any], **more: Any
    ) -> "xr.Dataset":
        """The one of this kind that is made of these; more: attributes."""
        own = self.scenario
        title = ": ".join(filter(None, [own.data.title, kind]))
        seed = own.data.sweep.seed
        said = provenance.attributes(title, own.to_toml(), own.sha256(), seed, provenance.command())
        of = {path: own.units(path) for path in self.samples}
        every = {RUN[0]: self.labels, **coordinates}
        return dataset(variables, every, self.samples, of, {KIND: kind, **said, **more})

    def weights(self) -> np.ndarray | None:
        """The weights of the runs, None if they have none."""
        return weights(self.scenario, self.labels) if self.scenario.weighted else None

    def prepared(self) -> Prepared:
        """Prepare the runs at their start."""
        return prepare(self.scenario, self.labels, self.samples, check_initial(self.scenario))

    def states(self, tracer: FreedomTracer, prepared: Prepared) -> Iterator[States]:
        """At each of the times."""
        numbers = split(prepared.model)[1]
        stored, changes = self._stored(tracer, prepared), bool(tracer.augmented.switches)
        later = sorted({t for t in self.times if (t > 0.0 or changes) and t not in stored})
        records = simulated(self.scenario, prepared, later)
        for t in self.times:
            if t == 0.0 and not changes:
                yield self.start(tracer, prepared)
                continue
            if self.stored is not None and t in stored:
                (rows, good), origin = self.stored.rows(tracer, prepared, t), STORED
            else:
                (rows, good), origin = records[t].rows(tracer, prepared, t), SIMULATED
            rows = tracer.at_limits(prepared.model, rows, t) if t == 0.0 else rows
            yield States(good, t, rows, numbers, origin)

    def start(self, tracer: FreedomTracer, prepared: Prepared) -> States:
        """At t = 0, before anything changes there."""
        rows = tracer.rows_at_start(prepared.model, np.asarray(prepared.states), prepared.angles)
        rows = tracer.at_limits(prepared.model, rows, 0.0)
        numbers, good = split(prepared.model)[1], prepared.codes == SUCCESS
        return States(good, 0.0, rows, numbers, GIVEN)

    def _stored(self, tracer: FreedomTracer, prepared: Prepared) -> list[float]:
        """The times at which the states of all runs are known."""
        if self.stored is None or self.stored.lacks(tracer, prepared.nominal.model):
            return []
        return self.stored.times

    def origins(self, origins: Sequence[int], tracer: FreedomTracer, prepared: Prepared) -> dict[str, Any]:
        """The variable that says where states are from; origins: at each of the times."""
        attributes = {
            "long_name": "where the states are from", "flag_values": np.arange(len(ORIGINS), dtype=np.int8),
            "flag_meanings": " ".join(ORIGINS),
        }  # fmt: skip
        why = "" if self.stored is None else self.stored.lacks(tracer, prepared.nominal.model)
        if self.stored is not None and SIMULATED in origins:
            attributes["comment"] = (
                f"simulated since the dataset does not hold the states: {why}"
                if why
                else ("simulated where the dataset stores no such time")
            )
        return {"origin": ("time", np.asarray(origins, np.int8), attributes)}


def _is_dataset(source: object) -> bool:
    if isinstance(source, str | os.PathLike):
        return os.fspath(source).endswith(".nc")
    return hasattr(source, "data_vars")


def _times(at: At, end: float) -> list[float]:
    """Each once."""
    times: dict[float, None] = {}
    for x in [at] if isinstance(at, float | int | str) else at:
        try:
            t = end if x == END else float(x)
        except (TypeError, ValueError):
            raise ScenarioError.at("at", "must be times in s", 'give numbers such as 0 and 1.5, or "end"', x) from None
        if not isfinite(t) or not 0.0 <= t <= end:
            raise ScenarioError.at("at", f"must lie from 0 to integrator.end_time = {end:g} s", "give such times", x)
        times[t] = None
    if not times:
        raise ScenarioError.at("at", "must have at least one time", 'give numbers such as 0 and 1.5, or "end"')
    return [*times]
