"""What a person sees while lienumba works: errors, warnings, progress and the summary."""

import itertools
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from lienumba.errors import ClusterError, ScenarioError
from lienumba.progress import ProgressLines, bar, silent

if TYPE_CHECKING:
    from rich.table import Table

    from lienumba.analysis.summary import Outcome, Quantiles, Summary
    from lienumba.running.replay import Replay

SOME_FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130
MOST_BODIES = 3  # whose final state the summary shows


@contextmanager
def exit_codes() -> Iterator[None]:
    """Turn errors that a user can mend into messages and exit codes; others stay visible as they are. Warnings are
    sentences, and a request to terminate is an interrupt."""
    warnings.showwarning = lambda message, *_: print_warnings([str(message)])
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        yield
    except ScenarioError as error:
        for line in str(error).splitlines():
            typer.echo(f"error: {line}", err=True)
        raise typer.Exit(BAD_INPUT) from None
    except ClusterError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(SOME_FAILED) from None
    except OSError as error:
        from lienumba.store.files import WriteError

        if not isinstance(error, WriteError):
            raise
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(SOME_FAILED) from None
    except MemoryError as error:
        remedy = "close other programs, give fewer workers (-j 1), or store fewer times or variables"
        typer.echo(f"error: there is not enough memory ({error}); {remedy}", err=True)
        raise typer.Exit(SOME_FAILED) from None
    except KeyboardInterrupt as error:
        typer.echo(str(error) or "interrupted: no dataset was written", err=True)
        raise typer.Exit(INTERRUPTED) from None


def print_warnings(warnings: list[str]) -> None:
    for warning in warnings:
        typer.echo(f"warning: {warning}", err=True)


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
        with suppress(Exception):
            sys.stdout = open(os.devnull, "w")  # noqa: SIM115  else Python complains when it flushes at exit


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
        yield lambda done, total: typer.echo(f"drawing {total:,} frames", err=True) if done == 1 else None


def print_replay(replay: "Replay", why: str, target: Path) -> None:
    """How the run ended, and whether it is the one of the file."""
    from lienumba.batch.statuses import GOOD, STATUSES

    ds = replay.dataset
    status = next(status for status in STATUSES if status.code == ds["status"].item())
    fate = f"run {ds['run'].item()}: {status.name} at {ds['end_time'].item():g} s"
    fate += "" if status.code in GOOD else f": {status.sentence}"
    for line in (why, fate, replay.sentence if replay.same else ""):
        if line:
            typer.echo(line)
    typer.echo(f"written to {target}, with {ds.sizes['time']:,} stored times")


def print_summary(summary: "Summary", target: Path) -> None:
    """How the runs ended, where, and how well the constraints held."""
    from rich.console import Console

    output = Console(width=None if sys.stdout.isatty() else 110, highlight=False, soft_wrap=True)
    failed = summary.runs - summary.good
    title = f"{summary.title}: " if summary.title else ""
    output.print(f"{title}{summary.good:,} of {summary.runs:,} runs good, {failed:,} failed", markup=False)
    for line in _outcomes(summary):
        output.print(f"  {line}", markup=False)
    first = next((label for outcome in _failed(summary) for label in outcome.labels), None)
    if first is not None:
        output.print(f"  look at one: lienumba replay {target} --run {first}", markup=False)
    if summary.final:
        output.print(_quantiles(f"at t = {summary.final_time:g} s", summary.final, summary.spread))
    if summary.kept:
        output.print(_quantiles("of each run", summary.kept, summary.spread))
    violations = (
        ("position violation", summary.max_position_violation, " m"),
        ("velocity violation", summary.max_velocity_violation, " m/s"),
        ("relative energy drift", summary.max_relative_energy_drift, ""),
    )
    largest = ", ".join(f"{name} {value:.1e}{unit}" for name, value, unit in violations if value is not None)
    if largest:
        output.print(f"largest {largest}", markup=False)
    if summary.not_unique:
        output.print(f"reactions not unique: {summary.not_unique}; those of least norm are stored", markup=False)
    if summary.stopped:
        output.print(summary.stopped, markup=False)
    output.print(f"written to {target}", markup=False)


def _failed(summary: "Summary") -> "list[Outcome]":
    """The ways in which runs failed."""
    from lienumba.batch.statuses import GOOD, STATUSES

    good = [status.name for status in STATUSES if status.code in GOOD]
    return [outcome for outcome in summary.outcomes if outcome.status not in good]


def _outcomes(summary: "Summary") -> Iterator[str]:
    from lienumba.batch.statuses import STATUSES

    sentences = {status.name: status.sentence for status in STATUSES}
    for outcome in summary.outcomes:
        if outcome.status != STATUSES[0].name:
            more = ", ..." if outcome.count > len(outcome.labels) else ""
            runs = ", ".join(
                f"{label} (at {end:g} s)"
                for label, end in itertools.zip_longest(outcome.labels, outcome.end_times, fillvalue=0.0)
            )
            yield f"{outcome.count:,} {outcome.status}: {sentences[outcome.status]}; runs {runs}{more}"


def _quantiles(what: str, rows: "Sequence[Quantiles]", runs: int) -> "Table":
    """Quantiles over so many runs; of many bodies only the last."""
    from rich import box
    from rich.table import Table

    bodies = list(dict.fromkeys(row.body for row in rows if row.body))
    shown = bodies if len(bodies) <= MOST_BODIES else bodies[-1:]
    which = f", the last of {len(bodies)} bodies" if len(shown) < len(bodies) else ""
    table = Table(title=what + which, box=box.SIMPLE_HEAD, title_justify="left")
    for heading in ("quantity", "body", "axis"):
        table.add_column(heading)
    for heading in ("5 %", "median", "95 %") if runs > 1 else ("value",):
        table.add_column(heading, justify="right")
    table.add_column("unit")
    for row in rows:
        if not row.body or row.body in shown:
            values = (row.low, row.median, row.high) if runs > 1 else (row.median,)
            table.add_row(row.quantity, row.body, row.axis, *(f"{value:.6g}" for value in values), row.units)
    return table
