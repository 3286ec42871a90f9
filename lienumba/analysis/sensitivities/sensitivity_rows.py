"""What `sensitivity` found as rows: of each output its inputs, with their numbers and these as texts, which a terminal
and a page draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan

import xarray as xr

from lienumba.analysis.labels import named, time_label
from lienumba.analysis.sensitivities.sensitivity import CHOSEN, OF_BOTH
from lienumba.analysis.text_table import NONE, TextTable, number_text, short_text
from lienumba.words import plural

TORNADO = ("rank correlation", "10 %", "90 %", "mean below", "mean above", "change")
EXPLAINED = "explains"


@dataclass(frozen=True)
class InputRow:
    """An input of one output, with its unit. numbers: by the names of the variables of `sensitivity`; NaN: none."""

    name: str
    units: str
    numbers: Mapping[str, float]

    @property
    def strength(self) -> float:
        """By which inputs are put in order: the rank correlation, or the root of the first index, which of a straight
        effect is its correlation, and sees crooked ones; NaN without either."""
        sizes = abs(self.numbers["rank_correlation"]), max(self.numbers["first_order"], 0.0) ** 0.5
        return max((x for x in sizes if x == x), default=nan)

    @property
    def explained(self) -> str:
        """The text below EXPLAINED."""
        index, high = (100.0 * self.numbers[f"first_order{end}"] for end in ("", "_high"))
        return f"{round(index) + 0} ± {short_text(high - index, 2)} %" if index == index else NONE

    @property
    def tornado(self) -> list[str]:
        """The texts of a row below the headings of TORNADO."""
        of = self.numbers
        r, r_low, r_high = (of[f"rank_correlation{end}"] for end in ("", "_low", "_high"))
        half = 0.5 * (of["change_high"] - of["change_low"])
        spread = f" ± {short_text(half, 2)}" if half == half else ""
        ends = [number_text(of[name], ".4g") for name in ("input_low", "input_high", "low", "high")]
        change = f"{short_text(of['change'], 3)}{spread}" if of["low"] == of["low"] else NONE
        correlation = f"{number_text(r, '.2f')} ± {0.5 * (r_high - r_low):.2f}" if r == r else NONE
        return [correlation, *ends, change]

    @property
    def indices(self) -> list[str]:
        """First and total Sobol' index."""
        names = ("first_order", "total_order")
        ends = [[self.numbers[f"{x}{end}"] for end in ("_low", "", "_high")] for x in names]
        farther = [(x, max(x - low, high - x)) for low, x, high in ends]
        return [f"{number_text(x, '.3f')} ± {short_text(end, 2)}" for x, end in farther]

    @property
    def effects(self) -> list[str]:
        """Mean size, mean and deviation of elementary effects."""
        return [self._with_half(name) for name in ("mu_star", "mu", "sigma")]

    def _with_half(self, name: str) -> str:
        low, x, high = (self.numbers[key] for key in (f"{name}_low", name, f"{name}_high"))
        if x != x:
            return NONE
        return f"{short_text(x, 4)}{f' ± {short_text(0.5 * (high - low), 2)}' if high == high else ''}"


@dataclass(frozen=True)
class OutputRows:
    """An output, with its unit, at a time (s; NaN: each run has it once): mean and deviation over the runs that count,
    how many complete rows there are of how many for Sobol' indices, and its inputs in the order of the sweep."""

    name: str
    units: str
    time: float
    runs: int
    mean: float
    deviation: float
    rows: int
    every_row: int
    inputs: Sequence[InputRow]

    @property
    def headline(self) -> str:
        spread = f"mean {self.mean:.6g}, standard deviation {self.deviation:.3g}"
        when = " ".join(filter(None, [named(self.name, self.units), time_label(self.time)]))
        return f"{when}, {plural(self.runs, 'run', 'runs')}: {spread}"

    @property
    def sobol_headline(self) -> str:
        """That of Sobol' indices; empty if it has none."""
        first, total = ([row.numbers[name] for row in self.inputs] for name in ("first_order", "total_order"))
        if all(x != x for x in total):
            return ""
        of = f"Sobol' indices of {self.name}, {self.rows:,} of {self.every_row:,} rows"
        return f"{of}; the first add up to {sum(x for x in first if x == x):.2f}"

    def tornado(self, most: int) -> tuple[TextTable, str]:
        """The strongest inputs, and a remark if there are more."""
        first, more = self._first([(row.strength, row) for row in self.inputs], most)
        explained = not self.sobol_headline and any(x.explained != NONE for x in first)
        rows = [
            [named(x.name, x.units), x.tornado[0], *([x.explained] if explained else []), *x.tornado[1:]] for x in first
        ]
        headings = [TORNADO[0], *([EXPLAINED] if explained else []), *TORNADO[1:]]
        return TextTable.of(["input"], headings, rows), more

    def sobol(self, most: int) -> tuple[TextTable, str]:
        """The inputs with the largest total indices, and a remark if there are more."""
        first, more = self._first([(row.numbers["total_order"], row) for row in self.inputs], most)
        return TextTable.of(["input"], ["first", "total"], [[x.name, *x.indices] for x in first]), more

    def effects(self, most: int) -> tuple[str, TextTable] | None:
        """The headline and the table of elementary effects; None if there are none."""
        first, more = self._first([(row.numbers["mu_star"], row) for row in self.inputs], most)
        if not first:
            return None
        headline = f"elementary effects on {self.name}, {self.every_row:,} rows{more}"
        return headline, TextTable.of(["input"], ["mu*", "mu", "sigma"], [[x.name, *x.effects] for x in first])

    @staticmethod
    def _first(sized: Sequence[tuple[float, InputRow]], most: int) -> tuple[list[InputRow], str]:
        """The largest rows, without those that have no size."""
        having = sorted(((size, row) for size, row in sized if size == size), key=lambda pair: -pair[0])
        more = f" (the first {most} of {len(having)} inputs)" if len(having) > most else ""
        return [row for _, row in having[:most]], more


@dataclass(frozen=True)
class SensitivityRows:
    """headline: how many runs there are; notes: what has been left out; chosen: a note that the outputs were chosen,
    empty if they were asked for."""

    headline: str
    notes: Sequence[str]
    chosen: str
    outputs: Sequence[OutputRows]

    @property
    def strongest(self) -> list[int]:
        """The places of the inputs, those that are strongest for any output first."""
        sizes = [[row.strength for row in output.inputs] for output in self.outputs]
        largest = [max((x for x in of_one if x == x), default=0.0) for of_one in zip(*sizes, strict=True)]
        return sorted(range(len(largest)), key=lambda k: -largest[k])


def sensitivity_rows(found: xr.Dataset) -> SensitivityRows:
    """The rows of what `sensitivity` found."""
    runs, failed = found.attrs["runs"], found.attrs["failed"]
    title = f"{found.attrs['title']}: " if found.attrs["title"] else ""
    notes = [note for note in str(found.attrs["notes"]).split("\n") if note]
    return SensitivityRows(
        f"{title}{runs - failed:,} of {runs:,} runs good, {failed:,} failed",
        [note for note in notes if note != CHOSEN],
        CHOSEN if CHOSEN in notes else "",
        [_output(found.isel(output=n)) for n in range(found.sizes["output"])],
    )


def _output(one: xr.Dataset) -> OutputRows:
    numbers = {name: one[name].values.tolist() for name in OF_BOTH}
    inputs = [
        InputRow(str(name), str(units), {key: values[k] for key, values in numbers.items()})
        for k, (name, units) in enumerate(zip(one["input"].values, one["input_units"].values, strict=True))
    ]
    name, units = str(one["output"].item()), str(one["output_units"].item())
    mean, deviation, time = (float(one[key]) for key in ("mean", "deviation", "output_time"))
    runs, rows = int(one["runs"]), int(one["rows"])
    return OutputRows(name, units, time, runs, mean, deviation, rows, int(one.attrs["rows"]), inputs)
