"""What a person sees of a rare failure: how probable it is, where it is most probable, and what decides it."""

from typing import TYPE_CHECKING

import numpy as np

from lienumba.analysis.text_table import TextTable
from lienumba.present.terminal.console import wide_output
from lienumba.store.layout import MARGIN
from lienumba.words import plural, show

if TYPE_CHECKING:
    import xarray as xr

WIDTH = 120  # where there is no terminal


def print_rare(ds: "xr.Dataset") -> None:
    """The probability, its interval, and the nearest design point."""
    output, count = wide_output(WIDTH), _count(ds)
    p, low, high = (float(ds[f"probability{name}"]) for name in ("", "_low", "_high"))
    name, confidence = show(ds.attrs["requirement"]), float(ds["probability"].attrs["confidence"])
    failed = int((ds["status"].values != 0).sum())
    if p == 0.0:
        said = f"none of the runs that count, of {count}, fails; a failure has a probability of {high:.3g} at most"
        output.print(f"{name}: {said} with a confidence of {100 * confidence:g} %", markup=False)
        return
    method = ds.attrs["method"]
    between = f", from {low:.3g} to {high:.3g} with a confidence of {100 * confidence:g} %"
    said = f"a run does not meet it with a probability of {p:.3g}{'' if method == 'form' else between}"
    more = f", {failed:,} of which failed" if failed else ""
    output.print(f"{name}: {said} ({method}, {count}{more})", markup=False)
    if "design_point" not in ds.dims:
        return
    nearest = ds.isel(design_point=0)
    inputs = [str(x).removeprefix("design_") for x in ds.data_vars if str(x).startswith("design_")]
    rows = [[path, f"{float(nearest[f'design_{path}']):.6g}"] for path in inputs]
    shares = {str(x): float(part) for x, part in zip(ds.stream.values, nearest["direction"].values ** 2, strict=True)}
    rows = [[*row, f"{100 * shares[row[0]]:.1f} %" if row[0] in shares else "–"] for row in rows]
    title = f"failures are most probable {float(nearest['distance']):.3g} standard deviations away, at"
    output.print(TextTable.of(["input"], ["value", "its part in it"], rows).on_terminal(title))
    if ds.sizes["design_point"] > 1:
        others = ", ".join(f"{x:.3g}" for x in ds["distance"].values[1:])
        output.print(f"and at others {others} away (distance, design_...)", markup=False)
    _print_notes(ds)


def print_worst(ds: "xr.Dataset") -> None:
    """The smallest margin, and the inputs there."""
    output = wide_output(WIDTH)
    found = ds.sel(run=int(ds["worst"]))
    margin, units = found[MARGIN].item(), str(ds["requirement_units"].item())
    name, count = show(ds.attrs["requirement"]), _count(ds)
    if np.isnan(margin):
        said = "the run fails"
    elif np.isinf(margin):
        said = f"{'met' if margin > 0.0 else 'not met'} by any limit, since what it tells the time of never happens"
    else:
        said = f"{'met' if margin > 0.0 else 'not met'} by {abs(margin):.6g}{'' if units in ('', '1') else f' {units}'}"
    inputs = [str(x) for x in ds.coords if ds[x].attrs.get("role") == "input"]
    rows = [[path, f"{float(found[path]):.6g}"] for path in inputs]
    title = f"{name}: the worst of {count} within {100 * float(ds.attrs['within']):.6g} % of each input: {said}, at"
    output.print(TextTable.of(["input"], ["value"], rows).on_terminal(title))
    _print_notes(ds)


def _count(ds: "xr.Dataset") -> str:
    """How many runs there are, those with derivatives apart."""
    exact = int(ds.attrs["runs_with_derivatives"])
    count = plural(ds.sizes["run"] - exact, "run", "runs")
    return f"{count} and {exact:,} with derivatives" if exact else count


def _print_notes(ds: "xr.Dataset") -> None:
    for line in filter(None, str(ds.attrs["notes"]).split("\n")):
        wide_output(WIDTH).print(line, markup=False)
