"""Ctrl-C: exit code 130, no file, and nothing goes on computing."""

import signal
import threading
from pathlib import Path
from typing import Any

import pytest

import lienumba
from tests.process.programs import PATIENCE, started, until
from tests.rigs.places import ROOT, SCENARIOS
from tests.rigs.sweeps import top

TOP = SCENARIOS / "heavy_top_monte_carlo.toml"
HOURS = ("--set", "sweep.runs=5000", "--set", "integrator.end_time=20000", "--set", "output.every=100")
ONE_OUTPUT = (*HOURS[:-1], "output.every=20000")


@pytest.mark.parametrize(
    ("options", "workers"), [(HOURS, 1), (ONE_OUTPUT, 2)], ids=["outputs", "one output at the end"]
)
def test_an_interrupted_run_ends_with_130_and_leaves_no_file(
    options: tuple[str, ...], workers: int, tmp_path: Path
) -> None:
    command = ["run", TOP, "-o", tmp_path / "top.nc", "-j", workers, *options]
    with started(*command, folder=tmp_path) as process:
        until(process, "simulating")
        threading.Event().wait(0.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "interrupted: no dataset was written" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_ends_with_130_and_no_file(tmp_path: Path) -> None:
    """As soon as threads simulate, before any is done."""
    options = ["-o", tmp_path / "top.nc", "--set", "sweep.runs=100000", "--set", "output.every=1"]
    with started("run", TOP, *options, folder=ROOT) as process:
        until(process, "simulating")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert errors.splitlines()[-1] == "interrupted: no dataset was written"
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
