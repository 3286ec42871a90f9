"""What a person sees of a sensitivity analysis: of each output a tornado with rank correlations, and Sobol' indices."""

from typing import TYPE_CHECKING

from lienumba.analysis.sensitivities.sensitivity_rows import sensitivity_rows
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    import xarray as xr

MOST_INPUTS = 12  # rows of a table
WIDTH = 140  # where there is no terminal
LEGEND = (
    "explains: the part of the variance that the input explains alone; change: mean output over the runs with the "
    "input above its 90 % quantile minus that below its 10 % quantile, the others varying; ± is 95 % confidence"
)


def print_sensitivity(found: "xr.Dataset") -> None:
    """The tables of `sensitivity`, and what it says of them."""
    output, rows = wide_output(WIDTH), sensitivity_rows(found)
    output.print(rows.headline, markup=False)
    for one in rows.outputs:
        table, more = one.tornado(MOST_INPUTS)
        output.print(table.on_terminal(one.headline + more))
        if one.sobol_headline:
            table, more = one.sobol(MOST_INPUTS)
            output.print(table.on_terminal(one.sobol_headline + more))
        if effects := one.effects(MOST_INPUTS):
            output.print(effects[1].on_terminal(effects[0]))
    for line in filter(None, [LEGEND, *rows.notes, rows.chosen]):
        output.print(line, markup=False)
