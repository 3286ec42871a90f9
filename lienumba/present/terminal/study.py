"""What a person sees of a study: how its runs ended, the observed orders, and work against precision."""

from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.analysis.studies.study_rows import failures, headline, order_table, point_table, refines, remarks
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    import xarray as xr

WIDTH = 130  # where there is no terminal
MOST_ROWS = 60  # of the table of points


def print_study(ds: "xr.Dataset", target: Path) -> None:
    """The tables of a study."""
    output = wide_output(WIDTH)
    points, runs = ds["time_per_run"].size, ds.sizes["run"]
    title = f"{ds.attrs['title']}: " if ds.attrs.get("title") else ""
    failed = int((ds["status"] != 0).sum())
    output.print(f"{title}{headline(ds)}, {failed:,} of {points * runs:,} failed", markup=False)
    for x in failures(ds):
        output.print(f"  {x.count:,} {x.status.name}: {x.status.sentence}; at {x.where}", markup=False)
    if refines(ds):
        output.print(order_table(ds).on_terminal("observed orders, 95 % confidence"))
    median = " (medians over the good runs)" if runs > 1 else ""
    more = f", the first {MOST_ROWS} of {points} points" if points > MOST_ROWS else ""
    output.print(point_table(ds, MOST_ROWS).on_terminal(f"work and precision: largest errors{median}{more}"))
    for remark in remarks(ds):
        output.print(remark, markup=False)
    output.print(f"written to {target}", markup=False)
