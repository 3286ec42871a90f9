"""Progress as lines, summaries and times for people."""

import io
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from lienumba.analysis.outcomes import Outcome
from lienumba.analysis.summary import Quantiles, Summary
from lienumba.engine import progress
from lienumba.present.terminal import console


@dataclass
class Report:
    stage: str
    done: int
    total: int = 1000
    failed: int = 0


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_progress_lines() -> None:
    stream, clock = io.StringIO(), Clock()
    lines = progress.ProgressLines(stream, clock)
    for second, report in (
        (0, Report("compile", 0)),
        (2, Report("run", 0)),
        (10, Report("run", 80)),
        (22, Report("run", 200, failed=2)),
        (40, Report("run", 380, failed=2)),
        (52, Report("run", 500, failed=2)),
        (102, Report("run", 1000, failed=3)),
        (103, Report("run", 1000, failed=3)),
        (104, Report("write", 1000, failed=3)),
    ):
        clock.now = second
        lines(report)
    assert stream.getvalue().splitlines() == [
        "compiling the mechanism (kept for the next time)",
        "simulating",
        "simulating: 380/1000 runs, 2 failed, 10 runs/s, 1 min 2 s left",
        "simulating: 1000/1000 runs, 3 failed, 10 runs/s, 0 s left",
        "writing the dataset",
    ]


def test_silence_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "SILENCE", 0.0)
    stream = io.StringIO()
    with progress.ProgressLines(stream) as lines:
        lines(Report("run", 0))
        lines(Report("run", 5))
        deadline = time.monotonic() + 10
        while "5/1000" not in stream.getvalue() and time.monotonic() < deadline:
            time.sleep(0.05)
    assert "simulating: 5/1000 runs, 0 failed" in stream.getvalue()
    assert all(thread.name != lines._watch.name for thread in threading.enumerate())


@pytest.mark.parametrize(("seconds", "text"), [(0.4, "0 s"), (59.4, "59 s"), (200, "3 min 20 s"), (7500, "2 h 5 min")])
def test_durations(seconds: float, text: str) -> None:
    assert progress.duration(seconds) == text


def summary(bodies: int, good: int) -> Summary:
    names = [f"b{index}" for index in range(bodies)]
    rows = [Quantiles("position", name, axis, "m", -1.0, 0.5, 12345.678901) for name in names for axis in "xyz"]
    outcomes = (
        Outcome("success", good, (0,), (2.0,)),
        Outcome("non_finite", 9, (3, 17), (0.5, 0.75)),
    )
    drift = Quantiles("energy", "", "", "J", 1.0, 2.0, 3.0)
    return Summary("A [top]", good + 9, good, good, good, 2.0, outcomes, (*rows, drift), (), 1e-16, None, 1.0, 2e-9)


def test_summary(capsys: pytest.CaptureFixture[str]) -> None:
    console.print_summary(summary(1, 991), Path("out.nc"))
    text = capsys.readouterr().out
    assert "A [top]: 991 of 1,000 runs good, 9 failed" in text
    assert "9 non_finite: " in text
    assert "runs 3 (at 0.5 s), 17 (at 0.75 s), ..." in text
    assert "look at one: lienumba replay out.nc --run 3\n" in text
    assert "12345.7" in text
    assert "median" in text
    assert "energy" in text
    assert "largest position violation 1.0e-16 m, relative energy drift 2.0e-09" in text
    assert text.splitlines()[-1] == "written to out.nc"


def test_summary_of_many_bodies_shows_the_last(capsys: pytest.CaptureFixture[str]) -> None:
    console.print_summary(summary(8, 1), Path("out.nc"))
    text = capsys.readouterr().out
    assert "the last of 8 bodies" in text
    assert "b7" in text
    assert "b6" not in text
    assert "value" in text
    assert "median" not in text
