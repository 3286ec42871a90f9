"""Sweeps on clusters of dask: the bits of threads, whatever becomes of the workers."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from lienumba import ScenarioError
from lienumba.engine.cluster import connection, dask_worker
from lienumba.engine.cluster.dask_cluster import DEATHS, Cluster, Sent
from lienumba.engine.runner import Interrupted, runs_of
from lienumba.errors import ClusterError
from lienumba.scenario.reading.loading import load
from tests.engine.test_run_tables import weighted, written
from tests.facade import app, resolve
from tests.process.clusters import Processes
from tests.rigs.places import SCENARIOS
from tests.rigs.sweeps import assert_same, linkage, top

pytest.importorskip("distributed", reason='needs pip install ".[dask]"')

SUMMARY = {"mode": "summary", "full_runs": "3,17", "every": 0.01, "summary": {"position": ["max", "final"]}}


def measured(body: str) -> dict[str, Any]:
    """Numbers of whole runs, a function of one's own among them."""
    function = f"{Path(__file__).parents[1] / 'rigs' / 'reducers.py'}:swept"
    return {
        "quantities": [{"name": "tip", "type": "point", "body": body}],
        "measures": [{"name": "area", "value": "integral(tip.x*tip.z)"}, {"name": "way", "function": function}],
    }


def arm(runs: int) -> dict[str, Any]:
    """An arm with a controller that is a Python function."""
    vary = {"parameters.kp": {"distribution": "uniform", "low": 50, "high": 70}}
    return {**load(SCENARIOS / "arm_sampled.toml"), "sweep": {"runs": runs, "vary": vary}}


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Processes]:
    """A scheduler and two workers, which a test may kill if it sees to it that there is one in the end."""
    processes = Processes(tmp_path_factory.mktemp("dask"))
    try:
        processes.add()
        processes.add()
        yield processes
    finally:
        processes.close()


def long() -> dict[str, Any]:
    """Some seconds of work, in many chunks."""
    return top(runs=1500, end=10.0, output={"mode": "summary", "full_runs": "3", "every": 1.0})


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    """What threads make of it."""
    return lienumba.run(long())


@pytest.mark.parametrize(
    "data",
    [top(runs=100), top(runs=100, output=SUMMARY), linkage(runs=60) | measured("second"), arm(runs=20)],
    ids=["full", "summary", "runs that go again", "code of one's own"],
)
def test_a_cluster_gives_the_bits_of_threads(data: dict[str, Any], cluster: Processes) -> None:
    here = lienumba.run(data)  # first, so that the workers find its machine code
    assert_same(lienumba.run(data, dask=cluster.address), here)


def test_weights_and_courses_of_a_file(cluster: Processes, tmp_path: Path) -> None:
    data = weighted(written(tmp_path))
    assert_same(lienumba.run(data, dask=cluster.address), lienumba.run(data))


def test_a_client_is_used_and_left_open(cluster: Processes) -> None:
    from distributed import Client

    with Client(cluster.address, set_as_default=False) as client:
        there = lienumba.run(top(), runs=[-1, 5, 17], dask=client)
        assert_same(there, lienumba.run(top(), runs=[-1, 5, 17]))
        assert client.submit(len, "abc").result() == 3


@pytest.mark.release
def test_workers_die_and_others_come(cluster: Processes, whole: xr.Dataset, tmp_path: Path) -> None:
    events = []

    def disturb(event: Any) -> None:
        if event.stage == "run" and event.done and not events:
            cluster.kill_workers()
            cluster.add()
        if event.stage == "run" and event.done:
            events.append(event.done)

    there = lienumba.run(long(), output=tmp_path / "top.nc", dask=cluster.address, progress=disturb)
    assert events[0] < events[-1] <= 1500
    assert events == sorted(events)
    assert_same(there, whole)


@pytest.mark.release
def test_an_interrupt_keeps_what_is_done_and_the_rest_is_cancelled(
    cluster: Processes, whole: xr.Dataset, tmp_path: Path
) -> None:
    from distributed import Client

    def interrupt(event: Any) -> None:
        if event.stage == "run" and event.done:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match=r"interrupted: \d+ of 1500 runs are kept in .*; go on with resume=True"):
        lienumba.run(long(), output=tmp_path / "top.nc", dask=cluster.address, progress=interrupt)
    with Client(cluster.address, set_as_default=False) as client:
        assert client.submit(len, "abc").result(timeout=30) == 3
        assert sum(map(len, client.processing().values())) == 0
    there = lienumba.run(long(), output=tmp_path / "top.nc", resume=True)
    assert_same(there, whole)


def test_other_versions_on_a_worker_are_refused(cluster: Processes, monkeypatch: pytest.MonkeyPatch) -> None:
    here = dask_worker.versions()
    monkeypatch.setattr(dask_worker, "versions", lambda: here | {"numba": "0.1"})
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(top(), dask=cluster.address)
    assert str(refused.value).startswith("dask: the worker tcp://127.0.0.1:")
    assert str(refused.value).endswith(
        f" has numba {here['numba']}, but 0.1 is wanted; install the same versions on all machines"
    )


@pytest.mark.release
def test_a_lost_scheduler_ends_the_sweep_which_goes_on_without_it(whole: xr.Dataset, tmp_path: Path) -> None:
    own = Processes(tmp_path)
    own.add()

    def kill(event: Any) -> None:
        if event.stage == "run" and event.done:
            own.scheduler.kill()

    try:
        with pytest.raises(ClusterError) as lost:
            lienumba.run(long(), output=tmp_path / "top.nc", dask=own.address, progress=kill)
    finally:
        own.close()
    assert f"the cluster {own.address} was lost" in str(lost.value)
    assert "go on with resume=True" in str(lost.value)
    kept = int(str(lost.value).partition(" of 1500 runs are kept")[0].rpartition("; ")[2])
    assert 0 < kept < 1500
    assert_same(lienumba.run(long(), output=tmp_path / "top.nc", resume=True), whole)


@pytest.mark.release
def test_runs_that_kill_every_worker_are_named() -> None:
    resolved = resolve(top())
    cluster, runs = Cluster(resolved, "local", 1), runs_of(resolved, range(20))
    vars(cluster)["connection"] = SimpleNamespace(where="the cluster there")
    chunk = Sent(slice(8, 16))
    for _ in range(DEATHS):
        chunk = cluster._again(chunk, runs)
    with pytest.raises(ClusterError) as named:
        cluster._again(chunk, runs)
    assert str(named.value) == (
        "the cluster there: every worker that took the runs 8 to 15 has died; look at what the workers say, they may "
        "need more memory"
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dask": "tcp://"}, 'dask = "tcp://": is no cluster; give "local", the address of a scheduler such as '),
        ({"dask": 3}, "dask = 3: is no cluster; "),
        ({"dask": "10.0.0.1:8786", "workers": 2}, "workers = 2: a cluster has as many as were started; leave it out, "),
        ({"dask": "local", "workers": 0}, "workers = 0: must be a whole number of threads, at least 1"),
    ],
)
def test_what_is_no_cluster_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(top(), **options)
    assert str(refused.value).startswith(message)


def test_a_scheduler_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "PATIENCE", 1)
    with pytest.raises(ScenarioError, match=r"dask tcp://127.0.0.1:9: no scheduler answers there \(.*; start one by"):
        lienumba.run(top(), dask="tcp://127.0.0.1:9")


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(top(), dask="local")
    assert str(refused.value) == 'dask: is not installed; in the clone of lienumba, pip install ".[dask]"'


@pytest.mark.release
def test_a_local_cluster_from_the_command_line(tmp_path: Path) -> None:
    scenario = str(SCENARIOS / "heavy_top_monte_carlo.toml")
    options = ["--set", "sweep.runs=100", "--set", "integrator.end_time=0.05", "-q", "-j", "1", "-o"]
    for more in (["threads.nc"], ["local.nc", "--dask", "local"]):
        result = CliRunner().invoke(app, ["run", scenario, *options, str(tmp_path / more[0]), *more[1:]])
        assert result.exit_code == 0, result.output
    with xr.open_dataset(tmp_path / "threads.nc") as a, xr.open_dataset(tmp_path / "local.nc") as b:
        assert_same(a, b)
