"""A summary as people read it, on a terminal and in a notebook."""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from lienumba.batch.statuses import GOOD, STATUSES
from lienumba.words import plural

if TYPE_CHECKING:
    from rich.table import Table

    from lienumba.analysis.summary import Outcome, Quantiles, Summary

WIDTH = 110
MOST_BODIES = 3  # whose final state is told


def text(summary: Summary) -> str:
    """All of it as plain text."""
    from rich.console import Console

    stream = io.StringIO()
    output = Console(file=stream, width=WIDTH, highlight=False, soft_wrap=True, color_system=None)
    for part in parts(summary):
        output.print(part, markup=False)
    return stream.getvalue().rstrip()


def parts(summary: Summary, file: str = "") -> Iterator[str | Table]:
    """Sentences and tables; file: where the dataset is, if runs of it can be replayed."""
    failed = summary.runs - summary.good
    title = f"{summary.title}: " if summary.title else ""
    yield f"{title}{summary.good:,} of {summary.runs:,} runs good, {failed:,} failed"
    yield from (f"  {line}" for line in _outcomes(summary))
    first = next((label for outcome in _failed(summary) for label in outcome.labels), None)
    if first is not None and file:
        yield f"  look at one: lienumba replay {file} --run {first}"
    if summary.final:
        early = summary.finished < summary.spread
        which = f", over {plural(summary.finished, 'run that', 'runs that')} reached it" if early else ""
        yield _quantiles(f"at t = {summary.final_time:g} s{which}", summary.final, summary.finished)
    if summary.kept:
        yield _quantiles("of each run", summary.kept, summary.spread)
    violations = (
        ("position violation", summary.max_position_violation, " m"),
        ("velocity violation", summary.max_velocity_violation, " m/s"),
        ("relative energy drift", summary.max_relative_energy_drift, ""),
    )
    largest = ", ".join(f"{name} {value:.1e}{unit}" for name, value, unit in violations if value is not None)
    if largest:
        yield f"largest {largest}"
    if summary.not_unique:
        yield f"reactions not unique: {summary.not_unique}; those of least norm are stored"
    if summary.stopped:
        yield summary.stopped


def _failed(summary: Summary) -> list[Outcome]:
    """The ways in which runs failed."""
    good = [status.name for status in STATUSES if status.code in GOOD]
    return [outcome for outcome in summary.outcomes if outcome.status not in good]


def _outcomes(summary: Summary) -> Iterator[str]:
    sentences = {status.name: status.sentence for status in STATUSES}
    for outcome in summary.outcomes:
        if outcome.status != STATUSES[0].name:
            more = ", ..." if outcome.count > len(outcome.labels) else ""
            runs = ", ".join(
                f"{label} (at {end:g} s)"
                for label, end in itertools.zip_longest(outcome.labels, outcome.end_times, fillvalue=0.0)
            )
            yield f"{outcome.count:,} {outcome.status}: {sentences[outcome.status]}; runs {runs}{more}"


def _quantiles(what: str, rows: Sequence[Quantiles], runs: int) -> Table:
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
