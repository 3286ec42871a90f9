"""What a person sees of a comparison: what differs in the scenarios, and by how much the runs differ."""

from typing import TYPE_CHECKING

from lienumba.analysis.labels import named
from lienumba.analysis.text_table import NONE, TextTable, number_text
from lienumba.present.terminal.console import wide_output

if TYPE_CHECKING:
    import xarray as xr

WIDTH = 140  # where there is no terminal
LEGEND = (
    "difference: mean of second minus first over pairs of runs with the same label; 95 % confidence, at least that of "
    "failed and of requirements"
)


def print_comparison(found: "xr.Dataset", first: str, second: str) -> None:
    """The differences, and what `compare` says of them."""
    output = wide_output(WIDTH)
    output.print(f"{first} and {second}: {found.attrs['runs']:,} runs in common", markup=False)
    for line in filter(None, str(found.attrs["changes"]).split("\n")):
        output.print(f"  {line}", markup=False)
    for line in filter(None, str(found.attrs["verdicts"]).split("\n")):
        output.print(line, markup=False)
    rows = []
    for n, name in enumerate(found["output"].values):
        of = {str(key): float(x[n]) for key, x in found.data_vars.items()}
        interval = f"{of['difference_low']:.4g} to {of['difference_high']:.4g}" if of["pairs"] > 1 else NONE
        numbers = [number_text(of[key], ".5g") for key in ("mean_a", "mean_b", "difference")]
        larger = f"{100.0 * of['larger']:.3g} %" if of["pairs"] > 1 else NONE
        label = named(str(name), str(found["output_units"].values[n]))
        rows.append([label, f"{of['pairs']:,.0f}", *numbers, interval, larger, number_text(of["correlation"], ".3f")])
    headings = ["pairs", "first", "second", "difference", "95 %", "second larger", "correlation"]
    output.print(TextTable.of(["output"], headings, rows).on_terminal())
    for line in filter(None, [LEGEND, *str(found.attrs["notes"]).split("\n")]):
        output.print(line, markup=False)
