"""Runs a study: every point of its grid with the same samples, compared with its reference, and timed.

All points are prepared and compiled first. Points that differ in integrator or projection alone have their initial
states in common, and those of one method their kernels. The first round gives errors and costs, further rounds give
times only, interleaved: a busy minute of the machine meets all points alike.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from lienumba.errors import ScenarioError
from lienumba.scenario import reference_file, reference_formulas, runner
from lienumba.scenario.batches import method_of
from lienumba.scenario.design import draw
from lienumba.scenario.prepare import Prepared, check_initial, prepare
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.runner import Collector, Progress
from lienumba.scenario.study_errors import STATE, Truth, errors, rounding
from lienumba.scenario.study_points import Plan, Point
from lienumba.scenario.units import units
from lienumba.scenario.words import listed, plural, show
from lienumba.store import provenance, study_layout
from lienumba.store.study_layout import ERRORS, TRUSTED, grid_of, typical

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from lienumba.integrators.machine import Machine
    from lienumba.integrators.program import Program

T = TypeVar("T")
Arrays = dict[str, "np.ndarray"]
ITERATIONS = ("position_iterations", "velocity_iterations")
STORED = [*STATE, *ITERATIONS]  # of every point, until its errors are known


def check(scenario: Scenario) -> None:
    """Check the initial state of a scenario; of a study those of its points, and the reference."""
    data: Any = scenario.data
    if scenario.plan is None:
        check_initial(scenario)
        return
    for point in _problems(scenario.plan):
        _told(point, check_initial)
        labels = range(data.sweep.runs)
        samples = draw(scenario, labels)
        _stated(scenario, point, labels, samples)


def run(scenario: Scenario, labels: Sequence[int], workers: int, tell: Callable[[Progress], None]) -> "xr.Dataset":
    """The dataset of a study; labels: of the runs of each point."""
    import numpy as np

    data, plan = scenario.data, scenario.plan
    assert data.study is not None
    assert plan is not None
    bench = _Bench(scenario, labels, workers, tell)
    stated = {point.problem: _stated(scenario, point, labels, bench.samples) for point in _problems(plan)}
    bench.compile()
    found: dict[int, Arrays] = {}
    seconds: list[list[float]] = [[] for _ in plan.points]
    for problem, truth in stated.items():
        truth, floor = bench.reference(problem) if truth is None else (truth, rounding(truth))
        for n, point in enumerate(plan.points):
            if point.problem == problem:
                collected = bench.simulate(point.scenario, problem, counted=True)
                seconds[n].append(collected.seconds)
                found[n] = _measured(collected, truth) | {f"reference_{x}_error": floor[x] for x in floor}
    for _ in range(data.study.repeats - 1):
        for n, point in enumerate(plan.points):
            seconds[n].append(bench.simulate(point.scenario, point.problem).seconds)
    per_run = np.array(seconds) / len(labels)
    times = {"time_per_run": np.median(per_run, axis=1), "time_per_run_spread": np.ptp(per_run, axis=1)}
    arrays = {
        name: np.stack([np.broadcast_to(found[n][name], len(labels)) for n in range(len(found))], axis=1)
        for name in found[0]
    }
    model = data.model.model_dump()
    return study_layout.dataset(
        {name: x.reshape(*x.shape[:-1], *plan.shape) for name, x in (arrays | times).items()},
        labels,
        plan.coordinates,
        bench.samples,
        {path: units(path, model) for path in bench.samples},
        provenance.attributes(scenario.to_toml(), scenario.sha256(), data.sweep.seed, provenance.command()),
    )


class _Bench:
    """The prepared runs and the kernels of all points, and how far the study has come."""

    def __init__(
        self, scenario: Scenario, labels: Sequence[int], workers: int, tell: Callable[[Progress], None]
    ) -> None:
        assert scenario.plan is not None
        assert scenario.data.study is not None
        self.plan, self.workers, self.tell = scenario.plan, workers, tell
        self.runs, self.done, self.failed = len(labels), 0, 0
        times = len(self.plan.points) * scenario.data.study.repeats + 2 * len(self.plan.references)
        self.total = times * self.runs
        self.codes: dict[Any, tuple[Program, Machine]] = {}
        self.prepared: dict[str, Prepared] = {
            point.problem: _told(point, lambda scenario: prepare(scenario, labels)) for point in _problems(self.plan)
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
            self.tell(Progress("compile", 0, self.total, 0))
            self.code(scenario, problem, True)

    def code(self, scenario: Scenario, problem: str, fixed: bool) -> "tuple[Program, Machine]":
        key = (problem, method_of(scenario), fixed)
        if key not in self.codes:
            program, machine = runner.compiled(scenario, self.prepared[problem], fixed)
            self.codes[key] = replace(program, kernels={}), machine  # graphs are large, and have done their work
        return self.codes[key]

    def simulate(self, scenario: Scenario, problem: str, counted: bool = False) -> Collector:
        """The runs of a scenario that solves this problem; counted: whether those that fail are told."""

        def told(event: Progress) -> None:
            if event.stage == "run":
                more = event.total - self.runs
                failed = self.failed + counted * event.failed
                self.tell(Progress("run", self.done + event.done, self.total + more, failed))

        collected = runner.simulate(
            _lean(scenario),
            self.prepared[problem],
            lambda fixed: self.code(scenario, problem, fixed),
            self.workers,
            told,
        )
        self.done += self.runs
        self.failed += counted * collected.failed
        return collected

    def reference(self, problem: str) -> "tuple[Truth, Arrays]":
        """The motion that settings give, and by how much (runs,) its judge says otherwise."""
        import numpy as np

        first, judge = (self.simulate(scenario, problem) for scenario in self.plan.references[problem])
        bodies = [body.name for body in self.prepared[problem].model.bodies]
        truth = Truth({name: first.series[name] for name in STATE}, dict.fromkeys(STATE, bodies))
        differences = errors(judge.series, truth, bodies)
        floor = rounding(truth)
        return truth, {name: np.maximum(differences[name].max(axis=1), floor[name]) for name in STATE}


def _measured(collected: Collector, truth: Truth) -> "Arrays":
    """Errors and costs (runs,) of one point."""
    import numpy as np

    from lienumba.integrators.tableaus import TABLEAUS

    found: Arrays = {}
    for name, series in errors(
        collected.series, truth, [body.name for body in collected.prepared.model.bodies]
    ).items():
        found |= {f"{name}_error": series.max(axis=1), f"final_{name}_error": series[:, -1]}
    per_run = collected.per_run()
    stages = len(TABLEAUS[collected.resolved.data.integrator.method].b)
    most = {f"max_{name}": np.fmax.reduce(collected.series[name], axis=1) for name in ITERATIONS}
    return found | per_run | most | {"evaluations": stages * (per_run["steps"] + per_run["rejected_steps"])}


def _problems(plan: Plan) -> list[Point]:
    """The first point of every problem."""
    return list({point.problem: point for point in reversed(plan.points)}.values())[::-1]


def _stated(scenario: Scenario, point: Point, labels: Sequence[int], samples: "Arrays") -> Truth | None:
    """What formulas or a file say of a problem; None where the reference is to be simulated."""
    data, own = scenario.data, point.scenario
    assert data.study is not None
    reference = data.study.reference
    if "file" in reference:
        return reference_file.read(reference, [body.name for body in data.model.bodies], labels, own.times, samples)
    if reference.keys() & set(STATE):
        return reference_formulas.truth(reference, own.parameters, samples, own.times)
    return None


def _lean(scenario: Scenario) -> Scenario:
    """The scenario with what the errors need, and nothing else, to be stored."""
    output = scenario.data.output.model_copy(update={"variables": STORED})
    return replace(scenario, data=scenario.data.model_copy(update={"output": output}))


def _told(point: Point, act: Callable[[Scenario], T]) -> T:
    """What becomes of a point; errors name it."""
    try:
        return act(point.scenario)
    except ScenarioError as error:
        raise ScenarioError("\n".join(f"{point.place}: {line}" for line in str(error).splitlines())) from None


def doubts(ds: "xr.Dataset") -> list[str]:
    """Sentences about a reference that failed, or that is not a hundred times better than the best point."""
    import numpy as np

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
        unit = ds[f"{worst}_error"].attrs["units"]
        found.append(
            f"study.reference: the smallest {worst}_error of the grid, {least:.2g} {unit}{_where(ds, at)}, is less "
            f"than {TRUSTED:g} times what the reference is good to, {good:.2g} {unit}; give a better reference, or "
            "leave out such fine points"
        )
    return found


def _where(ds: "xr.Dataset", at: Sequence[Any]) -> str:
    """At which settings a point lies."""
    dims = ds["status"].dims[1:]
    point = ds.isel(dict(zip(dims, map(int, at), strict=True)))
    labels = {name: point[name].values.item() for name in grid_of(ds)}
    own = [f"{name} = {show(x)}" for name, x in labels.items() if x != "" and x == x]  # others: not of its grid
    return f" at {listed(own)}"
