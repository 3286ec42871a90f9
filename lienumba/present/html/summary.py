"""How the runs ended, and where: counts, failures with their remedies, quantiles."""

from __future__ import annotations

from collections.abc import Iterator

import xarray as xr

from lienumba.analysis.outcomes import Counts, counts
from lienumba.analysis.summary import Summary, summarise
from lienumba.analysis.summary_rows import change_table, largest, remarks
from lienumba.analysis.summary_text import tables
from lienumba.present.html.chart import Section, section
from lienumba.present.html.markup import Markup, element, facts, number, sentence, table, text_table


def summary(ds: xr.Dataset, name: str) -> Section:
    """The section; name: of the file of the dataset."""
    found, ran = summarise(ds), counts(ds)
    parts = [facts(_counts(found, ran)), *_ends(ran, name)]
    for part in tables(found):
        if isinstance(part, str) or part[0] == found.changes_told:
            continue  # changes have a section of their own
        parts += [element("h3", part[0][:1].upper() + part[0][1:]), text_table(part[1])]
    parts += (element("p", sentence(text)) for text in remarks(found, warnings=False))
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


def changes(ds: xr.Dataset) -> Iterator[Markup]:
    """What changed in the mechanism, and when."""
    found = summarise(ds)
    if found.changes_told:
        yield element("p", sentence(found.changes_told), class_="quiet")
    if found.changes:
        yield text_table(change_table(found))
