"""A summary as people read it, on a terminal and in a notebook."""

from __future__ import annotations

import io
from collections.abc import Iterator
from itertools import repeat
from typing import TYPE_CHECKING

from lienumba.analysis.labels import unit_label
from lienumba.analysis.summary_rows import (
    QuantileRows,
    change_table,
    happened_headings,
    happened_times,
    largest,
    quantile_rows,
    remarks,
)
from lienumba.analysis.text_table import NUMBER, UNIT, WORD, TextTable
from lienumba.words import listed, plural

if TYPE_CHECKING:
    from lienumba.analysis.summary import Summary

WIDTH = 110
Titled = tuple[str, TextTable]  # a table below its title


def text(summary: Summary) -> str:
    """All of it as plain text."""
    from rich.console import Console

    stream = io.StringIO()
    output = Console(file=stream, width=WIDTH, highlight=False, soft_wrap=True, color_system=None)
    for part in parts(summary):
        output.print(part if isinstance(part, str) else part[1].on_terminal(part[0]), markup=False)
    return stream.getvalue().rstrip()


def parts(summary: Summary, file: str = "") -> Iterator[str | Titled]:
    """Sentences and tables; file: where the dataset is, if runs of it can be replayed."""
    failed = summary.runs - summary.good
    title = f"{summary.title}: " if summary.title else ""
    yield f"{title}{summary.good:,} of {summary.runs:,} runs good, {failed:,} failed"
    for x in summary.outcomes:
        if x.early:
            yield f"  {x.count:,} {x.status}: {x.kind.sentence}; runs {x.which}"
    first = next((label for x in summary.outcomes if not x.good for label in x.labels), None)
    if first is not None and file:
        yield f"  look at one: lienumba replay {file} --run {first}"
    yield from tables(summary)
    errors = ", ".join(f"{name} {value:.1e} {unit}".rstrip() for name, value, unit in largest(summary))
    yield from filter(None, [f"largest {errors}" if errors else "", *remarks(summary)])


def tables(summary: Summary) -> Iterator[str | Titled]:
    """Quantiles, events and changes, each with its title."""
    if summary.final:
        early = summary.finished < summary.spread
        which = f", over {plural(summary.finished, 'run that', 'runs that')} reached it" if early else ""
        yield _quantiles(
            f"at t = {summary.final_time:g} s{which}", quantile_rows(summary.final, summary.finished, summary.shown)
        )
    if summary.ended:
        ended = summary.spread - summary.finished
        yield _quantiles(f"where an event ended {plural(ended, 'run', 'runs')}", quantile_rows(summary.ended, ended))
    if summary.events:
        yield _events(summary)
    if summary.changes:
        yield summary.changes_told, change_table(summary)
    elif summary.changes_told:
        yield summary.changes_told
    if summary.kept:
        yield _quantiles("of each run", quantile_rows(summary.kept, summary.spread, summary.shown))


def _events(summary: Summary) -> Titled:
    """When events first happened; of one run there is one time."""
    headings = happened_headings(summary)
    rows = [[x.name, f"{x.runs:,}", *happened_times(summary, x), "s"] for x in summary.events]
    kinds = [WORD, *repeat(NUMBER, len(headings) - 2), UNIT]
    return "events, the first of each run", TextTable(headings, kinds, rows)


def _quantiles(what: str, found: QuantileRows) -> Titled:
    several = [f"of {number + 1} {kind}" for kind, number in found.others.items()]
    which = f", the last {listed(several)}" if several else ""
    rows = [[row.quantity, row.body, row.axis, *found.numbers(row), unit_label(row.units)] for row in found.first]
    headings = ["quantity", "of", "axis", *found.headings, "unit"]
    kinds = [*repeat(WORD, 3), *repeat(NUMBER, len(found.headings)), UNIT]
    return what + which, TextTable(headings, kinds, rows)
