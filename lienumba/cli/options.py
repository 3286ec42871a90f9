"""Arguments and options that commands share, and the way to a dataset that is found."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lienumba.present.terminal import console

if TYPE_CHECKING:
    import xarray as xr

ScenarioArgument = Annotated[
    Path, typer.Argument(metavar="SCENARIO", help="The scenario, a TOML file.", show_default=False)
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help="Change one value, such as integrator.step=1e-4 or bodies.top.mass=12; may be repeated.",
        show_default=False,
    ),
]
RunsOption = Annotated[
    str | None,
    typer.Option("--runs", metavar="LABELS", help="Only these runs, such as 3,17 or 0:500 (-1: nominal)."),
]
AllowCodeOption = Annotated[bool, typer.Option("--allow-code", help="Run the Python code that the dataset brings.")]
AllowScenarioCodeOption = Annotated[
    bool,
    typer.Option("--allow-code", help="Run Python code that the scenario brings, or names outside its folder."),
]
SeedOption = Annotated[int | None, typer.Option("--seed", help="Replace sweep.seed.", show_default=False, metavar="N")]
VerdictOption = Annotated[
    bool, typer.Option("--verdict", help="Exit with 4 unless the runs show that all requirements are met.")
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")]
OverwriteOption = Annotated[bool, typer.Option("--overwrite", help="Replace an existing dataset.")]
OverwriteTableOption = Annotated[bool, typer.Option("--overwrite", help="Replace an existing table.")]
DatasetArgument = Annotated[Path, typer.Argument(metavar="DATASET", help="A dataset (.nc).", show_default=False)]
FileArgument = Annotated[Path, typer.Argument(metavar="FILE", help="A dataset (.nc).", show_default=False)]
OutputsArgument = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[OUTPUT]...",
        help="Such as tip, position.top.z, event_time.far or failed (default: what says most).",
        show_default=False,
    ),
]
TimeOption = Annotated[
    float | None,
    typer.Option(
        "--time", metavar="T", help="The stored time of series, in s (default: the last).", show_default=False
    ),
]
TableOption = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="TABLE", help="A CSV or netCDF file to write.", show_default=False),
]
FoundOption = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FILE", help="A dataset (.nc) to write.", show_default=False),
]


def written(find: "Callable[[], xr.Dataset]", output: Path | None, overwrite: bool) -> "xr.Dataset":
    """Find a dataset and write it to a file, which is claimed before."""
    from lienumba.store.outputs import write
    from lienumba.store.targets import claimed_dataset

    with ExitStack() as stack:
        own = None
        if output is not None:
            own = stack.enter_context(claimed_dataset(output, overwrite, resumable=False))
        found = find()
        if own is not None:
            write(found, own)
    return found


def say_files(*files: Path | None) -> None:
    """Name the files that were written."""
    for file in filter(None, files):
        console.say(f"written to {file}")
