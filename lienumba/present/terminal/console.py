"""What a person sees while lienumba works: errors, warnings, progress and the summary."""

import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from lienumba.engine.progress import ProgressLines, bar, silent
from lienumba.errors import ClusterError, ScenarioError
from lienumba.words import readable, to_terminal

if TYPE_CHECKING:
    from rich.console import Console

    from lienumba.analysis.summary import Summary
    from lienumba.engine.replay import Replay

SOME_FAILED, BAD_INPUT, NOT_MET, INTERRUPTED = 1, 2, 4, 130


def say(text: object, err: bool = False) -> None:
    """Print a text, of which a terminal obeys nothing; if it is a result, a WriteError where it cannot be."""
    try:
        typer.echo(readable(str(text)), err=err)
    except BrokenPipeError:  # whoever listened has heard enough
        _speak_to_nobody()
    except (OSError, ValueError) as error:
        from lienumba.store.outputs import WriteError

        _speak_to_nobody()
        if not err:
            why = getattr(error, "strerror", None) or error
            raise WriteError(f"what is to be printed cannot be ({why}); make room, or print it elsewhere") from None


def _speak_to_nobody(stream: str = "stdout") -> None:
    with suppress(Exception):
        setattr(sys, stream, open(os.devnull, "w"))  # noqa: SIM115  else Python complains when it flushes at exit


def hush() -> None:
    """Streams that do not take what they still hold, as the program ends, change no exit code: what had to be said was,
    or has told why it could not be."""
    for stream in ("stdout", "stderr"):
        try:
            getattr(sys, stream).flush()
        except (OSError, ValueError, AttributeError):
            _speak_to_nobody(stream)


@contextmanager
def exit_codes() -> Iterator[None]:
    """Turn errors that a user can mend into messages and exit codes; others stay visible as they are. Warnings are
    sentences, and a request to terminate is an interrupt."""
    warnings.showwarning = lambda message, *_: print_warnings([message])
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        with to_terminal():
            yield
    except ScenarioError as error:
        for line in str(error).splitlines():
            say(f"error: {line}", err=True)
        raise typer.Exit(BAD_INPUT) from None
    except ClusterError as error:
        say(f"error: {error}", err=True)
        raise typer.Exit(SOME_FAILED) from None
    except OSError as error:
        from lienumba.store.outputs import WriteError

        told = str(error) if isinstance(error, WriteError) else _of_system(error)
        say(f"error: {told}", err=True)
        raise typer.Exit(SOME_FAILED) from None
    except MemoryError as error:
        remedy = "close other programs, give fewer workers (-j 1), or store fewer times or variables"
        say(f"error: there is not enough memory ({error}); {remedy}", err=True)
        raise typer.Exit(SOME_FAILED) from None
    except KeyboardInterrupt as error:
        say(str(error) or "interrupted: no dataset was written", err=True)
        raise typer.Exit(INTERRUPTED) from None


def _of_system(error: OSError) -> str:
    """What the operating system refuses."""
    files = " and ".join(str(name) for name in (error.filename, error.filename2) if name is not None)
    why = error.strerror or str(error) or type(error).__name__
    return f"{files}: {why}; see to it, and try again" if files else f"the system says: {why}; see to it, and try again"


def print_warnings(warnings: Iterable[object]) -> None:
    for warning in warnings:
        say(f"warning: {warning}", err=True)


@contextmanager
def progress(quiet: bool) -> Iterator[Callable[[Any], None]]:
    """A function that shows the runner's events: a bar on a terminal, else lines; nothing when quiet."""
    if quiet or sys.stderr is None:
        yield silent
    else:
        with bar() if sys.stderr.isatty() else ProgressLines(sys.stderr) as show:
            yield show


@contextmanager
def unheard() -> Iterator[None]:
    """Nobody may be listening (a closed or full stream): that stops no run and changes no exit code."""
    try:
        yield
    except (OSError, ValueError, AttributeError):
        _speak_to_nobody()


@contextmanager
def drawing(quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """A function that shows how many frames of how many are drawn: a bar on a terminal, else one line."""
    if quiet or sys.stderr is None:
        yield lambda done, total: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True)) as bar:
            task = bar.add_task("drawing", total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)
    else:
        yield lambda done, total: say(f"drawing {total:,} frames", err=True) if done == 1 else None


def wide_output(width: int) -> "Console":
    """Where tables are printed; width: if that is no terminal."""
    from rich.console import Console

    class Output(Console):
        """Obeys nothing that a dataset says, and does not end the program where nobody listens."""

        def print(self, *objects: Any, **more: Any) -> None:
            super().print(*(readable(x) if isinstance(x, str) else x for x in objects), **more)

        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    return Output(width=None if sys.stdout.isatty() else width, highlight=False, soft_wrap=True)


def print_replay(replay: "Replay", why: str, target: Path) -> None:
    """How the run ended, and whether it is the one of the file."""
    from lienumba.batch.statuses import GOOD, STATUSES

    ds = replay.dataset
    status = next(status for status in STATUSES if status.code == ds["status"].item())
    fate = f"run {ds['run'].item()}: {status.name} at {ds['end_time'].item():g} s"
    fate += "" if status.code in GOOD else f": {status.sentence}"
    for line in (why, fate, replay.sentence if replay.same else ""):
        if line:
            say(line)
    say(f"written to {target}, with {ds.sizes['time']:,} stored times")


def print_summary(summary: "Summary", target: Path) -> None:
    """How the runs ended, where, and how well the constraints held."""
    from lienumba.analysis.summary_text import WIDTH, parts

    output = wide_output(WIDTH)
    for part in parts(summary, str(target)):
        output.print(part if isinstance(part, str) else part[1].on_terminal(part[0]), markup=False)
    output.print(f"written to {target}", markup=False)
