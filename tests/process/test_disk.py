"""A disk that is full, for shards or for the dataset: a sentence, nothing lost, and --resume when there is room."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.store import shards
from lienumba.store.outputs import WriteError
from tests.facade import app
from tests.rigs.disturbed import assert_same_data, sweep
from tests.rigs.places import ROOT

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs a POSIX system")
RUNS = 400  # 1.2 MB of shards, and half as much of a dataset


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a disk of a size to be set."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if os.geteuid() or subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", folder], check=False, capture_output=True
    ).returncode:  # fmt: skip
        pytest.skip("mounting a small disk needs root")
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def fill(folder: Path, left: int) -> None:
    """Leave so many bytes of the disk."""
    free = os.statvfs(folder).f_bavail * os.statvfs(folder).f_bsize
    with (folder / "filler").open("wb") as file:
        file.write(b"\0" * max(free - left, 0))


def data() -> dict[str, Any]:
    return sweep(RUNS, every=0.01, variables=["position", "rotation", "velocity", "angular_velocity"])


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every chunk is a shard."""
    monkeypatch.setattr(shards, "PAUSE", 0.0)


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("left", [2000, 100_000, 350_000, 700_000, 900_000])
def test_a_full_disk(left: int, small_disk: Path) -> None:
    target = small_disk / "out.nc"
    fill(small_disk, left)
    with pytest.raises(WriteError) as told:
        lienumba.run(data(), workers=2, output=target)
    assert "could not be written (No space left on device): it takes more than the 0." in str(told.value)
    assert "make room" in str(told.value)
    assert not target.exists()
    assert list(small_disk.glob("out.nc.*.partial")) == []
    folder = small_disk / "out.nc.runs"
    safe = [path.name for path in folder.glob("run-*.npy")]
    assert all(name.endswith(".npy") for name in safe)
    (small_disk / "filler").unlink()
    told_of: list[Any] = []
    with lienumba.run(data(), output=target, resume=True, progress=told_of.append) as resumed:
        assert_same_data(resumed, lienumba.run(data()))
    done = next(event.done for event in told_of if event.stage != "prepare")
    assert done > 0 or left < 350_000
    assert sorted(path.name for path in small_disk.iterdir()) == ["out.nc"]


@pytest.mark.usefixtures("at_once")
def test_a_limit_on_the_size_of_files(tmp_path: Path) -> None:
    """The dataset is larger than a file may be, its shards are not."""
    code = f"""
import resource, sys
sys.path.insert(0, {str(ROOT)!r})
import lienumba
from tests.process.test_disk import data
from lienumba.store import shards
shards.PAUSE = 0.0
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))
try:
    lienumba.run(data(), workers=2, output={str(tmp_path / "out.nc")!r})
except lienumba.store.outputs.WriteError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "could not be written (File too large): " in done.stdout, done.stderr
    assert "ulimit -f" in done.stdout
    assert "room" not in done.stdout


@pytest.mark.parametrize("command", ["merge", "report", "table", "replay"])
def test_commands_name_the_reason_and_the_room(command: str, small_disk: Path, tmp_path: Path) -> None:
    """None shows what the library of the files says of itself."""
    source = tmp_path / "out.nc"
    lienumba.run(sweep(20, every=0.01), output=source)
    more = {"merge": [], "replay": ["--run", "3"]}.get(command, [])
    fill(small_disk, 0)
    target = small_disk / {"report": "out.html", "table": "out.csv"}.get(command, "out.nc")
    done = CliRunner().invoke(app, [command, str(source), *more, "--output", str(target)])
    (told,) = (line for line in done.output.splitlines() if line.startswith("error: "))
    assert done.exit_code == 1
    assert f"output = {target}: could not be written (No space left on device): it takes " in told
    assert f"{small_disk} has 0.0 MB free" in told or f"0.0 MB that {small_disk} has free" in told
    assert told.endswith("make room there, or choose another folder")
    assert "HDF" not in told
