"""kill -9: at random moments, and right before and behind everything that reaches the disk."""

import os
import shutil
import signal
import sys
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.store import shards
from tests.rigs.disturbed import FULL, SUMMARY, assert_same_data, sweep

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")


@pytest.fixture(scope="module", params=[FULL, SUMMARY], ids=["full", "summary"])
def whole(request: pytest.FixtureRequest) -> Any:
    """A sweep that nobody disturbs, and its scenario; here, so that children find everything compiled."""
    data = sweep(**request.param)
    return data, lienumba.run(data, workers=1)


def in_child(act: Callable[[], None]) -> int:
    """What a process of its own ends with that does this; it must have no threads when it begins."""
    child = os.fork()
    if child == 0:
        try:
            act()
        finally:
            os._exit(1)
    _, status = os.waitpid(child, 0)
    return os.WTERMSIG(status) if os.WIFSIGNALED(status) else -1


CHANGES = {"os.mkdir", "os.rmdir", "os.rename", "os.link", "os.remove"}  # of Python's audit; scripts/faults has more


def killed_at(data: dict[str, Any], target: Path, call: int, kinds: Collection[str] = CHANGES) -> bool:
    """Run a sweep that kills itself right before the so-manieth change of its folder, whatever is made, named or
    removed there, which is behind the one before; whether there were as many."""
    calls, folder = [0], str(target.parent)

    def audit(event: str, arguments: tuple[Any, ...]) -> None:
        if event not in kinds or not str(arguments[0]).startswith(folder):
            return
        calls[0] += 1
        if calls[0] > call:
            os.kill(os.getpid(), signal.SIGKILL)

    def act() -> None:
        shards.PAUSE = 0.0
        sys.addaudithook(audit)
        lienumba.run(data, workers=1, output=target, resume=True)
        os._exit(0)

    return in_child(act) == signal.SIGKILL


def test_killed_before_and_behind_everything_that_is_written(tmp_path: Path) -> None:
    data = sweep(16, every=0.01, mode="summary", full_runs="3:9")
    expected = lienumba.run(data, workers=1)
    target = tmp_path / "out.nc"
    call = 0
    while killed_at(data, target, call):
        with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
            assert_same_data(resumed, expected)
        assert [path.name for path in tmp_path.iterdir()] == ["out.nc"]
        target.unlink()
        call += 1
    assert call >= 12, "the lock, the folder, the manifest, shards, the dataset, and what is removed"


def test_killed_again_and_again(whole: Any, tmp_path: Path) -> None:
    """Every child gets one shard further."""
    data, expected = whole
    target = tmp_path / "out.nc"
    kills, tables = 0, 1 + ("full_runs" in data["output"])
    while killed_at(data, target, tables, ["os.rename"]):
        kills += 1
        assert kills < 100
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, expected)
    assert kills >= 3
    assert [path.name for path in tmp_path.iterdir()] == ["out.nc"]


def test_a_folder_without_its_manifest_is_no_sweep(whole: Any, tmp_path: Path) -> None:
    data, expected = whole
    target = tmp_path / "out.nc"
    assert killed_at(data, target, 0, ["os.rename"])
    assert (tmp_path / "out.nc.runs").is_dir()
    assert not (tmp_path / "out.nc.runs" / shards.MANIFEST).exists()
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, expected)
    shutil.rmtree(tmp_path)
    assert np.all(expected.status == 0)
