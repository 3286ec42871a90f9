"""Commands about what hardly ever happens: rare, worst."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lienumba.cli.options import (
    AllowScenarioCodeOption,
    FoundOption,
    OverwriteOption,
    QuietOption,
    ScenarioArgument,
    SeedOption,
    SetOption,
    say_files,
    written,
)
from lienumba.present.terminal import console

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

RequirementOption = Annotated[
    str | None,
    typer.Option("--requirement", metavar="NAME", help="Which one, where there are several.", show_default=False),
]
WorkersOption = Annotated[
    int | None, typer.Option("-j", "--workers", metavar="N", min=1, help="Threads (default: one per core).")
]


def rare(
    scenario: ScenarioArgument,
    requirement: RequirementOption = None,
    method: Annotated[str, typer.Option("--method", metavar="METHOD", help="subset, importance or form.")] = "subset",
    runs: Annotated[
        int | None,
        typer.Option("--runs", metavar="N", help="Of each level of subset, or of importance.", show_default=False),
    ] = None,
    confidence: Annotated[float, typer.Option("--confidence", metavar="C", help="Of the interval.")] = 0.95,
    output: FoundOption = None,
    workers: WorkersOption = None,
    seed: SeedOption = None,
    settings: SetOption = None,
    allow_code: AllowScenarioCodeOption = False,
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
) -> None:
    """Estimate how probable it is that a requirement is not met, where that is too rare to be counted."""
    with console.exit_codes():
        from lienumba.engine.rare.rare import rare as estimated
        from lienumba.present.terminal.rare import print_rare

        given = {"requirement": requirement, "method": method, "runs": runs, "confidence": confidence}
        more = {"workers": workers, "seed": seed, "allow_code": allow_code}
        _found(estimated, scenario, given | more, settings, output, overwrite, quiet, print_rare)


def worst(
    scenario: ScenarioArgument,
    requirement: RequirementOption = None,
    within: Annotated[
        float,
        typer.Option("--within", metavar="PART", help="The part of each input's samples between its bounds."),
    ] = 0.9973,
    runs: Annotated[int, typer.Option("--runs", metavar="N", help="About how many may be simulated.")] = 2000,
    output: FoundOption = None,
    workers: WorkersOption = None,
    seed: SeedOption = None,
    settings: SetOption = None,
    allow_code: AllowScenarioCodeOption = False,
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
) -> None:
    """Search for the inputs within bounds that come nearest to breaking a requirement, or break it most."""
    with console.exit_codes():
        from lienumba.engine.rare.worst import worst as searched
        from lienumba.present.terminal.rare import print_worst

        given = {"requirement": requirement, "within": within, "runs": runs}
        more = {"workers": workers, "seed": seed, "allow_code": allow_code}
        _found(searched, scenario, given | more, settings, output, overwrite, quiet, print_worst)


def _found(
    search: "Callable[..., xr.Dataset]",
    scenario: Path,
    given: dict[str, Any],
    settings: list[str] | None,
    output: Path | None,
    overwrite: bool,
    quiet: bool,
    show: "Callable[[xr.Dataset], None]",
) -> None:
    """What a command has in common with the other: search, write, tell."""
    from lienumba.scenario.base.arguments import parse_assignments
    from lienumba.scenario.resolve import resolve

    allow_code = given.pop("allow_code")
    changes, seed = parse_assignments(settings or []), given.pop("seed")
    resolved = resolve(scenario, overrides=changes, seed=seed, allow_code=allow_code, counted=False)
    if not quiet:
        console.print_warnings(resolved.warnings)

    def find() -> "xr.Dataset":
        with console.progress(quiet) as tell:
            return search(resolved, **given, progress=tell)

    found = written(find, output, overwrite)
    if not quiet:
        with console.unheard():
            show(found)
            say_files(output)
