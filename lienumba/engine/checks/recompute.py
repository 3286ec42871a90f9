"""Recompute some runs of a dataset by the paper's formulas in plain Numba, and compare them with the stored numbers.

`lienumba.engine.checks.engines` says what both engines have in common. Each difference is relative to the largest value
of its unit in the same run, so that an energy that cancels is measured by the energies of which it is the sum. Torques
are measured by forces too, at an arm of 1 m: a spherical joint's torque is their cancellation.

Chaotic motions amplify roundoff. A second recomputed run, whose start is changed by roundoff, measures by how much.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.batch.statuses import GOOD, STATUSES
from lienumba.engine.checks.engines import AGREE, DROPPED, Difference
from lienumba.engine.compare_runs import common, of_run
from lienumba.engine.replay import scenario_of
from lienumba.engine.select_run import check_run
from lienumba.errors import ScenarioError
from lienumba.mechanics.system.output_variables import kept_largest
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.store.form import scenario_tables
from lienumba.store.layout import RELATIVE_DRIFT
from lienumba.store.linear_layout import is_modes
from lienumba.store.names import START_STATE

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.engine.simulate import Runs, Tell
    from lienumba.scenario.start.prepare import Prepared

STATUS_NAMES = {x.code: x.name for x in STATUSES}
GOOD_ENDS = [STATUS_NAMES[code] for code in GOOD]
SHARED_SCALES = {"N m": "N"}  # units of one scale
ULPS = 4  # by which roundoff may move a number that is stored in fewer digits
NUDGE = 2.0**-46  # relative change of the start: about the roundoff of a thousand steps
ROUNDOFF_MARGIN = 10.0  # of roundoff, which is no measure but an estimate
UNDECIDED = 1e-3  # relative: where roundoff grows beyond it, agreement would mean nothing


@dataclass(frozen=True)
class Recomputed:
    """One run: how it ended as stored and by the other engine, how many variables were compared, and the one that
    differs most beside its tolerance, which is relative and follows from how this motion amplifies roundoff."""

    run: int
    stored: str
    computed: str
    variables: int
    worst: Difference
    tolerance: float

    @property
    def comparable(self) -> bool:
        """Whether both engines reached the end, and the motion does not depend on roundoff."""
        failed = self.stored in GOOD_ENDS and self.computed not in GOOD_ENDS
        return not failed and self.tolerance <= UNDECIDED

    @property
    def differs(self) -> bool:
        return self.comparable and (self.stored != self.computed or self.worst.relative > self.tolerance)

    @property
    def verdict(self) -> str:
        """In a few words."""
        if not self.comparable:
            ended = self.stored != self.computed
            return f"no verdict: recomputed as {self.computed}" if ended else "no verdict: roundoff decides the motion"
        if self.stored != self.computed:
            return f"differs: stored as {self.stored}, recomputed as {self.computed}"
        return "differs" if self.differs else "agrees"


def recompute(ds: "xr.Dataset", where: str, count: int, allow_code: bool, tell: "Tell") -> list[Recomputed]:
    """Simulate up to `count` runs, evenly over the labels, from start to end; a ScenarioError says why the other engine
    cannot. where: what the dataset is called."""
    from lienumba.engine.results import Results
    from lienumba.engine.runner import in_memory
    from lienumba.engine.simulate import Runs, Threads, portions
    from lienumba.scenario.start.prepare import check_initial
    from lienumba.scenario.start.stored_start import with_start

    if is_modes(ds):
        raise ScenarioError(f"{where}: holds modes, and only motions are compared")
    known = ds["run"].values
    labels = known[np.unique(np.linspace(0, len(known) - 1, min(count, len(known))).round().astype(int))]
    check_run(ds, where, int(labels[0]))
    check_allowed(scenario_tables(ds, where), where, "a check", allow_code)
    there = ds.sel(run=labels)
    inputs = {str(name): x.values for name, x in there.coords.items() if x.attrs.get("role") == "input"}
    try:
        scenario = _by_numba(scenario_of(ds, where))
        results = Results(scenario, check_initial(scenario))
    except ScenarioError as error:  # whose remedies are for another scenario than that of the dataset
        raise ScenarioError(*(replace(x, remedy="") for x in error.problems)) from None

    def started(nudge: float, runs: "Runs") -> "Iterator[Prepared]":
        for found in portions(scenario, runs):
            stored = START_STATE in there and found.rests is not None
            done = with_start(found, there[START_STATE].sel(run=found.labels).values) if stored else found
            yield done._replace(states=done.states * (1.0 + nudge * np.cos(np.arange(done.states.shape[1]))))

    runs = Runs(labels.astype(np.int64), inputs, results.nominal)
    every = (Threads(results, usable_cores(), partial(started, nudge)) for nudge in (0.0, NUDGE))
    here, nudged = (in_memory(results, runs, compute, tell) for compute in every)
    return [compare_run(*(of_run(x, int(run)) for x in (ds, here, nudged))) for run in labels]


def _by_numba(whole: Scenario) -> Scenario:
    """The scenario for the other engine, with all that it stores of the motion."""
    from lienumba.scenario.start.reference_engine import NUMBA

    data = {key: x for key, x in whole.to_dict().items() if key not in DROPPED}
    output = {key: x for key, x in data["output"].items() if key != "joint_coordinates"}
    sweep = {key: x for key, x in data["sweep"].items() if key != "stop"}
    return resolve(data | {"integrator": data["integrator"] | {"engine": NUMBA}, "output": output, "sweep": sweep})


def compare_run(there: "xr.Dataset", here: "xr.Dataset", nudged: "xr.Dataset") -> Recomputed:
    """The stored run against the recomputed one; nudged: the same with another roundoff. Residuals of joints and energy
    are left out, since they are roundoff or follow from the others."""
    one, other = common(there, here)
    left = (START_STATE, RELATIVE_DRIFT, *kept_largest(), *(x.name for x in kept_largest().values()))
    names = [str(name) for name, x in one.data_vars.items() if x.dtype.kind == "f" and x.size and name not in left]
    if not names:
        raise ScenarioError("the dataset has no variable of a motion")
    run, scales = int(there["run"].values[0]), dict[str, float]()
    for name in names:
        units = _scaled(one[name])
        scales[units] = max(scales.get(units, 0.0), float(np.nanmax(np.abs(one[name].values), initial=0.0)))
    found = [
        (_difference(one[name], other[name], scales, run), _limit(other[name], nudged[name], scales)) for name in names
    ]
    worst, limit = max(found, key=lambda x: x[0].relative / min(x[1], 1.0))
    stored, computed = (STATUS_NAMES[int(ds["status"].item())] for ds in (there, here))
    return Recomputed(run, stored, computed, len(names), worst, limit)


def _limit(one: "xr.DataArray", other: "xr.DataArray", scales: dict[str, float]) -> float:
    """By how much a variable may differ relatively; other: of another roundoff, at more times perhaps."""
    grown = _difference(one, other.reindex_like(one), scales, 0).relative
    return max(AGREE, ULPS * float(np.finfo(one.dtype).eps), ROUNDOFF_MARGIN * grown)


def _difference(one: "xr.DataArray", other: "xr.DataArray", scales: dict[str, float], run: int) -> Difference:
    """The largest of a variable of one run; scales: the largest value of each unit."""
    a, b = one.values.astype(float), other.transpose(*one.dims).values.astype(float)
    with np.errstate(invalid="ignore"):
        apart = np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.abs(a - b))
    apart = np.nan_to_num(apart, nan=np.inf)
    place = np.unravel_index(int(apart.argmax()), apart.shape)
    timed = "time" in one.dims
    time = float(one["time"].values[place[one.dims.index("time")]]) if timed else np.nan
    units = str(one.attrs.get("units", "1"))
    return Difference(str(one.name), units, float(apart.max()), scales[_scaled(one)], run, time)


def _scaled(x: "xr.DataArray") -> str:
    """By whose largest value a variable is measured: its unit, or itself where that says nothing."""
    units = str(x.attrs.get("units", "1"))
    return SHARED_SCALES.get(units, units) if units != "1" else f"{x.name} alone"
