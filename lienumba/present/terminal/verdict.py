"""What a person sees of requirements: the verdicts, what they are from, and how many more runs would decide."""

from typing import TYPE_CHECKING

from lienumba.analysis.requirements.separation import LEGEND, headline, separable, separation
from lienumba.analysis.requirements.separation import table as separation_table
from lienumba.analysis.requirements.verdict import legend, notes, table, verdicts_of, worst
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.sweep.verdicts import Verdict

WIDTH = 170  # where there is no terminal
MOST_INPUTS = 8  # rows of a table


def print_verdicts(ds: "xr.Dataset") -> "list[Verdict]":
    """The table of requirements and what it leaves open; nothing of a dataset without any. Returned are the
    verdicts."""
    found = verdicts_of(ds)
    if found:
        output = wide_output(WIDTH)
        output.print(table(ds, found).on_terminal("requirements"))
        advice = (f"{x.requirement}: {x.advice}" for x in found if x.advice)
        for line in (*advice, *worst(ds, found), legend(found), *notes(ds)):
            output.print(line, markup=False)
    return found


def print_separations(ds: "xr.Dataset") -> None:
    """Of each requirement that some runs meet and some do not: what sets them apart."""
    output, told = wide_output(WIDTH), False
    for name in separable(ds):
        found = separation(ds, name)
        rows, remark = separation_table(found, MOST_INPUTS)
        output.print(rows.on_terminal(": ".join(filter(None, [headline(found), remark]))))
        told = True
    if told:
        output.print(LEGEND, markup=False)
