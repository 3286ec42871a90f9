"""Those who integrate a problem to an error that a setting asks for: heyoka, and this engine's methods.

`ladder`: settings, from the coarsest to the finest; `run(setting)` gives the mass centres at the end (bodies, 3, runs)
and the core time (s) of the integration alone: nothing of it is compilation, preparation or output.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from bench.reach.problems import Array, Form, Problem
from lienumba.batch.execute import execute, tasks
from lienumba.engine import programs
from lienumba.errors import ScenarioError
from lienumba.groups.state import ELEMENT
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import Prepared, prepare

PER_DECADE = 4  # tolerances
GROWTH = 1.06  # from one number of steps to the next
EXTENDED = 1e-18  # the tolerance of references


class Contestant(Protocol):
    """compiled: core time to make a setting ready (s); searched: whom to ask for errors in its place."""

    key: str
    label: str
    ladder: Sequence[float]
    compiled: dict[float, float]

    def run(self, setting: float) -> tuple[Array, float]: ...

    def steps(self, setting: float) -> int: ...

    def searched(self) -> "Contestant": ...


def tolerances(coarsest: float, finest: float) -> list[float]:
    count = round(np.log10(coarsest / finest) * PER_DECADE)
    return [coarsest * (finest / coarsest) ** (n / count) for n in range(count + 1)]


# ------------------------------------------------------------ heyoka
@dataclass
class Heyoka:
    """Batches as wide as the machine's vectors, the full width of them allowed; parameters are numbers of each lane."""

    problem: Problem
    form: Form
    compact: bool = False
    key: str = field(init=False)
    label: str = field(init=False)

    def __post_init__(self) -> None:
        import heyoka

        self.hy, self.width = heyoka, heyoka.recommended_simd_size()
        heyoka.llvm_state.set_diskcache_enabled(False)  # or what compiling takes would be of an earlier day
        self.key = f"heyoka_{self.form.key}{'_compact' if self.compact else ''}"
        self.label = f"heyoka {heyoka.__version__}, {self.form.label}{', compact' if self.compact else ''}"
        self.ladder = tolerances(1e-3, 2.3e-16)
        self.compiled: dict[float, float] = {}
        self.made: dict[float, Any] = {}
        self.equations = self.form.equations(heyoka)
        runs = self.problem.runs
        if runs % self.width:
            raise ValueError(f"{runs} runs do not fill vectors of {self.width}")
        self.blocks = [slice(n, n + self.width) for n in range(0, runs, self.width)]
        self.starts, self.parameters = (np.asarray(x, float) for x in (self.form.states, self.form.parameters))

    def batch(self, tolerance: float) -> Any:
        if tolerance not in self.made:
            start = time.process_time()
            self.made[tolerance] = self.hy.taylor_adaptive_batch(
                self.equations, self.starts[:, : self.width].copy(), pars=self.parameters[:, : self.width].copy(),
                tol=tolerance, compact_mode=self.compact, force_avx512=True,
            )  # fmt: skip
            self.compiled[tolerance] = time.process_time() - start
        return self.made[tolerance]

    def run(self, setting: float) -> tuple[Array, float]:
        batch, ends, seconds = self.batch(setting), np.empty_like(self.starts), 0.0
        for block in self.blocks:
            batch.state[:], batch.pars[:] = self.starts[:, block], self.parameters[:, block]
            batch.set_time(0.0)
            begin = time.thread_time()
            batch.propagate_until(self.problem.end)
            seconds += time.thread_time() - begin
            ends[:, block] = batch.state
        return self.form.centres(
            ends.astype(np.longdouble), self.form.parameters, np.longdouble(self.problem.end)
        ), seconds

    def steps(self, setting: float) -> int:
        """Of the last block."""
        return int(np.median([result[3] for result in self.batch(setting).propagate_res]))

    def searched(self) -> "Heyoka":
        """What to find the errors with: to rounding the same, but compiled at once."""
        return replace(self, compact=True) if self.form.long and not self.compact else self

    def order(self, setting: float) -> int:
        return int(self.batch(setting).order)


def reference(problem: Problem) -> Array:
    """The mass centres at the end by heyoka in extended precision (80 bits), run by run."""
    import heyoka

    form, extended = problem.forms[0], np.longdouble
    made = heyoka.taylor_adaptive(
        form.equations(heyoka), list(form.states[:, 0]), pars=list(form.parameters[:, 0]), fp_type=extended,
        tol=extended(EXTENDED), compact_mode=True,
    )  # fmt: skip
    ends = np.empty_like(form.states)
    for run in range(problem.runs):
        made.state[:], made.pars[:] = form.states[:, run], form.parameters[:, run]
        made.time = extended(0)
        made.propagate_until(extended(problem.end))
        ends[:, run] = made.state
    return form.centres(ends, form.parameters, extended(problem.end))


# ------------------------------------------------------------ this engine
WAYS: dict[str, tuple[str, dict[str, Any]]] = {
    "lie": ("bodies, projected", {"integrator.coordinates": "lie"}),
    "joint": ("joints", {"integrator.coordinates": "joint"}),
}  # fmt: skip


@dataclass
class Engine:
    """A method, with steps of one length (its ladder: numbers of steps) or those that a tolerance chooses; order: of a
    series, or what the tolerance asks for."""

    problem: Problem
    method: str
    way: str
    adaptive: bool
    order: int | None = None
    compiled: dict[float, float] = field(default_factory=dict)
    ready: dict[float, tuple[Scenario, Prepared, Any, Any]] = field(default_factory=dict)
    taken: dict[float, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kind = "tolerance" if self.adaptive else "fixed"
        self.key = f"{self.method}_{self.way}_{'adaptive' if self.adaptive else 'fixed'}"
        if self.order:
            self.key, kind = f"{self.key}_{self.order}", f"order {self.order}, {kind}"
        self.label = f"lienumba {self.method}, {WAYS[self.way][0]}, {kind}"
        numbers = np.unique(np.round(10 * GROWTH ** np.arange(170)))
        self.ladder = tolerances(1e-1, 1e-14) if self.adaptive else numbers.tolist()
        self._scenario(self.ladder[0])  # refused now, if ever

    def _scenario(self, setting: float) -> Scenario:
        data: Mapping[str, Any] = self.problem.data
        integrator = {k: x for k, x in data["integrator"].items() if k not in ("tolerance", "step")}
        size = {"tolerance": setting} if self.adaptive else {"step": self.problem.end / setting}
        method = {"method": self.method, **({"order": self.order} if self.order else {})}
        return resolve({**data, "integrator": integrator | size | method}, overrides=WAYS[self.way][1])

    def run(self, setting: float) -> tuple[Array, float]:
        if setting not in self.ready:
            begin = time.process_time()
            resolved = self._scenario(setting)
            prepared = prepare(resolved, list(range(self.problem.runs)))
            self.ready[setting] = (resolved, prepared, *programs.compiled_of(resolved, prepared, True))
            self.compiled[setting] = time.process_time() - begin
        batch, seconds = programs.batch_of(*self.ready[setting]), 0.0
        ends = np.empty((batch.runs, batch.bodies, ELEMENT))
        steps = 0
        for chunk in execute(tasks(batch, 1, lambda chunk: chunk), 1, lambda _: None):
            if np.any(chunk.codes):
                raise FailedError(self.label, setting, np.unique(chunk.codes))
            ends[chunk.runs] = chunk.states[:, : batch.bodies * ELEMENT].reshape(-1, batch.bodies, ELEMENT)
            seconds += chunk.seconds
            steps += int(chunk.steps.sum())
        self.taken[setting] = steps // batch.runs
        return ends[:, :, :3].transpose(1, 2, 0).astype(np.longdouble), seconds

    def steps(self, setting: float) -> int:
        return self.taken[setting]

    def searched(self) -> "Engine":
        return self


class FailedError(RuntimeError):
    """A setting with which runs fail: too coarse."""

    def __init__(self, label: str, setting: float, codes: Array) -> None:
        super().__init__(f"{label}, {setting:g}: runs failed with the codes {codes}")


KINDS: list[tuple[str, bool, int | None]] = [  # method, whether a tolerance chooses steps, order of a series
    *(("taylor", True, order) for order in (None, 16, 24)), ("dop853", True, None), ("dop853", False, None),
    ("rk4", False, None),
]  # fmt: skip


def engines(problem: Problem) -> list[Engine]:
    """Every method that this version has, in every way that it takes."""
    found = []
    for method, adaptive, order in KINDS:
        for way in WAYS:
            try:
                found.append(Engine(problem, method, way, adaptive, order))
            except ScenarioError:
                continue
    return found


def rivals(problem: Problem) -> list[Heyoka]:
    """heyoka, if it is installed: in every form, with long code as one piece and in loops."""
    try:
        import heyoka  # noqa: F401
    except ImportError:
        return []
    pairs = [(form, compact) for form in problem.forms for compact in ((False, True) if form.long else (False,))]
    return [Heyoka(problem, form, compact) for form, compact in pairs]
