"""What a person sees of a study: how its runs ended, the observed orders, and work against precision."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.analysis import work_precision
from lienumba.analysis.studies.orders import orders
from lienumba.analysis.studies.study import curves, labels_of, order_text, text, time_text
from lienumba.store.study_layout import ERRORS, grid_of
from lienumba.words import plural

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

MOST_ROWS = 60  # of the table of points


def print_study(ds: "xr.Dataset", target: Path) -> None:
    """The tables of a study."""
    from rich.console import Console

    output = Console(width=None if sys.stdout.isatty() else 130, highlight=False, soft_wrap=True)
    points, runs = ds["time_per_run"].size, ds.sizes["run"]
    title = f"{ds.attrs['title']}: " if ds.attrs.get("title") else ""
    failed = int((ds["status"] != 0).sum())
    each = f"{plural(points, 'point', 'points')}, each with {plural(runs, 'run', 'runs')}"
    output.print(f"{title}{each}, {failed:,} of {points * runs:,} failed", markup=False)
    for line in _failures(ds):
        output.print(f"  {line}", markup=False)
    if any(len(curve.points) > 1 for curve in curves(ds)):
        output.print(_orders(ds))
    output.print(_points(ds))
    output.print(f"written to {target}", markup=False)


def _failures(ds: "xr.Dataset") -> Iterator[str]:
    from lienumba.batch.statuses import STATUSES

    status = ds["status"].values.reshape(ds.sizes["run"], -1)
    labels = labels_of(ds)
    for known in STATUSES[1:]:
        failed = status == known.code
        if failed.any():
            at = [point for point, some in enumerate(failed.any(axis=0)) if some]
            where = ", ".join(f"{name} = {text(x[at[0]])}" for name, x in labels.items() if text(x[at[0]]))
            more = f" and {plural(len(at) - 1, 'other point', 'other points')}" if len(at) > 1 else ""
            yield f"{int(failed.sum()):,} {known.name}: {known.sentence}; at {where}{more}"


def _orders(ds: "xr.Dataset") -> "Table":
    lines, found = curves(ds), orders(ds)
    table = _table("observed orders, 95 % confidence", [*lines[0].labels])
    for name in found["error"].values:
        table.add_column(str(name).replace("_", " "), justify="right")
    table.add_column("points", justify="right")
    table.add_column("mean steps", justify="right")
    flat = {str(key): x.values.reshape(found.sizes["error"], -1) for key, x in found.data_vars.items()}
    for n, line in enumerate(lines):
        cells = [
            order_text(*(flat[key][row, n] for key in ("order", "low", "high"))) for row in range(len(flat["order"]))
        ]
        first = {key: x[0, n] for key, x in flat.items()}
        steps = f"{first['finest']:.3g} to {first['coarsest']:.3g} s" if first["points"] > 1 else ""
        table.add_row(*map(text, line.labels.values()), *cells, str(first["points"]), steps)
    return table


def _points(ds: "xr.Dataset") -> "Table":
    import numpy as np

    found, labels = work_precision(ds), labels_of(ds)
    flat = {str(name): x.values.ravel() for name, x in found.data_vars.items()}
    columns = {name: flat[f"{name}_error"] for name in ERRORS if f"{name}_error" in flat}
    shown = range(min(len(flat["failed"]), MOST_ROWS))
    more = f", the first {MOST_ROWS} of {len(flat['failed'])} points" if len(flat["failed"]) > MOST_ROWS else ""
    median = " (medians over the good runs)" if ds.sizes["run"] > 1 else ""
    table = _table(f"work and precision: largest errors{median}{more}", list(grid_of(ds)))
    for name in columns:
        table.add_column(f"{name.replace('_', ' ')} ({ERRORS[name][0].replace(' s-1', '/s')})", justify="right")
    counts = {name: flat[name] for name in ("steps", "rejected_steps", "evaluations", "failed")}
    counts = {name: x for name, x in counts.items() if name in ("steps", "evaluations") or np.nansum(x)}
    for name in (*counts, "time per run"):
        table.add_column(name.replace("_", " "), justify="right")
    for n in shown:
        own = [text(values[n]) for values in labels.values()]
        errors = [f"{x[n]:.1e}" if x[n] == x[n] else "-" for x in columns.values()]
        costs = [f"{x[n]:,.0f}" if x[n] == x[n] else "-" for x in counts.values()]
        table.add_row(*own, *errors, *costs, time_text(flat["time_per_run"][n]))
    return table


def _table(title: str, headings: list[str]) -> "Table":
    from rich import box
    from rich.table import Table

    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    for heading in headings:
        table.add_column(heading)
    return table
