"""How the runs ended, and where: cards, failures with their remedies, quantiles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from lienumba.analysis.labels import unit_label
from lienumba.analysis.summary import Outcome, Quantiles, Summary, summarise
from lienumba.batch.statuses import STATUSES
from lienumba.present.html.chart import Section, section
from lienumba.present.html.markup import Markup, element, folded, join, number, sentence, table
from lienumba.present.html.outcomes import Counts, counts, is_good

if TYPE_CHECKING:
    import xarray as xr

MOST_BODIES = 3  # whose numbers are seen at once
MOST_ROWS = 300  # of the folded table


def summary(ds: xr.Dataset, name: str) -> Section:
    """The section; name: of the file of the dataset."""
    found = summarise(ds)
    ran = counts(ds)
    parts = [element("div", *_cards(found, ran), class_="cards"), *_ends(ran, name)]
    parts += _quantiles(f"At t = {found.final_time:g} s", found.final, found.finished)
    parts += _quantiles("Of each run", found.kept, found.spread)
    if found.not_unique:
        parts.append(element("p", f"Reactions not unique: {found.not_unique}; those of least norm are stored."))
    if found.stopped:
        parts.append(element("p", sentence(found.stopped)))
    return section("summary", "Summary", *parts)


def _cards(found: Summary, ran: Counts) -> Iterator[Markup]:
    failed, nominal = ran.runs - ran.good, ran.nominal is not None and not is_good(ran.nominal)
    yield _card(f"{ran.good:,}", ("good run" if ran.good == 1 else "good runs") + ("" if nominal else ran.beside))
    if failed or nominal or ran.runs > 1:
        yield _card(f"{failed:,}", "failed" + (ran.beside if nominal else ""), bad=failed > 0 or nominal)
    for name, value, unit in (
        ("largest position violation", found.max_position_violation, "m"),
        ("largest velocity violation", found.max_velocity_violation, "m/s"),
        ("largest relative energy drift", found.max_relative_energy_drift, ""),
    ):
        if value is not None:
            yield _card(f"{number(value, 2)} {unit}".strip(), name)


def _card(value: str, name: str, bad: bool = False) -> Markup:
    return element("div", element("b", value), element("span", name), class_="card bad" if bad else "card")


def _ends(ran: Counts, name: str) -> Iterator[Markup]:
    """How runs ended that did not reach the end, what it means, and what to do."""
    known = {status.name: status for status in STATUSES}
    if not ran.early:
        return
    rows = (
        ("nominal" if x is ran.nominal else f"{x.count:,}", x.status.replace("_", " "), known[x.status].sentence,
         _which(x))
        for x in ran.early
    )  # fmt: skip
    headings = ("runs", "how they ended", "what it means, and a remedy", "which, and when")
    yield element("h3", "Runs that ended early")
    yield table(headings, rows, 4, prose=True)
    label = ran.early[0].labels[0]
    yield element("p", "Look at one, with its whole course: ", element("code", f"lienumba replay {name} --run {label}"))


def _which(outcome: Outcome) -> str:
    runs = ", ".join(
        f"{label} (at {end:g} s)" for label, end in zip_longest(outcome.labels, outcome.end_times, fillvalue=0.0)
    )
    return runs + (", ..." if outcome.count > len(outcome.labels) else "")


def _quantiles(heading: str, rows: Sequence[Quantiles], runs: int) -> Iterator[Markup]:
    """Quantiles over so many runs; of many bodies the last, and the others folded."""
    if not rows:
        return
    bodies = list(dict.fromkeys(row.body for row in rows if row.body))
    shown = bodies if len(bodies) <= MOST_BODIES else bodies[-1:]
    first = [row for row in rows if not row.body or row.body in shown]
    rest = [row for row in rows if row not in first]
    spread = f", over {runs:,} runs" if runs > 1 else ""
    yield element("h3", heading + spread)
    yield _table(first, runs)
    if rest:
        more = f", the first {MOST_ROWS:,} of {len(rest):,} rows" if len(rest) > MOST_ROWS else ""
        yield folded(f"The other {len(bodies) - len(shown)} bodies{more}", _table(rest[:MOST_ROWS], runs))


def _table(rows: Sequence[Quantiles], runs: int) -> Markup:
    """On a narrow screen the first column holds all words."""
    words = ["quantity", *(["of"] if any(row.body for row in rows) else []), "axis"]
    numbers = ["5 %", "median", "95 %"] if runs > 1 else ["value"]
    lines = []
    for row in rows:
        values = (row.low, row.median, row.high) if runs > 1 else (row.median,)
        of = [row.body] if "of" in words else []
        unit = unit_label(row.units)
        also = " ".join(filter(None, [*of, row.axis, f"({unit})" if unit else ""]))
        first = join([row.quantity, element("span", f" {also}", class_="also")])
        lines.append([first, *of, row.axis, *(number(x) for x in values), unit])
    return element("div", table([*words, *numbers, "unit"], lines, len(words)), class_="quantiles")
