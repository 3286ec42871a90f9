"""What a person sees of a sensitivity analysis: of each output a tornado with rank correlations, and Sobol' indices."""

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from lienumba.words import plural

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from rich.table import Table

MOST_INPUTS = 12  # rows of a table
WIDTH = 140  # where there is no terminal
LEGEND = (
    "change: mean output over the runs with the input above its 90 % quantile minus that below its 10 % quantile, the "
    "other inputs varying; ± and ( ) are 95 % confidence"
)


def print_sensitivity(found: "xr.Dataset") -> None:
    """The tables of `sensitivity`, and what it says of them."""
    from rich.console import Console

    output = Console(width=None if sys.stdout.isatty() else WIDTH, highlight=False, soft_wrap=True)
    runs, failed = found.attrs["runs"], found.attrs["failed"]
    title = f"{found.attrs['title']}: " if found.attrs["title"] else ""
    output.print(f"{title}{runs - failed:,} of {runs:,} runs good, {failed:,} failed", markup=False)
    for n in range(found.sizes["output"]):
        one = found.isel(output=n)
        output.print(_tornado(one))
        if one["first_order"].notnull().any():
            output.print(_sobol(one))
    for line in _notes(found):
        output.print(line, markup=False)


def _notes(found: "xr.Dataset") -> Iterator[str]:
    yield LEGEND
    yield from filter(None, found.attrs["notes"].split("\n"))


def _tornado(one: "xr.Dataset") -> "Table":
    """The inputs with the largest rank correlations first."""
    order = _largest(one["rank_correlation"].values)
    time = f" at t = {float(one['output_time']):g} s" if one["output_time"].notnull() else ""
    spread = f"mean {float(one['mean']):.6g}, standard deviation {float(one['deviation']):.3g}"
    headings = ["rank correlation", "10 %", "90 %", "mean below", "mean above", "change"]
    of = f"{_name(one, 'output')}{time}, {plural(int(one['runs']), 'run', 'runs')}: {spread}"
    table = _table(of + _more(order), headings)
    for k in order[:MOST_INPUTS]:
        row = {str(name): float(x[k]) for name, x in one.data_vars.items() if "input" in x.dims}
        half = 0.5 * (row["change_high"] - row["change_low"])
        cells = [_number(row[name]) for name in ("input_low", "input_high", "low", "high")]
        change = f"{row['change']:.3g}" + (f" ± {half:.2g}" if half == half else "") if cells[2] != "-" else "-"
        r, r_low, r_high = (row[f"rank_correlation{end}"] for end in ("", "_low", "_high"))
        rank = f"{r:.2f} ({r_low:.2f} to {r_high:.2f})"
        table.add_row(_name(one.isel(input=k), "input"), rank, *cells, change)
    return table


def _sobol(one: "xr.Dataset") -> "Table":
    """The inputs with the largest total indices first."""
    order = _largest(one["total_order"].values)
    of = f"Sobol' indices of {one['output'].item()}, {int(one['rows']):,} of {one.attrs['rows']:,} rows"
    table = _table(f"{of}; the first add up to {float(one['first_order'].sum()):.2f}{_more(order)}", ["first", "total"])
    for k in order[:MOST_INPUTS]:
        row = {str(name): float(x[k]) for name, x in one.data_vars.items() if "input" in x.dims}
        indices = (f"{row[x]:.3f} ± {row[f'{x}_high'] - row[x]:.2g}" for x in ("first_order", "total_order"))
        table.add_row(str(one["input"].values[k]), *indices)
    return table


def _largest(values: "np.ndarray") -> list[int]:
    """The indices of values, the largest first; without those that are none."""
    return sorted((k for k, x in enumerate(values) if x == x), key=lambda k: -abs(values[k]))


def _more(order: list[int]) -> str:
    return f" (the first {MOST_INPUTS} of {len(order)} inputs)" if len(order) > MOST_INPUTS else ""


def _number(value: float) -> str:
    return f"{value:.4g}" if value == value else "-"


def _name(one: "xr.Dataset", dim: str) -> str:
    """A name with its unit, as people write it."""
    units = str(one[f"{dim}_units"].item())
    return f"{one[dim].item()}" + ("" if units in ("1", "") else f" ({units.replace(' s-1', '/s')})")


def _table(title: str, headings: list[str]) -> "Table":
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(title), box=box.SIMPLE_HEAD, title_justify="left")
    table.add_column("input")
    for heading in headings:
        table.add_column(heading, justify="right")
    return table
