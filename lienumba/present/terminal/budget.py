"""What a person sees of a budget of tolerances: deviations of outputs, and the shares of inputs in them."""

from typing import TYPE_CHECKING

import numpy as np

from lienumba.analysis.text_table import TextTable, number_text, short_text
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    import xarray as xr

WIDTH = 140  # where there is no terminal
COLUMNS = 4  # outputs beside one another
MOST_INPUTS = 20  # rows of a table
DIGITS = 5


def print_budget(ds: "xr.Dataset") -> None:
    """The deviation of each output, with what runs say of it, and the share of each input."""
    output = wide_output(WIDTH)
    output.print(_outputs(ds).on_terminal("one nominal run, differentiated"))
    for first in range(0, ds.sizes["output"], COLUMNS):
        part = ds.isel(output=slice(first, first + COLUMNS))
        table, left = _shares(part)
        title = "shares of the inputs in the variance"
        output.print(table.on_terminal(f"{title}; {left} more have smaller ones" if left else title))
    for line in filter(None, str(ds.attrs["notes"]).split("\n")):
        output.print(line, markup=False)


def _outputs(ds: "xr.Dataset") -> TextTable:
    """A row for each output."""
    words, numbers = ["output", "unit"], ["nominal", "deviation"]
    columns = [[short_text(float(x), DIGITS) for x in ds[name].values] for name in ("nominal", "deviation")]
    if "counted" in ds:
        numbers += ["runs", "deviation of the runs", "mean of the runs", "with control variate", "correlation"]
        columns += [
            [f"{int(x):,}" for x in ds["counted"].values],
            [short_text(float(x), DIGITS) for x in ds["sampled_deviation"].values],
            _with_errors(ds, "mean"),
            _with_errors(ds, "controlled_mean"),
            [number_text(float(x), ".4f") for x in ds["correlation"].values],
        ]
    names = zip(ds["output"].values.tolist(), ds["output_units"].values.tolist(), strict=True)
    return TextTable.of(words, numbers, [[*name, *row] for name, *row in zip(names, *columns, strict=True)])


def _with_errors(ds: "xr.Dataset", name: str) -> list[str]:
    pairs = zip(ds[name].values.tolist(), ds[f"{name}_error"].values.tolist(), strict=True)
    return [f"{short_text(x, DIGITS)} ± {short_text(error, 2)}" for x, error in pairs]


def _shares(ds: "xr.Dataset") -> tuple[TextTable, int]:
    """A row for each input, the largest share first; and how many are left out."""
    shares = ds["share"].values
    order = np.argsort(-np.nan_to_num(np.abs(shares)).max(axis=0), kind="stable")
    rows = []
    for n in order[:MOST_INPUTS]:
        deviation = short_text(float(ds["input_deviation"].values[n]), 4)
        percent = [number_text(100.0 * float(x), ".1f") for x in shares[:, n]]
        texts = [x if x == number_text(np.nan, "") else f"{x} %" for x in percent]
        rows.append([str(ds["input"].values[n]), str(ds["input_units"].values[n]), deviation, *texts])
    outputs = [str(x) for x in ds["output"].values]
    return TextTable.of(["input", "unit"], ["its deviation", *outputs], rows), len(order) - len(rows)
