"""What a person sees of requirements: the verdicts, what they are from, and how many more runs would decide."""

from typing import TYPE_CHECKING

from lienumba.analysis.requirements.verdict import legend, notes, table, verdicts_of
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.sweep.verdicts import Verdict

WIDTH = 150  # where there is no terminal


def print_verdicts(ds: "xr.Dataset") -> "list[Verdict]":
    """The table of requirements and what it leaves open; nothing of a dataset without any. Returned are the
    verdicts."""
    found = verdicts_of(ds)
    if found:
        output = wide_output(WIDTH)
        output.print(table(ds, found).on_terminal("requirements"))
        for line in (*(f"{x.requirement}: {x.advice}" for x in found if x.advice), legend(found), *notes(ds)):
            output.print(line, markup=False)
    return found
