"""What `sensitivity` found as rows: of each output its inputs, with their numbers and these as texts, which a terminal
and a page draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import xarray as xr

from lienumba.analysis.labels import named, time_label
from lienumba.analysis.sensitivities.sensitivity import CHOSEN, OF_BOTH
from lienumba.analysis.text_table import NONE, TextTable, number_text
from lienumba.words import plural

TORNADO = ("rank correlation", "10 %", "90 %", "mean below", "mean above", "change")


@dataclass(frozen=True)
class InputRow:
    """An input of one output, with its unit. numbers: by the names of the variables of `sensitivity`; NaN: none."""

    name: str
    units: str
    numbers: Mapping[str, float]

    @property
    def tornado(self) -> list[str]:
        """The texts of a row below the headings of TORNADO."""
        of = self.numbers
        r, r_low, r_high = (of[f"rank_correlation{end}"] for end in ("", "_low", "_high"))
        half = 0.5 * (of["change_high"] - of["change_low"])
        spread = f" ± {half:.2g}" if half == half else ""
        ends = [number_text(of[name], ".4g") for name in ("input_low", "input_high", "low", "high")]
        change = f"{of['change']:.3g}{spread}" if of["low"] == of["low"] else NONE
        return [f"{r:.2f} ({r_low:.2f} to {r_high:.2f})", *ends, change]

    @property
    def indices(self) -> list[str]:
        """First and total Sobol' index."""
        names = ("first_order", "total_order")
        return [f"{self.numbers[x]:.3f} ± {self.numbers[f'{x}_high'] - self.numbers[x]:.2g}" for x in names]


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
        first = [row.numbers["first_order"] for row in self.inputs]
        if all(x != x for x in first):
            return ""
        of = f"Sobol' indices of {self.name}, {self.rows:,} of {self.every_row:,} rows"
        return f"{of}; the first add up to {sum(x for x in first if x == x):.2f}"

    def tornado(self, most: int) -> tuple[TextTable, str]:
        """The inputs with the largest rank correlations, and a remark if there are more."""
        first, more = self._largest("rank_correlation", most)
        return TextTable.of(["input"], TORNADO, [[named(x.name, x.units), *x.tornado] for x in first]), more

    def sobol(self, most: int) -> tuple[TextTable, str]:
        """The inputs with the largest total indices, and a remark if there are more."""
        first, more = self._largest("total_order", most)
        return TextTable.of(["input"], ["first", "total"], [[x.name, *x.indices] for x in first]), more

    def _largest(self, number: str, most: int) -> tuple[list[InputRow], str]:
        """The inputs with the largest of a number, without those that have none."""
        having = [row for row in self.inputs if row.numbers[number] == row.numbers[number]]
        having.sort(key=lambda row: -abs(row.numbers[number]))
        return having[:most], f" (the first {most} of {len(having)} inputs)" if len(having) > most else ""


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
        """The places of the inputs, those with the largest rank correlations with any output first."""
        sizes = [[abs(row.numbers["rank_correlation"]) for row in output.inputs] for output in self.outputs]
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
