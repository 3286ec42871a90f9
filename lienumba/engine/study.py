"""Runs a study: every point of its grid with the same samples, compared with its reference, and timed.

All points are prepared and compiled first. Points that differ in integrator or projection alone have their initial
states in common, and those of one method their kernels. The first round gives errors and costs, further rounds give
times only, interleaved: a busy minute of the machine meets all points alike.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from sys import float_info
from typing import TYPE_CHECKING, SupportsInt

import numpy as np

from lienumba.batch.statuses import GOOD
from lienumba.engine.fields import measured
from lienumba.engine.programs import compile_early
from lienumba.engine.results import Results
from lienumba.engine.simulate import Memory, Progress, Runs, Tell, Threads, simulate
from lienumba.integrators.methods import METHODS
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared, prepare
from lienumba.scenario.start.study_start import problems, stated, told
from lienumba.scenario.study_errors import STATE, Truth, errors, rounding
from lienumba.store import provenance, study_layout
from lienumba.store.study_layout import ERRORS, OF_POINTS, TRUSTED, grid_of, typical
from lienumba.words import listed, plural, show

if TYPE_CHECKING:
    import xarray as xr

Arrays = dict[str, "np.ndarray"]
ITERATIONS = ("position_iterations", "velocity_iterations")
STORED = [*STATE, *ITERATIONS]  # of every point, until its errors are known


def run(scenario: Scenario, labels: Sequence[int], workers: int, tell: Tell) -> "xr.Dataset":
    """The dataset of a study; labels: of the runs of each point."""
    data, plan = scenario.data, scenario.plan
    assert data.study is not None
    assert plan is not None
    bench = _Bench(scenario, labels, workers, tell)
    model = next(iter(bench.prepared.values())).model
    measures = {field.name: field.spec for field in measured(scenario, model)}
    known = {point.problem: stated(scenario, point, labels, bench.samples) for point in problems(plan)}
    bench.compile()
    found: dict[int, Arrays] = {}
    seconds: list[list[float]] = [[] for _ in plan.points]
    for problem, truth in known.items():
        exact: Arrays = {}  # measures, where settings give the reference
        if truth is None:
            truth, exact, floor = bench.reference(problem, [*measures])
        else:
            floor = rounding(truth)
        for n, point in enumerate(plan.points):
            if point.problem == problem:
                memory = bench.simulate(point.scenario, problem, counted=True)
                seconds[n].append(memory.seconds)
                found[n] = _measured(point.scenario, memory.arrays, truth)
                found[n] |= {f"reference_{x}_error": floor[x] for x in floor}
                found[n] |= {name: memory.arrays[name] for name in measures}
                found[n] |= {f"{name}_error": np.abs(memory.arrays[name] - exact[name]) for name in exact}
    for _ in range(data.study.repeats - 1):
        for n, point in enumerate(plan.points):
            seconds[n].append(bench.simulate(point.scenario, point.problem).seconds)
    per_run = np.array(seconds) / len(labels)
    times = {"time_per_run": np.median(per_run, axis=1), "time_per_run_spread": np.ptp(per_run, axis=1)}
    arrays = {
        name: np.stack([np.broadcast_to(found[n][name], len(labels)) for n in range(len(found))], axis=1)
        for name in found[0]
    }
    return study_layout.dataset(
        {name: x.reshape(*x.shape[:-1], *plan.shape) for name, x in (arrays | times).items()},
        labels,
        plan.coordinates,
        bench.samples,
        {path: scenario.units(path) for path in bench.samples},
        provenance.attributes(data.title, scenario.to_toml(), scenario.sha256(), data.sweep.seed, provenance.command()),
        measures,
    )


class _Bench:
    """The prepared runs of all points, and how far the study has come."""

    def __init__(self, scenario: Scenario, labels: Sequence[int], workers: int, tell: Tell) -> None:
        assert scenario.plan is not None
        assert scenario.data.study is not None
        self.plan, self.workers, self.tell = scenario.plan, workers, tell
        self.runs, self.done, self.failed = len(labels), 0, 0
        times = len(self.plan.points) * scenario.data.study.repeats + 2 * len(self.plan.references)
        self.total = times * self.runs
        self.prepared: dict[str, Prepared] = {
            point.problem: told(point, lambda scenario: prepare(scenario, labels)) for point in problems(self.plan)
        }

    @property
    def samples(self) -> "Arrays":
        """The samples of every run, which are the same at all points, by path."""
        return next(iter(self.prepared.values())).samples

    def compile(self) -> None:
        """Compile what the points and references need."""
        references = [(x, problem) for problem, both in self.plan.references.items() for x in both]
        needed = [*((point.scenario, point.problem) for point in self.plan.points), *references]
        for scenario, problem in needed:
            compile_early(_lean(scenario), self.prepared[problem], True, self._tell_compiling)

    def _tell_compiling(self) -> None:
        self.tell(Progress("compile", 0, self.total, 0))

    def simulate(self, scenario: Scenario, problem: str, counted: bool = False) -> Memory:
        """The runs of a scenario that solves this problem; counted: whether those that fail are told."""

        def report(event: Progress) -> None:
            if event.stage == "run":
                more = event.total - self.runs
                failed = self.failed + counted * event.failed
                self.tell(Progress("run", self.done + event.done, self.total + more, failed))

        def portions(runs: Runs) -> Iterator[Prepared]:
            known = self.prepared[problem]
            yield known if len(runs.labels) == self.runs else prepare(scenario, runs.labels.tolist(), runs.samples)

        known = self.prepared[problem]
        runs = Runs(np.asarray(known.labels), known.samples, known.nominal)
        memory = Memory(known.labels)
        results = Results(_lean(scenario), known.nominal)
        for piece in simulate(runs, report, Threads(results, self.workers, portions)):
            memory.take(piece)
        self.done += self.runs
        self.failed += counted * int(np.count_nonzero(~np.isin(memory.arrays["status"], GOOD)))
        return memory

    def reference(self, problem: str, measures: Sequence[str]) -> "tuple[Truth, Arrays, Arrays]":
        """The motion that settings give, these numbers of whole runs, and by how much (runs,) its judge says
        otherwise."""
        first, judge = (self.simulate(scenario, problem) for scenario in self.plan.references[problem])
        bodies = [body.name for body in self.prepared[problem].model.bodies]
        truth = Truth({name: first.arrays[name] for name in STATE}, dict.fromkeys(STATE, bodies))
        differences = errors(judge.arrays, truth, bodies)
        floor = rounding(truth)
        off = {name: np.maximum(differences[name].max(axis=1), floor[name]) for name in STATE}
        exact = {name: first.arrays[name] for name in measures}
        for name, x in exact.items():
            off[name] = np.maximum(np.abs(judge.arrays[name] - x), float_info.epsilon * np.abs(x))
        return truth, exact, off


def _measured(scenario: Scenario, arrays: "Arrays", truth: Truth) -> "Arrays":
    """Errors and costs (runs,) of one point."""
    found: Arrays = {}
    data = scenario.data
    for name, series in errors(arrays, truth, [body.name for body in data.model.bodies]).items():
        found |= {f"{name}_error": series.max(axis=1), f"final_{name}_error": series[:, -1]}
    per_run = {name: arrays[name] for name in OF_POINTS}
    method = METHODS[data.integrator.method]
    stages = 1 if method.carries else len(method.b)
    most = {f"max_{name}": np.fmax.reduce(arrays[name], axis=1) for name in ITERATIONS}
    return found | per_run | most | {"evaluations": stages * (per_run["steps"] + per_run["rejected_steps"])}


def _lean(scenario: Scenario) -> Scenario:
    """The scenario with what the errors need, and nothing else, to be stored."""
    output = scenario.data.output.model_copy(update={"variables": STORED})
    return replace(scenario, data=scenario.data.model_copy(update={"output": output}))


def doubts(ds: "xr.Dataset") -> list[str]:
    """Sentences about a reference that failed, or that is not a hundred times better than the best point."""
    ratios: dict[str, np.ndarray] = {}
    unknown = np.zeros(ds["status"].shape, bool)
    for name in (name for name in ERRORS if f"{name}_error" in ds):
        unknown |= ~np.isfinite(ds[f"reference_{name}_error"].values)
        with np.errstate(all="ignore"):
            ratio = typical(ds, f"{name}_error").values / typical(ds, f"reference_{name}_error").values
        ratios[name] = np.where(np.isnan(ratio), np.inf, ratio)
    found = []
    if unknown.any():
        runs = np.flatnonzero(unknown.reshape(len(unknown), -1).any(axis=1))
        found.append(
            f"study.reference: has no result in {plural(len(runs), 'run', 'runs')}, run {ds['run'].values[runs[0]]} "
            "first, whose errors are not known; give it a smaller step or another method"
        )
    telling = [name for name in ratios if ratios[name].max() >= TRUSTED]  # others may be 0 for good
    worst = min(telling or ratios, key=lambda name: ratios[name].min())
    if ratios[worst].min() < TRUSTED:
        at = np.unravel_index(ratios[worst].argmin(), ratios[worst].shape)
        least, good = (float(typical(ds, f"{x}{worst}_error").values[at]) for x in ("", "reference_"))
        unit = ds[f"{worst}_error"].attrs.get("units", "")
        found.append(
            f"study.reference: the smallest {worst}_error of the grid, {least:.2g} {unit}{_where(ds, at)}, is less "
            f"than {TRUSTED:g} times what the reference is good to, {good:.2g} {unit}; give a better reference, or "
            "leave out such fine points"
        )
    return found


def _where(ds: "xr.Dataset", at: Sequence[SupportsInt]) -> str:
    """At which settings a point lies."""
    dims = ds["status"].dims[1:]
    point = ds.isel(dict(zip(dims, map(int, at), strict=True)))
    labels = {name: point[name].values.item() for name in grid_of(ds)}
    own = [f"{name} = {show(x)}" for name, x in labels.items() if x != "" and x == x]  # others: not of its grid
    return f" at {listed(own)}"
