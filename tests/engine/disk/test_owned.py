"""The output of a sweep belongs to one process, from the first moment to the last, and costs nobody another file."""

import json
import os
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.store import shards
from lienumba.store.deflate import checksum
from lienumba.store.outputs import LostError, TakenError
from tests.facade import ScenarioError
from tests.rigs.disturbed import assert_same_data, sweep


class Meanwhile:
    """Does something once while runs are simulated, when so many are done."""

    def __init__(self, act: Callable[[], object], done: int = 0) -> None:
        self.act, self.done, self.over = act, done, False

    def __call__(self, event: Any) -> None:
        if event.stage == "run" and event.done >= self.done and not self.over:
            self.over = True
            self.act()


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every chunk is a shard."""
    monkeypatch.setattr(shards, "PAUSE", 0.0)


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_file_that_appears_meanwhile_is_left_and_nothing_is_lost(overwrite: bool, tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    appears = Meanwhile(lambda: target.write_text("dear to somebody"))
    with pytest.raises(TakenError) as told:
        lienumba.run(data, output=target, overwrite=overwrite, progress=appears)
    other = tmp_path / "out.2.nc"
    said = "somebody has written it meanwhile, and it is left as it is; what was made here is in"
    assert str(told.value) == f"output = {target}: {said} {other}"
    assert target.read_text() == "dear to somebody"
    assert sorted(x.name for x in tmp_path.iterdir()) == ["out.2.nc", "out.nc"]
    with lienumba.merge([other], tmp_path / "same.nc") as kept:
        assert_same_data(kept, lienumba.run(data))


def test_a_dataset_that_is_changed_meanwhile_is_left(tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    lienumba.run(data, output=target).close()
    changed = target.read_bytes() + b"more"
    with pytest.raises(TakenError):
        lienumba.run(data, output=target, overwrite=True, progress=Meanwhile(lambda: target.write_bytes(changed)))
    assert target.read_bytes() == changed


def test_the_second_of_two_runs_ends_with_a_sentence(tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    said: list[str] = []

    def second() -> None:
        for more in ({}, {"overwrite": True}, {"resume": True}):
            with pytest.raises(ScenarioError) as told:
                lienumba.run(data, output=target, **more)  # type: ignore[arg-type]
            said.append(str(told.value))

    def elsewhere() -> None:
        thread = threading.Thread(target=second)
        thread.start()
        thread.join()

    lienumba.run(data, output=target, progress=Meanwhile(elsewhere)).close()
    sentence = "another process is writing it; wait until it is done, or choose another output"
    assert said == [f"output = {target}: {sentence}"] * 3
    assert [x.name for x in tmp_path.iterdir()] == ["out.nc"]


def test_a_link_in_the_place_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    names = ("run-0-9-0123abcd.npy", "sweep.json", "thesis.tex")
    for name in names:
        (mine / name).touch()
    (tmp_path / "out.nc.runs").symlink_to(mine)
    for more in ({}, {"overwrite": True}, {"resume": True}):
        with pytest.raises(ScenarioError, match=r"out\.nc\.runs is no folder; remove it, or choose another name"):
            lienumba.run(sweep(), output=tmp_path / "out.nc", **more)  # type: ignore[arg-type]
    assert sorted(x.name for x in mine.iterdir()) == sorted(names)


def interrupted(data: dict[str, Any], target: Path) -> list[Path]:
    """A sweep that an error has ended, and its shards of runs."""

    def end() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lienumba.run(data, output=target, workers=1, progress=Meanwhile(end, 17))
    found = sorted(target.with_name("out.nc.runs").glob("run-*.npy"))
    assert found
    return found


@pytest.mark.usefixtures("at_once")
def test_only_what_is_its_own_is_removed(tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    interrupted(data, target)
    folder = tmp_path / "out.nc.runs"
    (folder / "thesis.tex").touch()
    (tmp_path / "elsewhere").write_text("kept")
    (folder / "run-90-99-0123abcd.npy").symlink_to(tmp_path / "elsewhere")
    lienumba.run(data, output=target, overwrite=True).close()
    assert [x.name for x in folder.iterdir()] == ["thesis.tex"]
    assert (tmp_path / "elsewhere").read_text() == "kept"


def sound(folder: Path, table: str, records: np.ndarray) -> None:
    """A shard whose checksum is right."""
    np.save(folder / "new.npy", records)
    content = (folder / "new.npy").read_bytes()
    (folder / "new.npy").rename(folder / f"{table}-0-9-{checksum(content):08x}.npy")


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(
    "records",
    [
        np.zeros(3),
        np.zeros((2, 2), [("label", "i8")]),
        np.zeros(3, [("label", "f8"), ("status", "U3")]),
        np.array(["abc"]),
    ],
)
def test_shards_of_something_else_are_damaged_ones(records: np.ndarray, tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    first, *_ = interrupted(data, target)
    whole = np.load(first)
    sound(first.parent, "run", records)
    sound(first.parent, "run", np.concatenate([whole[:1], whole[:1]]))  # one run twice
    with pytest.warns(UserWarning, match="2 files were damaged; their runs are simulated again"):
        resumed = lienumba.run(data, output=target, resume=True)
    with resumed:
        assert_same_data(resumed, lienumba.run(data))


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("text", ["[1, 2]", "5", '"x"', "{}", '{"scenario": 5}', "[" * 100_000, "no"])
def test_a_manifest_of_something_else(text: str, tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    interrupted(data, target)
    (tmp_path / "out.nc.runs" / shards.MANIFEST).write_text(text)
    with pytest.raises(ScenarioError, match=r"sweep\.json cannot be read \(.*\); remove the folder, or start again"):
        lienumba.run(data, output=target, resume=True)


@pytest.mark.usefixtures("at_once")
def test_a_manifest_whose_scenario_is_no_toml(tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    interrupted(data, target)
    path = tmp_path / "out.nc.runs" / shards.MANIFEST
    path.write_text(json.dumps(json.loads(path.read_text()) | {"scenario": "a ="}))
    with pytest.raises(ScenarioError, match=r"out\.nc\.runs: is not as lienumba wrote it, its attribute scenario"):
        lienumba.run(data, output=target, resume=True)


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("act", [Path.unlink, lambda path: path.write_bytes(path.read_bytes()[::-1])])
def test_shards_that_are_lost_meanwhile(act: Callable[[Path], object], tmp_path: Path) -> None:
    data, target = sweep(), tmp_path / "out.nc"
    interrupted(data, target)
    folder = tmp_path / "out.nc.runs"

    def all_shards() -> None:
        for path in folder.glob("run-*.npy"):
            act(path)

    with pytest.raises(
        LostError, match=r"has been removed or changed while .*: go on with resume=True, which simulates"
    ):
        lienumba.run(data, output=target, resume=True, progress=Meanwhile(all_shards))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".* damaged; their runs are simulated again")
        resumed = lienumba.run(data, output=target, resume=True)
    with resumed:
        assert_same_data(resumed, lienumba.run(data))
    assert [x.name for x in tmp_path.iterdir()] == ["out.nc"]


@pytest.mark.usefixtures("at_once")
def test_the_folder_is_removed_meanwhile(tmp_path: Path) -> None:
    """The runs that were in it are lost, and the sentence says how to go on."""
    data, target = sweep(), tmp_path / "out.nc"
    interrupted(data, target)
    folder = tmp_path / "out.nc.runs"

    def remove() -> None:
        for path in folder.iterdir():
            path.unlink()
        folder.rmdir()

    with pytest.raises(LostError):
        lienumba.run(data, output=target, resume=True, progress=Meanwhile(remove))
    with lienumba.run(data, output=target, resume=True) as resumed:
        assert_same_data(resumed, lienumba.run(data))


@pytest.mark.usefixtures("at_once")
def test_a_relative_output_stays_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    data = sweep()
    moves = Meanwhile(lambda: os.chdir(tmp_path / "there"))
    with lienumba.run(data, output="out.nc", progress=moves) as found:
        assert_same_data(found, lienumba.run(data))
    assert [x.name for x in (tmp_path / "here").iterdir()] == ["out.nc"]
    assert list((tmp_path / "there").iterdir()) == []
