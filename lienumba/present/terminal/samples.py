"""What a person sees of a design table."""

from collections.abc import Sequence
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.analysis.labels import unit_label
from lienumba.analysis.text_table import NUMBER, UNIT, WORD, TextTable
from lienumba.present.terminal.console import wide_output
from lienumba.words import plural

if TYPE_CHECKING:
    from lienumba.scenario.start.samples_file import InputStatistics


WIDTH = 110  # where there is no terminal


def print_samples(statistics: Sequence["InputStatistics"], runs: int, weighted: bool, target: Path) -> None:
    """How each input spreads, and where the table is."""
    rows = [[x.path, *(f"{n:.6g}" for n in (x.mean, x.std, x.low, x.high)), unit_label(x.units)] for x in statistics]
    headings = ["input", "mean", "std", "min", "max", "unit"]
    table = TextTable(headings, [WORD, *repeat(NUMBER, 4), UNIT], rows)
    output = wide_output(WIDTH)
    output.print(table.on_terminal())
    if weighted:
        output.print("mean and std are by the weights of the runs, the last column of the table", markup=False)
    output.print(f"{plural(runs, 'run', 'runs')} drawn, written to {target}", markup=False)
