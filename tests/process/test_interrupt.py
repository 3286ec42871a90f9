"""Ctrl-C: exit code 130, no file, and nothing goes on computing."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

import lienumba
from tests.rigs.places import SCENARIOS
from tests.rigs.sweeps import top

TOP = SCENARIOS / "heavy_top_monte_carlo.toml"
HOURS = ("--set", "sweep.runs=5000", "--set", "integrator.end_time=20000", "--set", "output.every=100")
ONE_OUTPUT = (*HOURS[:-1], "output.every=20000")
PATIENCE = 60.0  # s, for a machine that has other things to do


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("options", [HOURS, ONE_OUTPUT], ids=["outputs", "one output at the end"])
def test_an_interrupted_run_ends_with_130_and_leaves_no_file(
    options: tuple[str, ...], workers: int, tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "lienumba", "run", TOP, "-o", tmp_path / "top.nc", "-j", str(workers), *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, cwd=tmp_path,
                               start_new_session=True)  # fmt: skip
    try:
        assert process.stderr is not None
        for line in process.stderr:
            if "simulating" in line:
                break
        assert process.poll() is None
        threading.Event().wait(0.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    assert process.returncode == 130
    assert "interrupted: no dataset was written" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_in_python_the_interrupt_is_raised_and_no_thread_stays(error: type[BaseException], tmp_path: Path) -> None:
    before = set(threading.enumerate())
    data = top(runs=5000, end=20000.0, output={"every": 100.0})
    stages = []

    def interrupt(event: Any) -> None:
        stages.append(event.stage)
        if stages.count("run") == 2:
            raise error

    with pytest.raises(error):
        lienumba.run(data, workers=2, progress=interrupt, output=tmp_path / "top.nc")
    assert set(threading.enumerate()) <= before
    assert list(tmp_path.iterdir()) == []


def test_the_next_run_is_not_disturbed() -> None:
    def interrupt(event: Any) -> None:
        if event.stage == "run":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lienumba.run(top(), progress=interrupt)
    dataset = lienumba.run(top())
    assert (dataset["status"] == 0).all()
    assert (dataset["steps"] == 50).all()
