"""Commands about what is near a state: modes, equilibrium."""

from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import typer

from lienumba.cli.options import FoundOption, OverwriteOption, QuietOption, RunsOption, SetOption, say_files, written
from lienumba.present.terminal import console

SourceArgument = Annotated[
    Path, typer.Argument(metavar="SOURCE", help="A scenario (TOML), or a dataset (.nc).", show_default=False)
]
RotationOption = Annotated[
    str,
    typer.Option("--rotation", metavar="X,Y,Z", help="Relative to axes that turn at this rate in rad/s."),
]
TurningOption = Annotated[
    str | None,
    typer.Option(
        "--rotation", metavar="X,Y,Z", help="Turning at this rate in rad/s (default: as start.rotation has it).",
        show_default=False,
    ),
]  # fmt: skip
CodeOption = Annotated[
    bool, typer.Option("--allow-code", help="Run Python code that the source brings, or names outside its folder.")
]


def modes(
    source: SourceArgument,
    at: Annotated[
        str, typer.Option("--at", metavar="TIMES", help='Times in s, such as 0,1.5,end ("end": of the runs).')
    ] = "0",
    output: FoundOption = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FIGURE", help="A PNG, SVG or PDF file of them, replaced.", show_default=False),
    ] = None,
    rotation: RotationOption = "0,0,0",
    settings: SetOption = None,
    runs: RunsOption = None,
    allow_code: CodeOption = False,
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
) -> None:
    """Find the vibration modes of every run: frequencies, damping, shapes; which are unstable."""
    with console.exit_codes():
        from lienumba.analysis.mode_rows import mode_rows
        from lienumba.engine.linear.modes import modes as found_modes
        from lienumba.scenario.base.arguments import parse_assignments

        given = {"rotation": rotation.split(","), "runs": _labels(runs), "allow_code": allow_code}
        changes = parse_assignments(settings or [])
        found = written(lambda: found_modes(source, at=at.split(","), overrides=changes, **given), output, overwrite)
        if plot is not None:
            from lienumba.figures.plots import figure, save

            save(lambda: figure(found), plot)
        if not quiet:
            with console.unheard():
                wide = console.wide_output(140)
                for rows in mode_rows(found):
                    wide.print(rows.table.on_terminal(rows.headline))
                    for note in rows.notes:
                        wide.print(note, markup=False)
                say_files(output, plot)


def equilibrium(
    source: SourceArgument,
    output: FoundOption = None,
    rotation: TurningOption = None,
    settings: SetOption = None,
    runs: RunsOption = None,
    allow_code: CodeOption = False,
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
) -> None:
    """Find where every run rests, or turns uniformly, and whether that is stable."""
    with console.exit_codes():
        from lienumba.analysis.mode_rows import equilibrium_rows
        from lienumba.engine.linear.equilibrium import equilibrium as found_equilibrium
        from lienumba.integrators.codes import NONE_FOUND
        from lienumba.scenario.base.arguments import parse_assignments

        given: dict[str, Any] = {"allow_code": allow_code}
        given |= {"rotation": None if rotation is None else rotation.split(",")}
        given |= {"runs": _labels(runs), "overrides": parse_assignments(settings or [])}
        found = written(lambda: found_equilibrium(source, **given), output, overwrite)
        if not quiet:
            with console.unheard():
                rows = equilibrium_rows(found)
                console.wide_output(140).print(rows.table.on_terminal(rows.headline))
                say_files(output)
        if bool((found["status"] == NONE_FOUND).any()):
            raise typer.Exit(console.SOME_FAILED)


def _labels(runs: str | None) -> Any:
    """The labels of `--runs`."""
    if runs is None:
        return None
    from lienumba.scenario.base.arguments import parse_ranges

    return chain.from_iterable(parse_ranges(runs, f"--runs {runs}"))
