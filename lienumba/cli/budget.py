"""The command about what each input has to do with the scatter of outputs: budget."""

from pathlib import Path
from typing import Annotated

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


def budget(
    scenario: ScenarioArgument,
    outputs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[OUTPUT]...",
            help="Such as miss, last_position.top.z or event_time.far (default: measures and times of events).",
            show_default=False,
        ),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option("--runs", metavar="N", help="Simulate so many random runs to check it.", show_default=False),
    ] = None,
    sweep: Annotated[
        Path | None,
        typer.Option(
            "--sweep", metavar="DATASET", help="Check it by this sweep of the scenario (.nc).", show_default=False
        ),
    ] = None,
    output: FoundOption = None,
    workers: Annotated[
        int | None, typer.Option("-j", "--workers", metavar="N", min=1, help="Threads (default: one per core).")
    ] = None,
    seed: SeedOption = None,
    settings: SetOption = None,
    allow_code: AllowScenarioCodeOption = False,
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
) -> None:
    """Say which share each input of a sweep has in the variance of each output, from one run with derivatives."""
    with console.exit_codes():
        from lienumba.engine.budget.budget import budget as shares
        from lienumba.present.terminal.budget import print_budget
        from lienumba.scenario.base.arguments import parse_assignments
        from lienumba.scenario.resolve import resolve

        changes = parse_assignments(settings or [])
        resolved = resolve(scenario, overrides=changes, seed=seed, allow_code=allow_code, counted=False)
        if not quiet:
            console.print_warnings(resolved.warnings)
        of = outputs or []
        with console.progress(quiet) as tell:
            found = written(
                lambda: shares(resolved, of=of, runs=runs, sweep=sweep, workers=workers, progress=tell),
                output,
                overwrite,
            )
        if not quiet:
            with console.unheard():
                print_budget(found)
                say_files(output)
