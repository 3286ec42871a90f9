"""From a scenario to its dataset: prepare, compile, run, label, write."""

import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import TYPE_CHECKING

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.engine.cluster import connection
from lienumba.engine.part import share_of
from lienumba.engine.progress import shown
from lienumba.errors import ClusterError, ResultWarning, ScenarioError
from lienumba.scenario.base.arguments import check_count, labels_of
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.never import warnings_of
from lienumba.scenario.start.prepare import Nominal, check_initial, design, prepare
from lienumba.store.outputs import TakenError, WriteError
from lienumba.words import option, plural

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.engine.results import Results
    from lienumba.engine.simulate import Compute, Progress, Runs, Tell
    from lienumba.store.outputs import Output
    from lienumba.store.shards import Shards

NOT_KEPT = "interrupted: no run is kept; name an output, so that an interrupted sweep can go on with resume=True"
__all__ = ["Interrupted", "check_initial", "operation_counts", "run"]


class Interrupted(KeyboardInterrupt):
    """An interrupt of a sweep of which something is kept; its text says what."""


def run(
    scenario: object,
    *,
    output: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    seed: int | None = None,
    overrides: Mapping[str, object] | None = None,
    runs: Sequence[int] | None = None,
    part: str | tuple[int, int] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    dask: object = None,
    allow_code: bool = False,
    progress: "Callable[[Progress], None] | bool | None" = None,
) -> "xr.Dataset":
    """Simulate a scenario and return its dataset.

    A failed run is data (`status`, NaN after the failure), never an exception. An interrupt (Ctrl-C, or that of a
    notebook's kernel) ends the sweep, and says what is kept.

    Parameters
    ----------
    scenario : path, dict, System or Scenario
        What to simulate: a TOML file, its keys and values, or a `lienumba.System`.
    output : path, optional
        Write the dataset to this netCDF file, from which values are read when they are asked for, its runs in the order
        of their labels. Without it the dataset is in memory, its runs in the order of `runs`.
    workers : int, optional
        Threads; by default one for each core. With `dask="local"`: processes.
    seed : int, optional
        Instead of `sweep.seed`.
    overrides : mapping, optional
        New values by path, such as `{"integrator.step": 1e-4, "bodies.top.mass": 14.0}`.
    runs : sequence of int, optional
        The labels of the runs to simulate; all by default. -1 is the nominal run.
    part : str or (int, int), optional
        Such as "3/20", the third of twenty parts of these runs.
    resume : bool
        Go on with what an interrupted sweep has left beside `output`, or add runs to a finished one.
    overwrite : bool
        Whether `output` may be replaced.
    dask : str or distributed.Client, optional
        "local" for `workers` processes, the address of a scheduler, or a client, on whose workers runs are computed.
    allow_code : bool
        Run also the Python code that a TOML file brings in itself, or names outside its folder.
    progress : callable or bool, optional
        Called with a `Progress` a few times per second: its `stage` ("prepare", "compile", "run" or "write"), and how
        many runs are `done`, of a `total`, and `failed`. By default a run that takes more than a second shows itself on
        a terminal and in a notebook, not elsewhere; False: nowhere, True: everywhere.

    Returns
    -------
    xarray.Dataset
        Variables with units and frames on the dimensions run, time, body, ...; of a study errors and costs at each
        point of its grid.

    Raises
    ------
    ScenarioError
        For bad input, with all that is wrong, before anything runs.
    """
    from lienumba.engine import study
    from lienumba.engine.results import Results
    from lienumba.engine.simulate import Progress
    from lienumba.store.files import read
    from lienumba.store.layout import warnings_in
    from lienumba.store.outputs import write
    from lienumba.store.shards import Shards
    from lienumba.store.targets import claimed_dataset

    resolved = resolve(scenario, overrides=overrides, seed=seed, allow_code=allow_code)
    told = not isinstance(scenario, Scenario)  # else the command line tells them
    if told:
        for warning in warnings_of(resolved):
            warnings.warn(str(warning), stacklevel=2)
    check_workers(workers)
    labels = labels_of(runs, resolved.labels)
    if part is not None:
        labels = share_of(labels, part, resolved)
    check_count(len(labels), len(resolved.data.sweep.vary))
    if resolved.plan is not None:
        _check_study(resume, dask)
    if dask is not None:
        connection.check_dask(dask, workers)
    if output is None and resume:
        raise ScenarioError("resume = True: there is nothing to go on with; name the output of the interrupted sweep")
    workers = workers or usable_cores()
    with ExitStack() as stack:
        own = None if output is None else stack.enter_context(claimed_dataset(output, overwrite, resume))
        tell = stack.enter_context(shown(progress))
        tell(Progress("prepare", 0, len(labels), 0))  # of redundant loops that may take longer than simulating them
        if resolved.plan is not None:
            dataset = study.run(resolved, labels, workers, tell)
            for sentence in study.doubts(dataset) if told else ():
                warnings.warn(sentence, stacklevel=2)
            if own is not None:
                write(dataset, own)
                Shards(own).remove()
            return dataset
        results = Results(resolved, check_initial(resolved))
        compute = stack.enter_context(_computing(results, workers, dask))
        if own is None:
            dataset = in_memory(results, runs_of(resolved, labels, results.nominal), compute, tell)
        else:
            on_disk(results, labels, compute, tell, own, resume, overwrite, workers)
            dataset = read(own.target)
        for sentence in warnings_in(dataset) if told else ():
            warnings.warn(sentence, ResultWarning, stacklevel=2)
        return dataset


def check_workers(workers: int | None) -> None:
    """It must be a number of threads, or None."""
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise ScenarioError(f"workers = {workers!r}: must be a whole number of threads, at least 1")


def _check_study(resume: bool, dask: object) -> None:
    if resume:
        raise ScenarioError("a study is not resumed, because its times belong together; start it again")
    if dask is not None:
        raise ScenarioError("a study is not run on a cluster, because its times are of one machine; leave dask out")


@contextmanager
def _computing(results: "Results", workers: int, dask: object) -> "Iterator[Compute]":
    """What computes runs: threads, or a cluster."""
    from lienumba.engine.simulate import Threads

    if dask is None:
        yield Threads(results, workers)
        return
    from lienumba.engine.cluster.dask_cluster import Cluster

    with Cluster(results.resolved, dask, workers) as cluster:
        yield cluster


def in_memory(results: "Results", runs: "Runs", compute: "Compute", tell: "Tell") -> "xr.Dataset":
    """The dataset of these runs."""
    from lienumba.engine.quality import result_warnings
    from lienumba.engine.simulate import Memory, simulate
    from lienumba.engine.stopping import stopping_of

    resolved, memory = results.resolved, Memory(runs.labels.tolist())
    enough = stopping_of(resolved, results)
    try:
        for piece in enough.until(simulate(runs, tell, compute)):
            memory.take(piece)
    except KeyboardInterrupt:
        raise Interrupted(NOT_KEPT) from None
    kept = enough.kept(runs.labels)
    runs = runs.part(kept)
    said = enough.attributes() | result_warnings.attributes(resolved, runs, memory.column)
    return results.dataset(memory.columns(kept), runs.labels, runs.samples, len(runs.labels), **said)


def on_disk(
    results: "Results",
    labels: Sequence[int],
    compute: "Compute",
    tell: "Tell",
    output: "Output",
    resume: bool,
    overwrite: bool,
    threads: int,
) -> None:
    """Write the dataset of these runs, and of those that are there already; threads: that compress."""
    from lienumba.engine.disk.background_writer import background_writer
    from lienumba.engine.disk.resume import manifest
    from lienumba.engine.disk.sweep_files import Arrived, sweep_files
    from lienumba.engine.quality import result_warnings
    from lienumba.engine.simulate import Progress, simulate
    from lienumba.engine.stopping import stopping_of
    from lienumba.store.shards import LABEL
    from lienumba.store.stream import Stream

    resolved = results.resolved
    with sweep_files(output, results, resume) as there:
        shards, finished = there.shards, there.labels
        if shards.damaged:
            files = plural(len(shards.damaged), "file was", "files were")
            warnings.warn(f"{shards.named}: {files} damaged; their runs are simulated again", stacklevel=3)
        every = np.union1d(finished, labels).astype(np.int64).tolist()
        runs = there.samples(runs_of(resolved, every, results.nominal))
        enough = stopping_of(resolved, results)
        enough.know(finished, there.column)
        missing = runs.part(~np.isin(runs.labels, finished) & enough.kept(runs.labels))
        shards.begin(manifest(resolved) | {"overwrites": overwrite}, fresh=not resume)
        inputs, asked = list(runs.samples), len(runs.labels)

        def begin() -> Stream:  # not before the first steps, since it takes as long as thousands of them
            return Stream(results.frame(inputs, asked), output, threads)

        with background_writer(begin, results.labels(runs.labels)) as dataset, _kept(shards, asked):
            if len(missing.labels):

                def watched(event: Progress) -> None:
                    tell(event)
                    shards.look()

                pieces = simulate(missing, watched, compute, before=(len(finished), there.failed()))
                arrived = Arrived(runs.labels, finished)
                for piece in enough.until(pieces):
                    arrived.take(piece.tables["run"][LABEL])
                    if shards.take(piece.tables):
                        sure = arrived.prefix(enough.decided(runs.labels))
                        dataset.follow(sure, there.sources(results.tables))
            runs = runs.part(enough.kept(runs.labels) | np.isin(runs.labels, there.older))
            total, failed = len(runs.labels), there.failed()
            said = enough.attributes() | result_warnings.attributes(resolved, runs, there.column)
            dataset.finish(  # what cannot be written now can be from the shards
                results.labels(runs.labels),
                there.sources(results.tables),
                runs.samples,
                said,
                lambda done: tell(Progress("write", done, total, failed)),
            )
        shards.remove()


@contextmanager
def _kept(shards: "Shards", total: int) -> Iterator[None]:
    """What was computed goes to the disk, whatever happens; what ends the sweep before its time says so."""
    try:
        yield
    except (KeyboardInterrupt, ClusterError, MemoryError) as error:
        shards.flush()
        kept = len(shards.labels())
        if not kept and isinstance(error, KeyboardInterrupt):
            raise Interrupted("interrupted: no dataset was written") from None
        if not kept:
            raise
        there = f"{kept} of {total} runs are kept in {shards.named}; go on with {option('resume')}"
        if isinstance(error, KeyboardInterrupt):
            raise Interrupted(f"interrupted: {there}") from None
        kind = ClusterError if isinstance(error, ClusterError) else MemoryError
        raise kind(f"{error}; {there}") from None
    except TakenError:  # the dataset is whole
        shards.remove()
        raise
    except BaseException:
        with suppress(WriteError):
            shards.flush()
        raise


def runs_of(resolved: Scenario, labels: Sequence[int], nominal: Nominal | None = None) -> "Runs":
    """These runs, with their samples, where the scenario starts, which may be known."""
    from lienumba.engine.simulate import Runs

    return Runs(np.asarray(labels, np.int64), design(resolved, labels), nominal or check_initial(resolved))


def operation_counts(scenario: Scenario) -> dict[str, dict[str, int]]:
    """Operations of each kernel per evaluation and run: what the hardware must do."""
    from lienumba.engine.programs import program_of

    prepared = prepare(scenario, [0])
    return {name: kernel.counts() for name, kernel in program_of(scenario, prepared, fixed=True).kernels.items()}
