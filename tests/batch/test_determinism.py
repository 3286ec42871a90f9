"""A run's result depends on its own inputs alone: not on workers, chunks, lanes, other runs, or what is stored."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch import execute
from lienumba.compiler.rows import W
from lienumba.integrators.codes import RESELECT
from tests.rigs.sweeps import COUNTS, SWEEPS, assert_same, bits, linkage, links, run, top, wheel

EVERY = pytest.mark.parametrize("sweep", SWEEPS.values(), ids=SWEEPS)


def test_other_seeds_give_other_bits() -> None:
    """The comparison is able to fail."""
    a, b = run(top(runs=3)), run(top(runs=3), seed=1)
    assert bits(a["position"]) != bits(b["position"])
    with pytest.raises(AssertionError, match="position"):
        assert_same(a, b)


@pytest.mark.parametrize("sweep", [*SWEEPS.values(), linkage], ids=[*SWEEPS, "linkage"])
def test_one_and_two_workers(sweep: Any) -> None:
    data = sweep(runs=60)
    assert_same(run(data, workers=1), run(data, workers=2))


@pytest.mark.usefixtures("anew")
@pytest.mark.parametrize("sweep", [top, wheel])
def test_programs_made_anew_give_the_same_bits(sweep: Any) -> None:
    data = sweep(runs=20)
    assert_same(run(data, workers=1), run(data, workers=2))


def test_runs_differ_from_each_other() -> None:
    end = run(top(runs=100))["position"].values[:, -1].reshape(100, -1)
    assert len(np.unique(end[:, 0])) == 100


@pytest.mark.parametrize("sweep", [wheel, linkage])
def test_some_runs_exchange_rows_and_others_do_not(sweep: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that all tests here see runs that go again, beside others than before."""
    found = []
    original = execute.integrate

    def watched(batch: Any, runs: slice, *rest: Any) -> Any:
        chunk = original(batch, runs, *rest)
        found.append(chunk.codes == RESELECT)
        return chunk

    monkeypatch.setattr(execute, "integrate", watched)
    run(sweep(runs=50))
    exchanged = np.concatenate(found)
    assert 10 < exchanged.sum() < 40
    assert len(exchanged) == 50 + exchanged.sum()


@EVERY
@pytest.mark.parametrize("workers", [1, 2])
def test_other_chunk_sizes(sweep: Any, workers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    data = sweep(runs=50)
    sizes = []
    original = execute.integrate

    def watched(batch: Any, runs: slice, *rest: Any) -> Any:
        sizes.append(runs.stop - runs.start)
        return original(batch, runs, *rest)

    monkeypatch.setattr(execute, "integrate", watched)
    monkeypatch.setattr(execute, "CHUNKS_PER_WORKER", 1)
    monkeypatch.setattr(execute, "FIRST_BLOCKS", 100)
    datasets = []
    for limit in (2**30, 1):  # bytes in a chunk: all of them; one block
        monkeypatch.setattr(execute, "CHUNK_BYTES", limit)
        sizes.clear()
        datasets.append(run(data, workers=workers))
        assert max(sizes) == (W if limit == 1 else {1: 50, 2: 3 * W}[workers])
    assert_same(*datasets)


@EVERY
def test_some_runs_alone(sweep: Any) -> None:
    full = run(sweep(runs=50))
    some = run(sweep(runs=50), runs=[17, 42])
    assert some["run"].values.tolist() == [17, 42]
    assert_same(some, full.sel(run=[17, 42]))


@EVERY
def test_any_lane(sweep: Any) -> None:
    """The same run as the first, the fifth and the last of its block, and behind a full block."""
    alone = run(sweep(runs=30), runs=[29])
    for first in (25, 22, 21):
        others = run(sweep(runs=30), runs=list(range(first, 30)))
        assert_same(others.sel(run=[29]), alone)


def test_more_runs_change_no_earlier_one() -> None:
    short = top(end=0.01)
    a, b = run(short, overrides={"sweep.runs": 1000}), run(short, overrides={"sweep.runs": 1003})
    assert b.sizes["run"] == 1003
    assert_same(a, b.isel(run=slice(0, 1000)))


@EVERY
def test_the_nominal_run_shifts_nothing(sweep: Any) -> None:
    data = sweep(runs=12)
    plain = run(data)
    nominal = run(data, runs=[-1, *range(12)])
    assert nominal["run"].values.tolist() == list(range(-1, 12))
    assert_same(nominal.sel(run=slice(0, None)), plain)
    assert_same(nominal.sel(run=[-1]), run(data, runs=[-1]))


def test_the_nominal_run_is_the_scenario_without_its_sweep() -> None:
    data = top()
    nominal = run(data, runs=[-1])
    del data["sweep"]
    plain = run(data)
    for name in ("position", "rotation", "velocity", "angular_velocity", "joint_force"):
        np.testing.assert_allclose(nominal[name], plain[name], rtol=1e-11, atol=1e-11)


def test_another_parameter_changes_no_other_sample() -> None:
    data = top()
    more = top()
    more["sweep"]["vary"]["gravity[2]"] = {"distribution": "uniform", "low": -9.82, "high": -9.8}
    a, b = run(data), run(more)
    for path in data["sweep"]["vary"]:
        assert bits(a[path]) == bits(b[path])
    assert bits(a["position"]) != bits(b["position"])


@EVERY
def test_what_is_stored_changes_no_bit(sweep: Any) -> None:
    full = run(sweep())
    for names in (["rotation"], ["energy", "multiplier"], ["joint_force", "velocity", "position_violation"]):
        output = {**sweep()["output"], "variables": names}
        some = run(sweep(output=output))
        assert set(names) <= set(some.data_vars)
        assert "position" not in some.data_vars
        assert_same(some, full, only_common=True)


@EVERY
def test_output_times_change_no_bit(sweep: Any) -> None:
    data = sweep()
    full = run(data)
    summaries = {name for name in full.data_vars if name.startswith("max_")}  # of the stored times
    assert len(summaries) == 4
    step, every, end = data["integrator"]["step"], float(full["time"][1]), float(full["time"][-1])
    for output in ({"every": step}, {"every": end}, {"times": [end]}, {"times": [0.0, every]}):
        other = run(sweep(output=output))
        times = np.intersect1d(full["time"], other["time"])
        assert len(times) == min(len(full["time"]), len(other["time"]))
        without = COUNTS | summaries | {"energy_residual"}
        assert_same(other.sel(time=times), full.sel(time=times), without=without)


@EVERY
def test_energy_residual_is_measured_from_the_start_of_the_run(sweep: Any) -> None:
    """Whether or not the start is stored."""
    full = run(sweep())
    assert (np.abs(full["energy_residual"].isel(time=-1)) > 0).all()
    end = run(sweep(output={"times": [float(full["time"][-1])]}))
    assert_same(end[["energy_residual"]], full[["energy_residual"]].isel(time=[-1]))


@pytest.mark.usefixtures("anew")
def test_a_repeated_call_and_a_file_hold_the_same_bits(tmp_path: Any) -> None:
    import xarray as xr

    data = links()
    returned = run(data, output=tmp_path / "links.nc", workers=2)
    with xr.open_dataset(tmp_path / "links.nc") as stored:
        assert_same(stored, run(data))
        assert_same(stored, returned)
    assert lienumba.run(data)["run"].dtype == np.int32
