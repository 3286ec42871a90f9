"""How a sweep gets on, for people: a bar on a terminal, one line in a cell of a notebook, lines elsewhere."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from contextvars import copy_context
from typing import Any, Protocol, TextIO

from lienumba.errors import ScenarioError

LINE_INTERVAL = 30.0  # s between progress lines, where there is no terminal
PATIENCE = 5.0  # s that checks may take before lines say so: what is refused at once is told alone
SILENCE = 60.0  # s after which a line appears even if nothing has been reported
DELAY = 1.0  # s that a run called from Python may take before it shows anything
CELL_INTERVAL = 0.25  # s between two looks of a notebook's line
STAGES = {
    "prepare": "checking how runs start",
    "compile": "compiling the mechanism (kept for the next time)",
    "run": "simulating",
    "write": "writing the dataset",
}
BEFORE = ("prepare", "compile")  # which no run is done in


class Event(Protocol):
    """What the runner reports: the stage ("prepare", "compile", "run", "write"), and runs done and failed."""

    stage: str
    done: int
    total: int
    failed: int


Show = Callable[[Any], None]


def silent(event: Event) -> None:
    """Show nothing."""


@contextmanager
def shown(progress: Show | bool | None) -> Iterator[Show]:
    """What a run called from Python reports to: a function of the caller's own; or, if the run takes long and somebody
    may be looking, a bar on the terminal or a line in the notebook. False: nothing; True: lines if there is neither."""
    if callable(progress):
        yield progress
        return
    if progress is not None and not isinstance(progress, bool):
        raise ScenarioError(
            f"progress = {progress!r}: is neither True, False, None nor a function; give progress=False to show "
            "nothing, progress=True for lines, or a function that is called with each event"
        )
    begin = _place(sys.stderr, lines=progress is True) if progress is not False else None
    if begin is None:
        yield silent
    else:
        with Patient(begin) as show:
            yield show


def _place(stream: TextIO | None, lines: bool) -> Callable[[], AbstractContextManager[Show]] | None:
    if _in_notebook():
        return cell
    if stream is not None and stream.isatty():
        return bar
    return (lambda: ProgressLines(stream)) if lines and stream is not None else None


def _in_notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and getattr(ipython.get_ipython(), "kernel", None) is not None


class Patient:
    """Passes events on to a display, which begins after DELAY; a display that fails stops no run."""

    def __init__(self, begin: Callable[[], AbstractContextManager[Show]]) -> None:
        self.begin = begin
        self.show: Show = silent
        self.event: Event | None = None
        self._stack, self._lock, self._over = ExitStack(), threading.Lock(), threading.Event()
        context = copy_context()  # in which a notebook's kernel knows the cell
        self._watch = threading.Thread(target=context.run, args=(self._wait,), daemon=True)

    def __enter__(self) -> "Patient":
        self._watch.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._watch.join()
        with suppress(Exception):
            self._stack.close()

    def __call__(self, event: Event) -> None:
        with self._lock, suppress(Exception):
            self.event = event
            self.show(event)

    def _wait(self) -> None:
        if self._over.wait(DELAY):
            return
        with self._lock, suppress(Exception):
            self.show = self._stack.enter_context(self.begin())
            if self.event is not None:
                self.show(self.event)


@contextmanager
def bar() -> Iterator[Show]:
    """A bar on the terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("runs, {task.fields[failed]} failed,"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, console=Console(stderr=True)) as display:
        task = display.add_task(STAGES["prepare"], total=None, failed=0)

        def show(event: Event) -> None:
            text = STAGES.get(event.stage, event.stage)
            total = event.total if event.stage == "run" else None
            display.update(task, description=text, completed=event.done, total=total, failed=event.failed)

        yield show


@contextmanager
def cell() -> Iterator[Show]:
    """One line in the output of a notebook's cell, which ends as what was done."""
    from IPython.display import display

    clock, started, updated = Clock(), time.monotonic(), 0.0
    last: Event | None = None
    handle = display(_line("", ""), raw=True, display_id=True)

    def show(event: Event) -> None:
        nonlocal last, updated
        now, changed = time.monotonic(), last is None or event.stage != last.stage
        last = event
        text = clock.state(event) if event.stage not in BEFORE else STAGES[event.stage]
        if changed or now - updated >= CELL_INTERVAL:
            updated = now
            value = f' value="{event.done}" max="{event.total}"' if event.stage == "run" else ""
            handle.update(_line(text, f"<progress{value}></progress> "), raw=True)

    try:
        yield show
    finally:
        if last is not None:
            count = f"{last.done:,} of {last.total:,} runs, {last.failed:,} failed"
            handle.update(_line(f"{count}, {duration(time.monotonic() - started)}", ""), raw=True)


def _line(text: str, before: str) -> dict[str, str]:
    """The same line as text and as HTML."""
    from html import escape

    return {"text/plain": text, "text/html": before + escape(text)}


class Clock:
    """Since when there is the stage that runs are in, and so how fast they are."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self.stage = ""
        self.started = clock()

    def state(self, event: Event) -> str:
        """The stage and the runs done, with their rate and what is left."""
        now = self.clock()
        if event.stage != self.stage:
            self.stage, self.started = event.stage, now
        text = f"{STAGES.get(event.stage, event.stage)}: {event.done}/{event.total} runs, {event.failed} failed"
        elapsed = now - self.started
        if event.stage == "run" and event.done and elapsed > 0:
            rate = event.done / elapsed
            left = duration((event.total - event.done) / rate)
            text += f", {rate:,.{0 if rate >= 10 else 2}f} runs/s, {left} left"
        return text


class ProgressLines:
    """Progress as lines of text: at each new stage, every LINE_INTERVAL, and after SILENCE."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self.stream, self.clock = stream, clock
        self.event: Event | None = None
        self.since = Clock(clock)
        self.printed, self.told = clock(), False
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._watch = threading.Thread(target=self._break_silence, daemon=True)

    def __enter__(self) -> "ProgressLines":
        self._watch.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._watch.join()

    def __call__(self, event: Event) -> None:
        with self._lock:
            before, self.event = self.event, event
            changed, text = event.stage != self.since.stage, self.since.state(event)
            if changed and event.stage != "prepare":
                self._print(STAGES.get(event.stage, event.stage))
            elif self.clock() - self.printed >= LINE_INTERVAL or (_is_over(event) and not _is_over(before)):
                self._print(text)

    def _break_silence(self) -> None:
        while not self._over.wait(1.0):
            with self._lock:
                event, waited = self.event, self.clock() - self.printed
                if event is not None and event.stage == "prepare" and PATIENCE <= waited < SILENCE and not self.told:
                    self.told = True
                    self._print(STAGES["prepare"])
                elif event is not None and waited >= SILENCE:
                    self._print(self.since.state(event))

    def _print(self, text: str) -> None:
        self.printed = self.clock()
        with suppress(OSError, ValueError):  # whoever listened has gone: that stops no run
            print(text, file=self.stream, flush=True)


def _is_over(event: Event | None) -> bool:
    return event is not None and event.done == event.total


def duration(seconds: float) -> str:
    """A time for people: 8 s, 3 min 20 s, 2 h 5 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
