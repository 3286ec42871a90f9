"""--resume: from damaged shards, with more runs, and refused where what is there is of another sweep."""

import json
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.engine.disk.sweep_files import check_room
from lienumba.store import shards
from tests.facade import ScenarioError
from tests.rigs.disturbed import FULL, SUMMARY, assert_same_data, sweep

KINDS = pytest.mark.parametrize("output", [FULL, SUMMARY], ids=["full", "summary"])


class EnoughError(Exception):
    """Ends a sweep in the middle."""


def begin(data: dict[str, Any], target: Path, monkeypatch: pytest.MonkeyPatch, **options: Any) -> Path:
    """A sweep that ends in the middle, when there are three shards of runs; their folder."""
    folder = target.with_name(f"{target.name}.runs")

    def stop(event: Any) -> None:
        if len(list(folder.glob("run-*.npy"))) >= 3:
            raise EnoughError

    with monkeypatch.context() as patch:
        patch.setattr(shards, "PAUSE", 0.0)
        with pytest.raises(EnoughError):
            lienumba.run(data, workers=1, output=target, progress=stop, **options)
    return folder


def flip(path: Path, at: int) -> None:
    content = bytearray(path.read_bytes())
    content[at] ^= 16
    path.write_bytes(content)


DAMAGES = {
    "truncated": (1, lambda path: os.truncate(path, path.stat().st_size // 2)),
    "empty": (1, lambda path: os.truncate(path, 0)),
    "a bit of the header": (1, lambda path: flip(path, 20)),
    "a bit of the data": (1, lambda path: flip(path, path.stat().st_size - 100)),
    "the first bit": (1, lambda path: flip(path, 0)),
    "gone": (0, lambda path: path.unlink()),
    "longer": (1, lambda path: path.write_bytes(path.read_bytes() + b"\0")),
    "another name": (1, lambda path: path.rename(path.with_name("run-0-7-01234567.npy"))),
    "not finished": (0, lambda path: path.rename(path.with_name(f"{path.name}.partial"))),
}


@KINDS
def test_damaged_shards_are_computed_again(output: dict[str, Any], tmp_path: Path, monkeypatch: Any) -> None:
    data, target = sweep(**output), tmp_path / "out.nc"
    expected = lienumba.run(data, workers=1)
    folder = begin(data, target, monkeypatch)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert sum(name.startswith("run-") for name in before) >= 3
    for table in sorted({path.name.partition("-")[0] for path in folder.glob("*.npy")}):
        for seen, damage in DAMAGES.values():
            folder.mkdir(exist_ok=True)
            for name, content in before.items():
                (folder / name).write_bytes(content)
            victim = sorted(folder.glob(f"{table}-*.npy"))[1]
            damage(victim)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
                    assert_same_data(resumed, expected)
            assert [f"{folder}: 1 file was damaged" in str(item.message) for item in told] == [True] * seen
            assert not folder.exists()
            target.unlink()


def test_a_course_that_is_computed_again_replaces_its_shard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The shard of the course has the name that it had before, where that of the runs alone is gone."""
    data, target = sweep(**SUMMARY), tmp_path / "out.nc"
    folder = begin(data, target, monkeypatch)
    sorted(folder.glob("run-*.npy"))[1].unlink()
    monkeypatch.setattr(shards, "PAUSE", 0.0)
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, lienumba.run(data, workers=1))


def test_of_what_is_whole_nothing_is_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    begin(data, target, monkeypatch)
    told: list[Any] = []
    lienumba.run(data, workers=1, output=target, resume=True, progress=told.append).close()
    assert next(event.done for event in told if event.stage == "run") >= 24
    told.clear()
    lienumba.run(data, output=target, resume=True, progress=told.append).close()
    assert {event.stage for event in told} == {"prepare", "write"}, "a finished sweep has nothing left to compute"


@KINDS
@pytest.mark.parametrize("sampler", ["random", "sobol", "halton"])
def test_a_sweep_gets_more_runs(sampler: str, output: dict[str, Any], tmp_path: Path) -> None:
    few, many = sweep(20, sampler=sampler, **output), sweep(70, sampler=sampler, **output)
    target = tmp_path / "out.nc"
    lienumba.run(few, workers=1, output=target).close()
    with lienumba.run(many, workers=1, output=target, resume=True) as extended:
        assert_same_data(extended, lienumba.run(many, workers=1))


def test_an_interrupted_sweep_gets_more_runs_and_the_nominal_one(tmp_path: Path, monkeypatch: Any) -> None:
    target, more = tmp_path / "out.nc", sweep(70)
    begin(sweep(40), target, monkeypatch)
    more["sweep"]["nominal"] = True
    with lienumba.run(more, workers=1, output=target, resume=True) as extended:
        assert extended.run.values.tolist() == list(range(-1, 70))
        assert_same_data(extended, lienumba.run(more, workers=1))


def test_some_runs_and_then_others(tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    for runs in ([3, 17], [5], [-1]):
        lienumba.run(data, workers=1, output=target, resume=True, runs=runs).close()
    with lienumba.run(data, output=target, resume=True, runs=[3]) as found:
        assert found.run.values.tolist() == [-1, 3, 5, 17]
        assert_same_data(found, lienumba.run(data, runs=[-1, 3, 5, 17]))


CHANGES = {
    "integrator.step": (5e-4, "integrator.step = 0.001 there and 0.0005 here"),
    "sweep.seed": (3, "sweep.seed = 2015 there and 3 here"),
    "gravity[2]": (-1.0, "model.gravity = [0.0, 0.0, -9.81] there and [0.0, 0.0, -1.0] here"),
    "output.every": (0.05, "output.every = 0.01 there and 0.05 here"),
    "output.summary": ({"position": ["max"]}, 'output.summary.position = nothing there and ["max"] here'),
    "sweep.runs": (10, " already, but sweep.runs = 10; give at least "),
}


@pytest.mark.parametrize("finished", [False, True])
def test_another_sweep_is_refused(finished: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    if finished:
        lienumba.run(data, workers=1, output=target).close()
    else:
        begin(data, target, monkeypatch)
    for path, (value, message) in CHANGES.items():
        with pytest.raises(ScenarioError) as refused:
            lienumba.run(data, output=target, resume=True, overrides={path: value})
        assert message in str(refused.value)
        assert "\n" not in str(refused.value)
    monkeypatch.setattr("lienumba.engine.disk.resume.__version__", "9.9")
    with pytest.raises(
        ScenarioError, match=f"begun by lienumba {lienumba.__version__}, but this is 9.9, whose results"
    ):
        lienumba.run(data, output=target, resume=True)


def test_a_sweep_keeps_the_runs_that_it_has() -> None:
    labels = np.array([-1, 3, 9])
    check_room("out.nc", labels, 10)
    check_room("out.nc", labels[:0], 1)
    with pytest.raises(ScenarioError, match=r"has runs up to 9 already, but sweep.runs = 9; give at least 10, "):
        check_room("out.nc", labels, 9)


def test_a_latin_hypercube_gets_no_more_runs(tmp_path: Path) -> None:
    target = tmp_path / "out.nc"
    lienumba.run(sweep(20, sampler="latin_hypercube"), output=target).close()
    with pytest.raises(
        ScenarioError, match='"latin_hypercube" divides each range into as many parts as there are runs'
    ):
        lienumba.run(sweep(40, sampler="latin_hypercube"), output=target, resume=True)


def test_what_is_there_is_not_overwritten_unasked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    folder = begin(data, target, monkeypatch)
    with pytest.raises(ScenarioError, match=r"an interrupted sweep has left its runs in .*out.nc.runs; go on"):
        lienumba.run(data, output=target)
    with pytest.raises(ScenarioError, match="give one of them"):
        lienumba.run(data, output=target, resume=True, overwrite=True)
    other = sweep()
    other["sweep"]["seed"] = 4
    with lienumba.run(other, workers=1, output=target, overwrite=True) as fresh:
        assert_same_data(fresh, lienumba.run(other, workers=1))
    assert not folder.exists()


def test_resume_needs_an_output_and_no_study() -> None:
    with pytest.raises(ScenarioError, match="resume = True: there is nothing to go on with; name the output"):
        lienumba.run(sweep(), resume=True)


def test_a_damaged_manifest_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    folder = begin(data, target, monkeypatch)
    (folder / shards.MANIFEST).write_text("{")
    with pytest.raises(
        ScenarioError, match=r"sweep.json cannot be read \(.*\); remove the folder, or start again with"
    ):
        lienumba.run(data, output=target, resume=True)


def test_two_processes_do_not_write_the_same_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fcntl = pytest.importorskip("fcntl")
    data, target = sweep(), tmp_path / "out.nc"
    begin(data, target, monkeypatch)
    with (tmp_path / "out.nc.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(ScenarioError, match="another process is writing it; wait until it is done"):
            lienumba.run(data, output=target, resume=True)
    lienumba.run(data, workers=1, output=target, resume=True).close()


def test_the_manifest_tells_the_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = begin(sweep(), tmp_path / "out.nc", monkeypatch)
    manifest = json.loads((folder / shards.MANIFEST).read_text())
    assert manifest["lienumba_version"] == lienumba.__version__
    assert "[sweep]" in manifest["scenario"]


def test_what_was_to_be_overwritten_is_not_in_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """--overwrite is interrupted; --resume goes on with that, whatever the old dataset is of."""
    other, data, target = sweep(end=0.02), sweep(), tmp_path / "out.nc"
    lienumba.run(other, output=target).close()
    begin(data, target, monkeypatch, overwrite=True)
    with lienumba.run(other, runs=[3]) as old, lienumba.run(other, output=tmp_path / "x.nc") as same:
        assert_same_data(same.sel(run=[3]), old)
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, lienumba.run(data, workers=1))


def test_nothing_is_removed_for_what_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    folder = begin(data, target, monkeypatch)
    before = sorted(path.name for path in folder.iterdir())
    wrong = {"sweep.stop": {"variable": "nothing", "width": 1.0, "every": 8}}
    with pytest.raises(ScenarioError, match=r"sweep\.stop\.variable"):
        lienumba.run(data, output=target, overwrite=True, overrides=wrong)
    assert sorted(path.name for path in folder.iterdir()) == before


def test_shards_without_a_manifest_are_nobodys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder that was being removed: its shards must not become those of another sweep."""
    data, other, target = sweep(), sweep(), tmp_path / "out.nc"
    other["sweep"]["seed"] = 4
    folder = begin(data, target, monkeypatch)
    (folder / shards.MANIFEST).unlink()
    for path in sorted(folder.glob("run-*"))[:2]:
        path.unlink()

    def stop(event: Any) -> None:
        if (folder / shards.MANIFEST).exists():
            raise EnoughError

    monkeypatch.setattr(shards, "PAUSE", 0.0)
    with pytest.raises(EnoughError):
        lienumba.run(other, workers=1, output=target, resume=True, progress=stop)
    with lienumba.run(other, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, lienumba.run(other, workers=1))


@pytest.mark.parametrize("finished", [False, True])
def test_the_order_is_part_of_a_sweep(finished: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what varies: a Sobol' sequence has its dimensions in this order; and of bodies, which records have in it."""
    data, target = sweep(sampler="sobol"), tmp_path / "out.nc"
    if finished:
        lienumba.run(data, workers=1, output=target).close()
    else:
        begin(data, target, monkeypatch)
    turned = sweep(sampler="sobol")
    turned["sweep"]["vary"] = dict(reversed(turned["sweep"]["vary"].items()))
    with pytest.raises(ScenarioError, match=r"belongs to another scenario, sweep\.vary \(order\) = "):
        lienumba.run(turned, output=target, resume=True)


def test_runs_that_were_finished_keep_their_samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another version of SciPy might draw others."""
    data, target = sweep(), tmp_path / "out.nc"
    with lienumba.run(data, workers=1, output=target) as first:
        had = first["bodies.top.mass"].values
    from lienumba.scenario.start import design

    draw = design.draw
    monkeypatch.setattr(design, "draw", lambda *given: {path: x * 1.001 for path, x in draw(*given).items()})
    more = sweep(50)
    with lienumba.run(more, workers=1, output=target, resume=True) as extended:
        assert (extended["bodies.top.mass"].values[:40] == had).all()
        assert (
            extended["bodies.top.mass"].values[40:] != lienumba.run(more)["bodies.top.mass"].values[40:] / 1.001
        ).any()


def test_too_little_memory_is_told_and_nothing_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the middle, as NumPy says it."""
    from lienumba.batch import execute

    data, target, calls = sweep(), tmp_path / "out.nc", [0]
    integrate = execute.integrate

    def greedy(*given: Any) -> Any:
        calls[0] += 1
        if calls[0] == 4:
            np.empty((1 << 60,), np.uint8)
        return integrate(*given)

    with monkeypatch.context() as patch:
        patch.setattr(execute, "integrate", greedy)
        patch.setattr(shards, "PAUSE", 0.0)
        with pytest.raises(
            MemoryError, match=r"Unable to allocate .*; \d+ of 40 runs are kept in .*; go on with resume=True"
        ):
            lienumba.run(data, workers=1, output=target)
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, lienumba.run(data, workers=1))
