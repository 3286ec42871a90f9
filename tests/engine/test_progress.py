"""Where a run called from Python shows itself, and that no display stops a run."""

import io
import time
from contextlib import contextmanager
from dataclasses import dataclass

import pytest

from lienumba.engine import progress
from tests.facade import ScenarioError


@dataclass
class Event:
    stage: str = "run"
    done: int = 5
    total: int = 10
    failed: int = 0


@pytest.fixture
def seen(monkeypatch):
    """What a display that begins at once shows."""
    found = []

    @contextmanager
    def display():
        yield found.append

    monkeypatch.setattr(progress, "DELAY", 0.02)
    monkeypatch.setattr(progress, "bar", display)
    return found


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(("asked", "stream", "shows"), [
    (None, Terminal(), True), (None, io.StringIO(), False), (None, None, False), (False, Terminal(), False),
])  # fmt: skip
def test_a_bar_is_on_terminals_alone(asked, stream, shows, seen, monkeypatch):
    monkeypatch.setattr("sys.stderr", stream)
    with progress.shown(asked) as tell:
        tell(Event(done=1))
        deadline = time.monotonic() + (10 if shows else 0.1)
        while not seen and time.monotonic() < deadline:
            time.sleep(0.01)
        tell(Event(done=2))
    assert [event.done for event in seen] == ([1, 2] if shows else [])


def test_a_short_run_shows_nothing(seen, monkeypatch):
    monkeypatch.setattr(progress, "DELAY", 100.0)
    monkeypatch.setattr("sys.stderr", Terminal())
    with progress.shown(None) as tell:
        tell(Event())
    assert seen == []


def test_lines_where_they_are_asked_for(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr("sys.stderr", stream)
    with progress.shown(True) as tell:
        time.sleep(0.05)
        tell(Event())
        tell(Event(done=10))
    assert stream.getvalue().splitlines()[0] == "simulating"
    assert "10/10 runs, 0 failed" in stream.getvalue()


def test_a_function_is_told_itself():
    told = []
    with progress.shown(told.append) as tell:
        tell("event")
    assert told == ["event"]


@pytest.mark.parametrize("asked", [1, 0, "yes", []])
def test_what_is_no_function_is_refused(asked):
    with pytest.raises(ScenarioError) as refused, progress.shown(asked):
        raise AssertionError("nothing may run")
    assert str(refused.value) == (
        f"progress = {asked!r}: is neither True, False, None nor a function; give progress=False to show nothing, "
        "progress=True for lines, or a function that is called with each event"
    )


def test_a_display_that_fails_stops_nothing(monkeypatch):
    @contextmanager
    def broken():
        yield lambda event: 1 / 0

    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr(progress, "bar", broken)
    monkeypatch.setattr("sys.stderr", Terminal())
    with progress.shown(None) as tell:
        time.sleep(0.05)
        tell(Event())
