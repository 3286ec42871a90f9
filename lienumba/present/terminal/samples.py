"""What a person sees of a design table."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lienumba.scenario.start.samples_file import Spread


def print_samples(spreads: Sequence["Spread"], runs: int, target: Path) -> None:
    """How each input spreads, and where the table is."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    output = Console(width=None if sys.stdout.isatty() else 110, highlight=False, soft_wrap=True)
    table = Table(box=box.SIMPLE_HEAD, title_justify="left")
    table.add_column("input", no_wrap=True)
    for heading in ("mean", "std", "min", "max"):
        table.add_column(heading, justify="right")
    table.add_column("unit")
    for x in spreads:
        table.add_row(x.path.replace("[", "\\["), *(f"{n:.6g}" for n in (x.mean, x.std, x.low, x.high)), x.units)
    output.print(table)
    output.print(f"{runs:,} {'run' if runs == 1 else 'runs'} drawn, written to {target}", markup=False)
