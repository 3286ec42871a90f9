"""How the runs ended, and where: counts, failures with their remedies, quantiles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.analysis.outcomes import Counts, counts
from lienumba.analysis.summary import Quantiles, Summary, summarise
from lienumba.analysis.summary_rows import (
    QuantileRows,
    change_table,
    happened_headings,
    happened_times,
    largest,
    not_unique,
    quantile_rows,
)
from lienumba.present.html.chart import Section, section
from lienumba.present.html.markup import (
    Markup,
    element,
    facts,
    folded,
    number,
    sentence,
    table,
    text_table,
    typeset,
)
from lienumba.words import listed

MOST_ROWS = 300  # of the folded table


def summary(ds: xr.Dataset, name: str) -> Section:
    """The section; name: of the file of the dataset."""
    found, ran = summarise(ds), counts(ds)
    parts = [facts(_counts(found, ran)), *_ends(ran, name)]
    parts += _quantiles(f"At t = {found.final_time:g} s", quantile_rows(found.final, found.finished))
    rows = quantile_rows(found.ended, found.spread - found.finished)
    parts += [*_quantiles("Last states of runs that an event ended", rows), *_events(found)]
    parts += _quantiles("Of each run", quantile_rows(found.kept, found.spread))
    parts += (
        element("p", sentence(text))
        for text in (
            not_unique(found),
            found.unknown,
            found.stopped,
            found.short_steps,
            found.unstable,
            found.weights,
        )
        if text
    )
    return section("summary", "Summary", *parts)


def _counts(found: Summary, ran: Counts) -> Iterator[tuple[str, str]]:
    failed, nominal = ran.runs - ran.good, ran.nominal is not None and not ran.nominal.good
    yield "good runs", f"{ran.good:,}" + ("" if nominal else ran.beside)
    if failed or nominal or ran.runs > 1:
        yield "failed", f"{failed:,}" + (ran.beside if nominal else "")
    for name, value, unit in largest(found):
        yield f"largest {name}", f"{number(value, 2)} {unit}".strip()


def _ends(ran: Counts, name: str) -> Iterator[Markup]:
    """How runs ended that did not reach the end, what it means, and what to do."""
    if not ran.early:
        return
    rows = (
        ("nominal" if x is ran.nominal else f"{x.count:,}", x.status.replace("_", " "), x.kind.sentence, x.which)
        for x in ran.early
    )
    headings = ("runs", "how they ended", "what it means, and a remedy", "which, and when")
    yield element("h3", "Runs that ended early")
    yield table(headings, rows, 4, prose=True)
    label = ran.early[0].labels[0]
    yield element("p", "Look at one, with its whole course: ", element("code", f"lienumba replay {name} --run {label}"))


def _quantiles(heading: str, found: QuantileRows) -> Iterator[Markup]:
    """Quantiles over so many runs; those of other bodies folded."""
    if not found.first:
        return
    yield element("h3", heading + (f", over {found.runs:,} runs" if found.runs > 1 else ""))
    yield _table(found, found.first)
    if found.rest:
        others = listed(f"{number} {kind}" for kind, number in found.others.items())
        more = f", the first {MOST_ROWS:,} of {len(found.rest):,} rows" if len(found.rest) > MOST_ROWS else ""
        yield folded(f"The other {others}{more}", _table(found, found.rest[:MOST_ROWS]))


def _events(found: Summary) -> Iterator[Markup]:
    """When events first happened."""
    if found.events:
        rows = [[x.name, f"{x.runs:,}", *map(typeset, happened_times(found, x)), "s"] for x in found.events]
        yield element("h3", "Events, the first of each run")
        yield table(happened_headings(found), rows, 1)


def changes(ds: xr.Dataset) -> Iterator[Markup]:
    """What changed in the mechanism, and when."""
    found = summarise(ds)
    if found.changes_told:
        yield element("p", sentence(found.changes_told), class_="quiet")
    if found.changes:
        yield text_table(change_table(found))


def _table(found: QuantileRows, rows: Sequence[Quantiles]) -> Markup:
    words = ["quantity", *(["of"] if any(row.body for row in rows) else []), "axis"]
    lines = [
        [
            row.quantity, *([row.body] if "of" in words else []), row.axis, *map(typeset, found.numbers(row)),
            unit_label(row.units),
        ]
        for row in rows
    ]  # fmt: skip
    return table([*words, *found.headings, "unit"], lines, len(words))
