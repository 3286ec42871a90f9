"""kill -9: at random moments, and right before and behind everything that reaches the disk."""

import os
import shutil
import signal
from collections.abc import Callable
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


def killed_at(data: dict[str, Any], target: Path, call: int, behind: bool) -> bool:
    """Run a sweep that kills itself at the so-manieth file that gets its name, before that or behind it; whether there
    were as many."""
    rename, calls = os.replace, [0]

    def replace(*names: Any, **more: Any) -> None:
        here = calls[0] == call
        calls[0] += 1
        if here and not behind:
            os.kill(os.getpid(), signal.SIGKILL)
        rename(*names, **more)
        if here:
            os.kill(os.getpid(), signal.SIGKILL)

    def act() -> None:
        os.replace = replace  # type: ignore[assignment]
        shards.PAUSE = 0.0
        lienumba.run(data, workers=1, output=target, resume=True)
        os._exit(0)

    return in_child(act) == signal.SIGKILL


@pytest.mark.parametrize("behind", [False, True], ids=["before", "behind"])
def test_killed_at_every_file_that_gets_its_name(whole: Any, behind: bool, tmp_path: Path) -> None:
    data, expected = whole
    call = 0
    while True:
        target = tmp_path / "out.nc"
        if not killed_at(data, target, call, behind):
            break
        assert not target.exists() or behind
        with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
            assert_same_data(resumed, expected)
        assert [path.name for path in tmp_path.iterdir() if not path.name.endswith(".partial")] == ["out.nc"]
        target.unlink()
        for path in tmp_path.glob("*.partial"):
            path.unlink()
        call += 1
    assert call >= 6, "the manifest, shards and the dataset"


def test_killed_again_and_again(whole: Any, tmp_path: Path) -> None:
    """Every child gets one shard further."""
    data, expected = whole
    target = tmp_path / "out.nc"
    kills = 0
    while killed_at(data, target, 1, behind=True):
        kills += 1
        assert kills < 100
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, expected)
    assert kills >= 3
    assert list(tmp_path.glob("*.runs")) == []


def test_a_folder_without_its_manifest_is_no_sweep(whole: Any, tmp_path: Path) -> None:
    data, expected = whole
    target = tmp_path / "out.nc"
    assert killed_at(data, target, 0, behind=False)
    assert (tmp_path / "out.nc.runs").is_dir()
    assert not (tmp_path / "out.nc.runs" / shards.MANIFEST).exists()
    with lienumba.run(data, workers=1, output=target, resume=True) as resumed:
        assert_same_data(resumed, expected)
    shutil.rmtree(tmp_path)
    assert np.all(expected.status == 0)
