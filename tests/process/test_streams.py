"""Nobody listening, or in another encoding: no run is lost, no exit code changes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCENARIO = """
title = "Fall — 落下"
[model]
[[model.bodies]]
name = "stone"
mass = 1
inertia = [1, 1, 1]
[integrator]
method = "rk4"
step = 0.01
end_time = 0.1
"""


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("redirection", ["2>&-", ">&-", "2>&1 | true", ">/dev/full 2>/dev/full"])
def test_a_stream_that_takes_nothing(redirection: str, unbuffered: str, tmp_path: Path) -> None:
    (tmp_path / "fall.toml").write_text(SCENARIO, encoding="utf-8")
    command = f"{sys.executable} -m lienumba run fall.toml {redirection}"
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert (tmp_path / "fall.nc").exists(), done.stderr
    assert done.returncode == 0, done.stderr


def test_a_title_that_the_terminal_cannot_show(tmp_path: Path) -> None:
    (tmp_path / "fall.toml").write_text(SCENARIO, encoding="utf-8")
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    for arguments in (["run", "fall.toml"], ["info", "fall.nc"]):
        done = subprocess.run(
            [sys.executable, "-m", "lienumba", *arguments], cwd=tmp_path, capture_output=True, env=environment
        )
        assert done.returncode == 0, done.stderr
        assert b"Fall" in done.stdout
