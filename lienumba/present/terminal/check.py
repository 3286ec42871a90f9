"""What a person sees of a check of engines."""

from typing import TYPE_CHECKING

from lienumba.analysis.labels import unit_label
from lienumba.analysis.text_table import NUMBER, UNIT, WORD, TextTable
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    from lienumba.engine.checks.engines import Check

WIDTH = 110  # where there is no terminal


def print_check(check: "Check") -> None:
    """The largest difference of each variable, and the verdict."""
    rows = [
        [x.name, f"{x.size:.1e}", f"{x.scale:.4g}", unit_label(x.units), str(x.run), f"{x.time:.6g}"]
        for x in check.differences
    ]
    headings = ["variable", "difference", "largest value", "unit", "run", "time"]
    table = TextTable(headings, [WORD, NUMBER, NUMBER, UNIT, NUMBER, NUMBER], rows)
    output = wide_output(WIDTH)
    output.print(table.on_terminal(check.headline))
    output.print(check.sentence, markup=False)
