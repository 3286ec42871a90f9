"""The rows of a summary, which a terminal and a page draw."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lienumba.analysis.text_table import NUMBER, WORD, TextTable, number_text

if TYPE_CHECKING:
    from lienumba.analysis.summary import Happened, Quantiles, Summary

MOST = 3  # bodies, or others of one kind, whose numbers are seen at once
SEVERAL = {"body": "bodies", "coordinate": "coordinates", "event": "events"}  # of a kind, in words


@dataclass(frozen=True)
class QuantileRows:
    """Quantiles over so many runs; first: those of the system and of few bodies, of many bodies of the last, and so of
    coordinates and events; others: how many there are of each kind, in words."""

    runs: int
    first: Sequence[Quantiles]
    others: Mapping[str, int]

    @property
    def headings(self) -> list[str]:
        """Of the numbers; one run has no quantiles."""
        return ["5 %", "median", "95 %"] if self.runs > 1 else ["value"]

    def numbers(self, row: Quantiles) -> list[str]:
        """Those below the headings."""
        found = [row.low, row.median, row.high] if self.runs > 1 else [row.median]
        return [number_text(x, ".6g", row.scale) for x in found]


def quantile_rows(rows: Sequence[Quantiles], runs: int, every: bool = False) -> QuantileRows:
    """The rows of quantiles over so many runs; every: those of all bodies first, however many."""
    labels: dict[str, list[str]] = {}
    for kind, label in dict.fromkeys((row.kind, row.body) for row in rows if row.body):
        labels.setdefault(kind, []).append(label)
    hidden = {kind: own[:-1] for kind, own in labels.items() if len(own) > MOST and not every}
    first = [row for row in rows if row.body not in hidden.get(row.kind, ())]
    return QuantileRows(runs, first, {SEVERAL.get(kind, "labels"): len(own) for kind, own in hidden.items()})


def happened_headings(summary: Summary) -> list[str]:
    """Of the table of events."""
    return ["event", "runs", *(["5 %", "median", "95 %"] if summary.spread > 1 else ["time"]), "unit"]


def happened_times(summary: Summary, event: Happened) -> list[str]:
    """Those below its headings."""
    found = [event.low, event.median, event.high] if summary.spread > 1 else [event.median]
    return [number_text(t, ".6g") for t in found]


def change_table(summary: Summary) -> TextTable:
    """What changed, how often, when, and by which impulses."""
    impulse, energy = (
        max((x for x in found if x == x), default=0.0)
        for found in ([x.largest_impulse for x in summary.changes], [abs(x.energy) for x in summary.changes])
    )
    headings = ["changed", "how", "runs", "times", "t: 5 %", "median", "95 %", "impulse", "largest", "energy lost"]
    rows = [
        [
            x.what, x.kind.name, f"{x.runs:,}", f"{x.count:,}",
            *(number_text(t, ".6g") for t in (x.low, x.median, x.high)),
            *(number_text(size, ".4g", impulse) for size in (x.impulse, x.largest_impulse)),
            number_text(x.energy, ".4g", energy),
        ]
        for x in summary.changes
    ]  # fmt: skip
    return TextTable(headings, [WORD, WORD, *[NUMBER] * 8], rows)


def largest(summary: Summary) -> Iterator[tuple[str, float, str]]:
    """The largest errors of all runs, with their units."""
    for name, value, unit in (
        ("position violation", summary.max_position_violation, "m"),
        ("velocity violation", summary.max_velocity_violation, "m/s"),
        ("relative energy drift", summary.max_relative_energy_drift, ""),
    ):
        if value is not None:
            yield name, value, unit


def remarks(summary: Summary, warnings: bool = True) -> list[str]:
    """Sentences about the whole sweep: warnings first, unless they stand elsewhere, then what is special about it."""
    reactions = f"reactions not unique: {summary.not_unique}; those of least norm are stored"
    found = (
        *(f"warning: {sentence}" for sentence in summary.warnings if warnings),
        reactions if summary.not_unique else "",
        summary.unknown,
        summary.stopped,
        summary.short_steps,
        summary.unstable,
        summary.weights,
    )
    return [sentence for sentence in found if sentence]
