"""From a scenario to its dataset: prepare, compile, run, label, write."""

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from lienumba.errors import ScenarioError
from lienumba.scenario.arguments import check_labels
from lienumba.scenario.batches import batch_of, program_of
from lienumba.scenario.prepare import Prepared, check_initial, prepare
from lienumba.scenario.resolve import Scenario, resolve

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from lienumba.integrators.machine import Machine
    from lienumba.integrators.program import Program
    from lienumba.mechanics.quantities import Part

__all__ = ["Progress", "check_initial", "operation_counts", "run"]


@dataclass(frozen=True)
class Progress:
    """What a progress callable receives: the stage ("compile", "run", "write"), and runs done and failed of total,
    which grows where some go again."""

    stage: str
    done: int
    total: int
    failed: int


def run(
    scenario: Any,
    *,
    output: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    seed: int | None = None,
    overrides: Mapping[str, Any] | None = None,
    runs: Sequence[int] | None = None,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> "xr.Dataset":
    """Simulate a scenario (a path, a dict or a System) and return its dataset.

    output: also write it to this netCDF file; workers: threads, by default one per core; runs: labels of the runs to
    simulate, by default all (-1: the nominal run); progress: called with a Progress a few times per second.
    Raises ScenarioError for bad input, before anything runs; a failed run is data (`status`), never an exception.
    """
    from lienumba.batch.statuses import GOOD
    from lienumba.scenario import study
    from lienumba.store.files import check_target, write

    resolved = resolve(scenario, overrides=overrides, seed=seed)
    told = not isinstance(scenario, Scenario)  # else the command line tells them
    if told:
        for sentence in resolved.warnings:
            warnings.warn(sentence, stacklevel=2)
    data: Any = resolved.data
    labels = list(range(data.sweep.runs)) if runs is None else list(runs)
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise ScenarioError(f"workers = {workers!r}: must be a whole number of threads, at least 1")
    check_labels(labels, data.sweep.runs)
    if output is not None:
        check_target(output, overwrite)
    tell, workers = progress or (lambda event: None), workers or usable_cores()
    if resolved.plan is not None:
        dataset = study.run(resolved, labels, workers, tell)
        for sentence in study.doubts(dataset) if told else ():
            warnings.warn(sentence, stacklevel=2)
    else:
        prepared = prepare(resolved, labels)
        dataset = simulate(resolved, prepared, partial(compiled, resolved, prepared), workers, tell).dataset()
    if output is not None:
        tell(Progress("write", dataset.sizes["run"], dataset.sizes["run"], int((~dataset["status"].isin(GOOD)).sum())))
        write(dataset, output)
    return dataset


def compiled(resolved: Scenario, prepared: Prepared, fixed: bool) -> "tuple[Program, Machine]":
    """The program of a scenario, and that as machine code; fixed: see `lienumba.integrators.program.build`."""
    from lienumba.integrators.machine import compile_program

    program = program_of(resolved, prepared, fixed)
    return program, compile_program(program)


def simulate(
    resolved: Scenario,
    prepared: Prepared,
    code: "Callable[[bool], tuple[Program, Machine]]",
    workers: int,
    tell: Callable[[Progress], None],
) -> "Collector":
    """Simulate the prepared runs; code: `compiled`, by whether it is fixed."""
    import numpy as np

    from lienumba.batch.execute import execute
    from lienumba.integrators.codes import EXCHANGED

    runs = len(prepared.labels)
    collected = Collector(resolved, prepared)
    remaining = np.arange(runs)
    for fixed in (True, False):  # the few runs that need other constraint rows on their way go again, with all of them
        done_before, failed_before = (0 if fixed else runs), collected.failed
        total = done_before + len(remaining)
        tell(Progress("compile", done_before, total, failed_before))
        program, machine = code(fixed)
        batch = batch_of(resolved, prepared, program, machine).part(remaining)
        collected.expect(program)

        def report(
            done: float, failed: int, before: int = done_before, bad: int = failed_before, of: int = total
        ) -> None:
            tell(Progress("run", before + int(done), of, bad + failed))

        report(0, 0)
        for chunk in execute(batch, workers, report):
            collected.take(chunk, remaining[chunk.runs])
        remaining = np.flatnonzero(collected.codes == EXCHANGED)
        if not len(remaining):
            break
    return collected


def operation_counts(scenario: Scenario) -> dict[str, dict[str, int]]:
    """Operations of each kernel per evaluation and run: what the hardware must do."""
    prepared = prepare(scenario, [0])
    return {name: kernel.counts() for name, kernel in program_of(scenario, prepared, fixed=True).kernels.items()}


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Collector:
    """Takes chunks as they finish and keeps what the scenario asks for; seconds: that cores were busy."""

    def __init__(self, resolved: Scenario, prepared: Prepared) -> None:
        import numpy as np

        self.resolved, self.prepared = resolved, prepared
        runs = len(prepared.labels)
        self.series: dict[str, np.ndarray] = {}
        self.summaries: dict[str, np.ndarray] = {}
        self.codes = np.zeros(runs, np.int8)
        self.steps, self.rejected = np.zeros((2, runs), np.int64)
        self.ends = np.zeros(runs)
        self.event_times = np.zeros((runs, len(prepared.model.events)))
        self.event_counts = np.zeros(self.event_times.shape, np.int64)
        self.seconds = 0.0

    @property
    def failed(self) -> int:
        import numpy as np

        from lienumba.batch.execute import FINE

        return int((~np.isin(self.codes, FINE)).sum())

    def expect(self, program: "Program") -> None:
        """From now on take the chunks of this program."""
        import numpy as np

        from lienumba.batch.records import Layout

        self.layout = layout = Layout.of(self.prepared.model, program)
        runs, times = len(self.codes), len(self.resolved.times)
        data: Any = self.resolved.data
        for name in layout.names:
            stored = name.partition(".")[0] if name in layout.quantities else name
            if stored in data.output.variables and name not in self.series:
                self.series[name] = np.empty((runs, times, *layout.shape(name)))
        for name in layout.summaries:
            self.summaries.setdefault(name, np.full(runs, np.nan))

    def take(self, chunk: Any, runs: "np.ndarray") -> None:
        """Keep a chunk, which has these runs (indices)."""
        values = self.layout.unpack(chunk.records)
        for name, array in self.series.items():
            array[runs] = values[name][:, -array.shape[1] :]
        for name, array in self.summaries.items():
            array[runs] = self.layout.summarise(name, values)
        self.codes[runs] = chunk.codes
        self.event_times[runs], self.event_counts[runs] = chunk.event_times, chunk.event_counts
        self.steps[runs], self.rejected[runs], self.ends[runs] = chunk.steps, chunk.rejected, chunk.ends
        self.seconds += chunk.seconds

    def _variable(self, part: "Part") -> Any:
        from lienumba.store.layout import SERIES, Variable

        if not part.vector:
            return Variable(SERIES, part.units, part.long_name)
        assert part.frame is not None
        frame = "global" if part.frame < 0 else self.prepared.model.bodies[part.frame].name
        return Variable((*SERIES, "axis"), part.units, part.long_name, frame)

    def per_run(self) -> "dict[str, np.ndarray]":
        """What there is one of for each run (runs,)."""
        return self.summaries | {
            "status": self.codes, "end_time": self.ends, "steps": self.steps, "rejected_steps": self.rejected,
        }  # fmt: skip

    def dataset(self) -> "xr.Dataset":
        from lienumba.scenario.units import units
        from lienumba.store import layout, provenance

        data: Any = self.resolved.data
        model, named = self.prepared.model, data.model.model_dump()
        happened = {"event_time": self.event_times, "event_count": self.event_counts}
        return layout.dataset(
            variables=self.series | self.per_run() | happened,
            times=self.resolved.times,
            runs=self.prepared.labels,
            bodies=[body.name for body in model.bodies],
            joints=[joint.name for joint in model.joints],
            constraints=self.layout.constraints,
            efforts=self.layout.efforts,
            events=[event.name for event in model.events],
            shared=self.prepared.nominal.rank.shared,
            quantities={name: self._variable(part) for name, part in self.layout.quantities.items()},
            inputs=self.prepared.samples,
            input_units={path: units(path, named) for path in self.prepared.samples},
            attributes=provenance.attributes(
                self.resolved.to_toml(), self.resolved.sha256(), data.sweep.seed, provenance.command()
            ),
        )
