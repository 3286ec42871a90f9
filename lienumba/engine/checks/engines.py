"""Compare two engines on the same samples: the compiled one, and that of the paper's formulas in plain Numba.

Equations of motion, elimination, Jacobians, steps and projections are those of each. The start, the choice of redundant
rows, the values and rates of formulas of time, and what is computed of a stored state (energies, violations, forces of
joints) come from the same code: no difference shows a mistake there.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.batch.statuses import GOOD, STATUSES
from lienumba.engine.replay import scenario_of
from lienumba.errors import ScenarioError
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.store.form import scenario_tables
from lienumba.words import plural

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.engine.results import Results
    from lienumba.engine.simulate import Runs, Tell

STATE = ("position", "rotation", "velocity", "angular_velocity")  # by which engines are judged
AGREE = 1e-9  # relative to the largest value of a variable: differences of roundoff in some hundred steps
SMALLEST_SCALE = 1e-6  # in SI units: of a variable that is zero but for roundoff
STORED = 10  # times at which the engines are compared
DROPPED = ("measures", "requirements", "sensitivities", "study")  # sections that look at runs and do not move them


@dataclass(frozen=True)
class Difference:
    """The largest difference of a variable, in its units, the largest value of it, and where: run, and time in s."""

    name: str
    units: str
    size: float
    scale: float
    run: int
    time: float

    @property
    def relative(self) -> float:
        return self.size / max(self.scale, SMALLEST_SCALE)


@dataclass(frozen=True)
class Check:
    """How far an engine and the compiled one differ; agrees: whether no state differs by more than AGREE, and no run
    ends otherwise; headline: what was compared."""

    headline: str
    differences: list[Difference]
    agrees: bool
    sentence: str


def check(
    source: object, runs: int, steps: int, tell: "Tell", overrides: Mapping[str, object] | None = None,
    allow_code: bool = False,
) -> Check:  # fmt: skip
    """Simulate the first runs of a scenario or a dataset (.nc) by both engines, for so many steps at most."""
    from lienumba.engine.results import Results
    from lienumba.engine.runner import in_memory
    from lienumba.engine.simulate import Threads
    from lienumba.scenario.start.prepare import check_initial
    from lienumba.scenario.start.reference_engine import NUMBA

    whole, samples = read(source, overrides, allow_code)
    scenarios = [shortened(whole, steps, engine) for engine in (None, NUMBA)]
    every = [Results(scenario, check_initial(scenario)) for scenario in scenarios]  # refused before anything runs
    one, other = (
        in_memory(results, first_runs(results, samples, runs), Threads(results, usable_cores()), tell)
        for results in every
    )
    integrator = scenarios[0].data.integrator
    return compare(one, other, integrator.step or 0.0, integrator.method)


def first_runs(results: "Results", samples: dict[int, dict[str, float]], count: int) -> "Runs":
    """The first runs of a scenario; samples: of the runs of a dataset, by their labels and paths."""
    from lienumba.engine.runner import runs_of
    from lienumba.engine.simulate import Runs

    if not samples:
        return runs_of(results.resolved, [*results.resolved.labels][:count], results.nominal)
    labels = [*samples][:count]
    columns = {path: np.array([samples[label][path] for label in labels]) for path in samples[labels[0]]}
    return Runs(np.array(labels, np.int64), columns, results.nominal)


def compare(one: "xr.Dataset", other: "xr.Dataset", h: float, method: str) -> Check:
    """The differences of two datasets of the same runs, the largest first; h: the step in s."""
    ends, both = one["status"].values != other["status"].values, [defined(one), defined(other)]
    compared = both[0] & both[1]
    steps = np.rint(np.where(compared, one["time"].values, 0.0).max(axis=1) / h)
    headline = f"{counted(steps, float(one['time'].values[-1]) / h)} of {method} compared"
    names = [name for name, x in one.data_vars.items() if x.dims[:2] == ("run", "time") and x.size]
    differences = [_difference(str(name), one[name], other[name]) for name in names]
    differences.sort(key=lambda x: (x.name not in STATE, -x.relative))
    worst = max((x for x in differences if x.name in STATE), key=lambda x: x.relative)
    if ends.any():
        run = int(one["run"].values[ends][0])
        return Check(headline, differences, False, f"run {run} ends otherwise: the engines do not agree")
    if not steps.any():
        how = f"{first_failure(one)}, before the first of the times that are compared"
        return Check(headline, differences, False, f"nothing was compared: {how}; give a smaller integrator.step")
    agrees = worst.relative <= AGREE
    verdict = f"the engines {'agree' if agrees else 'do not agree'}"
    size = f"{worst.name} differs by {worst.relative:.1e} of its size, and at most {AGREE:g} is roundoff"
    return Check(headline, differences, agrees, f"{verdict}: {size}")


def defined(ds: "xr.Dataset") -> np.ndarray:
    """Whether the state of each run is finite at each stored time (runs, times)."""
    every = [np.isfinite(ds[name].values).reshape(*ds[name].shape[:2], -1).all(axis=2) for name in STATE]
    return np.logical_and.reduce(every)


def counted(steps: np.ndarray, every: float) -> str:
    """Of how many runs how many steps were compared; steps (runs,): of each, every: of a whole run."""
    runs = f"{np.count_nonzero(steps):,} of {plural(len(steps), 'run', 'runs')}"
    return f"{runs}, {int(steps.sum()):,} of {plural(len(steps) * round(every), 'step', 'steps')}"


def first_failure(ds: "xr.Dataset") -> str:
    """How the first run ends that fails, "" if none does."""
    found = zip(ds["run"].values, ds["status"].values, strict=True)
    names = {x.code: x.name for x in STATUSES}
    return next((f"run {run} ends as {names[int(status)]}" for run, status in found if status not in GOOD), "")


def _difference(name: str, one: "xr.DataArray", other: "xr.DataArray") -> Difference:
    a, b = one.values.astype(float), other.values.astype(float)
    apart = np.where(np.isnan(a) & np.isnan(b), 0.0, np.abs(a - b))
    apart = np.where(np.isnan(apart), np.inf, apart)
    run, time = np.unravel_index(int(apart.argmax()), apart.shape)[:2]
    scale = float(np.nanmax(np.abs(a), initial=0.0))
    where = int(one["run"].values[run]), float(one["time"].values[time])
    return Difference(name, str(one.attrs.get("units", "1")), float(apart.max()), scale, *where)


def read(
    source: object, overrides: Mapping[str, object] | None, allow_code: bool
) -> tuple[Scenario, dict[int, dict[str, float]]]:
    """The scenario, and of a dataset the samples of its runs by their labels and paths."""
    if not isinstance(source, str | os.PathLike) or not str(source).endswith(".nc"):
        return resolve(source, overrides=overrides, allow_code=allow_code), {}
    from lienumba.store.files import reading

    with reading(source) as (ds, where):
        check_allowed(scenario_tables(ds, where), where, "a check", allow_code)
        inputs = [str(name) for name, x in ds.coords.items() if x.attrs.get("role") == "input"]
        values = {name: ds[name].values for name in inputs}
        samples = {
            int(run): {name: float(values[name][n]) for name in inputs} for n, run in enumerate(ds["run"].values)
        }
        scenario = scenario_of(ds, where)
        return (resolve(scenario.to_dict(), overrides=overrides) if overrides else scenario), samples


def shortened(whole: Scenario, steps: int, engine: str | None) -> Scenario:
    """The scenario with the first steps alone, the whole course of them, and one of the engines."""
    data: dict[str, Any] = {key: x for key, x in whole.to_dict().items() if key not in DROPPED}
    integrator = {key: x for key, x in data["integrator"].items() if key != "engine"}
    h = integrator.get("step")
    if h is None:
        raise ScenarioError(
            "integrator.step is missing: engines are compared in steps of one length; write integrator.step instead of "
            "integrator.tolerance"
        )
    count = min(steps, whole.steps or steps)
    integrator |= {"end_time": count * h} | ({} if engine is None else {"engine": engine})
    sweep = {key: x for key, x in data["sweep"].items() if key != "stop"}
    output = {"every": max(1, count // STORED) * h}
    return resolve(data | {"integrator": integrator, "output": output, "sweep": sweep})
