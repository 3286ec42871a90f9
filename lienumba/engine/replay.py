"""One run of a dataset again, alone, from nothing but the dataset: its scenario and its samples are there.

The same machine code does it in the same steps, so all that both say of the run is the same to the bit; that is looked
at, not believed. More stored times move no step.
"""

import os
import warnings
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lienumba import __version__
from lienumba.engine.progress import shown
from lienumba.errors import ScenarioError
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.scenario.base import timegrid
from lienumba.scenario.base.code import check_allowed
from lienumba.scenario.base.toml import Tables
from lienumba.scenario.reading.run_tables import tables_of
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.store.form import scenario_tables
from lienumba.store.names import START_STATE
from lienumba.words import listed

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.engine.simulate import Progress, Tell

MOST_STEPS = 10_000  # so many stored intervals, unless others are asked for; where there are more steps, not every one
INTERVALS = 1000  # of a run whose steps a tolerance chooses
SAME_TIME = 1e-6  # of an interval


@dataclass(frozen=True)
class Replay:
    """The dataset of one run; `same`: whether it is the run of the file, to the bit, and `sentence`: how that is
    known, or what is otherwise."""

    dataset: "xr.Dataset"
    same: bool
    sentence: str


def replay(
    dataset: "str | os.PathLike[str] | xr.Dataset",
    run: int,
    *,
    every: float | None = None,
    allow_code: bool = False,
    output: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    progress: "Callable[[Progress], None] | bool | None" = None,
) -> "xr.Dataset":
    """Simulate one run of a dataset again, with its course at many times.

    Warns if it is not the same run to the bit.

    Parameters
    ----------
    dataset : xarray.Dataset or path
        What `lienumba.run` returned, or its file.
    run : int
        The label of the run.
    every : float, optional
        The interval between stored times in s; by default every step, and a thousandth of the run where a tolerance
        chooses steps.
    allow_code : bool
        Run the Python code that the dataset brings.
    output : path, optional
        Write the result to this netCDF file, too.
    overwrite : bool
        Whether `output` may be replaced.
    progress : callable or bool, optional
        As for `lienumba.run`.

    Returns
    -------
    xarray.Dataset
        Of this run alone.

    Raises
    ------
    ScenarioError
        Where the dataset has no such run, or brings code that may not run.
    """
    from lienumba.store.files import reading
    from lienumba.store.outputs import write
    from lienumba.store.targets import claimed_dataset

    with ExitStack() as stack:
        own = None if output is None else stack.enter_context(claimed_dataset(output, overwrite, resumable=False))
        ds, where = stack.enter_context(reading(dataset))
        with shown(progress) as tell:
            done = again(ds, where, run, every, allow_code, tell)
        for sentence in [*warnings_of(ds, where), *([] if done.same else [done.sentence])]:
            warnings.warn(sentence, stacklevel=2)
        if own is not None:
            write(done.dataset, own)
        return done.dataset


def again(ds: "xr.Dataset", where: str, run: int, every: float | None, allow_code: bool, tell: "Tell") -> Replay:
    """Simulate a run again, and compare; where: what the dataset is called."""
    from lienumba.engine.compare_runs import common, first_difference, of_run, times_of
    from lienumba.engine.select_run import check_run

    check_run(ds, where, run)
    there = of_run(ds, run)
    check_allowed(scenario_tables(ds, where), where, "a replay", allow_code)
    original = scenario_of(ds, where)
    dense = _dense(original, every)
    dataset, kept = _simulated(dense, original, there, run, tell)
    one, other = common(there, of_run(kept, run))
    difference, times = first_difference(one, other), times_of(one)
    if difference:
        return Replay(dataset, False, f"not the same as run {run} of {where}: {difference}; {_reason(there, dataset)}")
    extent = f"at {times:,} common times" if times else "in all that it keeps of a run"
    return Replay(dataset, True, f"the same bits as run {run} of {where} {extent}")


def warnings_of(ds: "xr.Dataset", where: str) -> list[str]:
    """What is to be known before a run is compared."""
    version = ds.attrs.get("lienumba_version")
    if version == __version__:
        return []
    return [f"{where}: was written by lienumba {version}, and this is {__version__}, whose results may differ"]


def scenario_of(ds: "xr.Dataset", where: str) -> Scenario:
    """The scenario of a dataset; code that comes with it has not run yet."""
    return resolve(tables_of(ds, where))


def _dense(original: Scenario, every: float | None) -> Scenario:
    """The scenario that stores the whole course, at the times of the original and at many more."""
    end, step = original.data.integrator.end_time, original.data.integrator.step
    if every is None:
        steps = INTERVALS if step is None else original.steps
        assert steps is not None
        every = float(timegrid.exact(end) / steps * -(-steps // MOST_STEPS))
    try:
        regular = _storing(original, {"every": every})
    except ScenarioError as error:
        told = (replace(x, place="every") if x.place == "output.every" else x for x in error.problems)
        raise ScenarioError(*told) from None
    fine, given = np.array(regular.times), np.array(original.times)
    behind = np.minimum(np.searchsorted(given, fine), len(given) - 1)
    distance = np.minimum(abs(fine - given[behind]), abs(fine - given[np.maximum(behind - 1, 0)]))
    times = np.union1d(given, fine[distance > SAME_TIME * every])
    return regular if np.array_equal(times, fine) else _storing(original, {"times": times.tolist()})


def _storing(original: Scenario, times: Tables) -> Scenario:
    """The scenario with the course of everything at these times."""
    own = original.data.output
    kept = {name: getattr(own, name) for name in ("summary", "joint_coordinates", "at_events", "max_changes")}
    also = [name for name in own.variables if name in OUTPUT_VARIABLES and OUTPUT_VARIABLES[name].asked]
    return resolve({**original.to_dict(), "output": {**times, **kept, "also": also}})


def _simulated(
    dense: Scenario, original: Scenario, there: "xr.Dataset", run: int, tell: "Tell"
) -> "tuple[xr.Dataset, xr.Dataset]":
    """The whole course of a run, and what its own scenario keeps of it."""
    from lienumba.engine.results import Twice
    from lienumba.engine.simulate import Memory, Runs, Threads, simulate
    from lienumba.scenario.start.prepare import Prepared, check_initial, prepare
    from lienumba.scenario.start.stored_start import with_start

    inputs = {str(name): x.values for name, x in there.coords.items() if x.attrs.get("role") == "input"}
    runs = Runs(np.array([run], np.int64), inputs, check_initial(dense))
    results = Twice(dense, runs.nominal, original)
    every, kept = Memory([run]), Memory([run])

    def prepared(runs: Runs) -> "list[Prepared]":
        found = prepare(dense, [run], runs.samples, runs.nominal, 1)
        stored = START_STATE in there and found.rests is not None
        return [with_start(found, there[START_STATE].values) if stored else found]

    for piece in simulate(runs, tell, Threads(results, 1, prepared)):
        every.take(piece)
        kept.take(results.kept(piece))
    both = ((results, every), (results.original, kept))
    whole, own = (x.dataset(memory.columns(np.ones(1, bool)), runs.labels, inputs, 1) for x, memory in both)
    return whole, own


def _reason(there: "xr.Dataset", here: "xr.Dataset") -> str:
    """What may have made a difference."""
    from lienumba.batch.statuses import NOT_CONVERGED

    keys = [key for key in there.attrs if key.endswith("_version") and there.attrs[key] != here.attrs.get(key)]
    if keys:
        return "a reason may be " + listed(
            f"{key.removesuffix('_version')} {there.attrs[key]} there and {here.attrs.get(key)} here" for key in keys
        )
    if here["status"].item() == NOT_CONVERGED and here["end_time"].item() != there["end_time"].item():
        return "a state within its steps cannot be projected, and storing it ends the run; give every as in the file"
    return "the file was changed since it was written, or this is a fault of lienumba: please report it"
