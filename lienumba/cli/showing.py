"""Commands that show datasets: plot, animate, report, analyse, compare, table, list."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer

from lienumba.cli.options import (
    AllowCodeOption,
    DatasetArgument,
    FileArgument,
    OutputsArgument,
    OverwriteTableOption,
    QuietOption,
    TableOption,
    TimeOption,
    VerdictOption,
)
from lienumba.present.terminal import console


def plot(
    file: FileArgument,
    variables: Annotated[
        list[str] | None,
        typer.Argument(metavar="[VARIABLE]...", help="What to draw (default: what says most).", show_default=False),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FIGURE",
            help="A PNG, SVG or PDF file, replaced (default: FILE's stem with .png).",
        ),
    ] = None,
    against: Annotated[
        list[str] | None,
        typer.Option("--against", metavar="INPUT", help="Draw outputs over this input, run by run; may be repeated."),
    ] = None,
    convergence: Annotated[
        bool, typer.Option("--convergence", help="Draw how the means of outputs settle over the runs.")
    ] = False,
    requirement: Annotated[
        str | None,
        typer.Option("--requirement", metavar="NAME", help="Draw which inputs set apart the runs that fail it."),
    ] = None,
    sensitivity: Annotated[
        bool,
        typer.Option("--sensitivity", help="Draw what outputs depend on: Sobol' indices, or elementary effects."),
    ] = False,
    dark: Annotated[bool, typer.Option("--dark", help="Draw for a dark page.")] = False,
) -> None:
    """Draw a dataset: how its runs spread over the time; of a study, orders and work against precision; of modes their
    eigenvalues."""
    with console.exit_codes():
        from lienumba.figures.plots import figure, save
        from lienumba.store.files import reading
        from lienumba.store.linear_layout import MODES

        target = output if output is not None else Path(file.stem + ".png")
        asked: dict[str, Any] = {
            "names": variables or (), "against": against or (), "convergence": convergence,
            "requirement": requirement, "sensitivity": sensitivity, "dark": dark,
        }  # fmt: skip
        with reading(file, (MODES,)) as (dataset, _):
            save(lambda: figure(dataset, **asked), target)
        console.say(f"written to {target}")


def animate(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A dataset (.nc); with --mode also a scenario.", show_default=False)
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILM",
            help="A GIF or MP4 file, or a PNG, SVG or PDF of how it ends; replaced (default: FILE's stem with .gif).",
        ),
    ] = None,
    runs: Annotated[
        str | None,
        typer.Option("--run", metavar="LABELS", help="These runs, such as 3,17 or -1 (default: nominal, or typical)."),
    ] = None,
    worst: Annotated[
        str | None,
        typer.Option(
            "--worst",
            metavar="NAME",
            help="Beside it the run that misses it by most, or has the largest |NAME|.",
        ),
    ] = None,
    mode: Annotated[
        int | None,
        typer.Option(
            "--mode", metavar="N", help="This vibration mode over one period (default of a dataset of modes: 1)."
        ),
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option("--duration", metavar="S", help="How long it takes to watch in s (default: real time, 4 to 8 s)."),
    ] = None,
    fps: Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second.")] = 20,
    allow_code: AllowCodeOption = False,
    quiet: QuietOption = False,
) -> None:
    """Draw the mechanism in motion: bodies of equivalent inertia, joints, and the paths of mass centres; or one of its
    vibration modes."""
    with console.exit_codes():
        from lienumba.figures.animate import claimed_film, draw, one_run, runs_of
        from lienumba.scenario.resolve import resolve
        from lienumba.scene import mode_scene, scene
        from lienumba.store.files import reading
        from lienumba.store.linear_layout import MODES, is_modes

        target = output if output is not None else Path(file.stem + ".gif")
        with claimed_film(target) as own:
            labels, modes = runs_of(runs, worst), mode is not None
            if modes and file.suffix == ".toml":
                title = resolve(file, allow_code=allow_code).data.title
            else:
                with reading(file, (MODES,)) as (dataset, _):
                    modes, title = modes or is_modes(dataset), str(dataset.attrs.get("title", ""))
            if modes:
                chosen = 1 if mode is None else mode
                seen = mode_scene(file, modes=chosen, run=one_run(labels, worst), allow_code=allow_code)
                title = ": ".join(filter(None, [title, seen.runs[0].label]))
            else:
                with reading(file) as (dataset, where), console.progress(quiet) as report:
                    seen = scene(
                        dataset,
                        where,
                        count=1 if worst is None else 2,
                        runs=labels,
                        worst=worst,
                        allow_code=allow_code,
                        tell=report,
                    )
            if not quiet and not modes:
                console.print_warnings(list(seen.remarks))
            with console.drawing(quiet) as frame:
                draw(seen, own, title, fps, duration, frame)
        if not quiet:
            remark = "".join(f"; {sentence}" for sentence in seen.remarks if modes)
            console.say(f"written to {target}: {', '.join(run.label for run in seen.runs)}{remark}")


def report(
    file: DatasetArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="PAGE", help="An HTML file, replaced (default: DATASET's stem with .html)."
        ),
    ] = None,
    check: Annotated[
        int,
        typer.Option("--check", metavar="N", min=0, help="Recompute N runs by another engine, and show differences."),
    ] = 0,
    allow_code: AllowCodeOption = False,
    quiet: QuietOption = False,
) -> None:
    """Write a page about a dataset that opens anywhere, offline, with the mechanism moving."""
    with console.exit_codes():
        from lienumba.present.html import report

        target = output if output is not None else Path(f"{file.stem}.html")
        with console.progress(quiet) as tell:
            report(file, target, allow_code=allow_code, check=check, progress=tell)
        if not quiet:
            console.say(f"written to {target}, {target.stat().st_size / 1e6:.1f} MB; open it in a browser")


def analyse(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset of a sweep (.nc).", show_default=False)],
    outputs: OutputsArgument = None,
    time: TimeOption = None,
    output: TableOption = None,
    overwrite: OverwriteTableOption = False,
    verdict: VerdictOption = False,
) -> None:
    """Say whether requirements are met, and which inputs of a sweep an output depends on: rank correlations, a tornado,
    Sobol' indices."""
    with console.exit_codes():
        from lienumba.analysis.requirements.verdict import verdicts_of
        from lienumba.analysis.sensitivities import sensitivity_file
        from lienumba.analysis.sensitivities.sensitivity import sensitivity
        from lienumba.errors import ScenarioError
        from lienumba.present.terminal.sensitivity import print_sensitivity
        from lienumba.present.terminal.verdict import print_separations, print_verdicts
        from lienumba.store.files import reading
        from lienumba.store.linear_layout import MODES

        with ExitStack() as stack:
            if output is not None:
                own = stack.enter_context(sensitivity_file.claimed_findings(output, overwrite, file))
            dataset, _ = stack.enter_context(reading(file, (MODES,)))
            judged = verdicts_of(dataset)
            if verdict and not judged:
                raise ScenarioError("--verdict: the dataset has no requirements; its scenario has no [[requirements]]")
            with console.unheard():
                print_verdicts(dataset)  # which stand where nothing depends on anything, too
            alone = verdict and not outputs and output is None
            found = None if alone else sensitivity(dataset, outputs or (), time)
            if output is not None and found is not None:
                sensitivity_file.save(found, own)
            with console.unheard():
                if found is not None:
                    print_separations(dataset)
                    print_sensitivity(found)
                if output is not None:
                    console.say(f"written to {output}")
        if verdict and not all(x.met for x in judged):
            raise typer.Exit(console.NOT_MET)


def compare(
    first: Annotated[Path, typer.Argument(metavar="FIRST", help="A dataset of a sweep (.nc).", show_default=False)],
    second: Annotated[Path, typer.Argument(metavar="SECOND", help="Another, of another design.", show_default=False)],
    outputs: OutputsArgument = None,
    time: TimeOption = None,
    output: TableOption = None,
    overwrite: OverwriteTableOption = False,
) -> None:
    """Say what two sweeps differ in, run by run: what the scenarios differ in, and the outputs of equal samples."""
    with console.exit_codes():
        from lienumba.analysis.comparison import compare
        from lienumba.analysis.sensitivities import sensitivity_file
        from lienumba.present.terminal.comparison import print_comparison
        from lienumba.store.files import reading

        with ExitStack() as stack:
            if output is not None:
                own = stack.enter_context(sensitivity_file.claimed_findings(output, overwrite, first, second))
            with reading(first) as (one, _), reading(second) as (other, _):
                found = compare(one, other, outputs or (), time)
            if output is not None:
                sensitivity_file.save(found, own)
        with console.unheard():
            print_comparison(found, str(first), str(second))
            if output is not None:
                console.say(f"written to {output}")


def table(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset of runs (.nc).", show_default=False)],
    outputs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[OUTPUT]...",
            help="Such as tip, last_position.top.z or event_time.far (default: all that a run has once).",
            show_default=False,
        ),
    ] = None,
    time: TimeOption = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="TABLE",
            help="A .csv, .parquet or .mat file to write (default: FILE's stem with .csv).",
        ),
    ] = None,
    overwrite: OverwriteTableOption = False,
) -> None:
    """Write one row for each run: how it ended, its inputs, and the numbers that it has once."""
    with console.exit_codes():
        from lienumba.analysis.by_run import claimed_table, run_table, save
        from lienumba.store.files import reading
        from lienumba.store.linear_layout import MODES

        target = output if output is not None else Path(file.stem + ".csv")
        with claimed_table(target, overwrite) as own:
            with reading(file, (MODES,)) as (dataset, _):
                rows = run_table(dataset, outputs or (), time)
            save(rows, own)
        console.say(f"written to {target}: {len(rows):,} runs, {len(rows.columns)} columns")


def list_(
    folder: Annotated[
        Path, typer.Argument(metavar="[FOLDER]", help="Where datasets are (default: here).", show_default=False)
    ] = Path(),
    recursive: Annotated[bool, typer.Option("-r", "--recursive", help="Look also into the folders below.")] = False,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="TABLE", help="A CSV file to write, replaced.", show_default=False),
    ] = None,
) -> None:
    """Say which datasets there are: what they are of, how their runs ended, what they show of requirements."""
    with console.exit_codes():
        from lienumba.analysis.folder_index import index, remarks, save, table
        from lienumba.store.targets import claimed

        found = index(folder, recursive=recursive)
        with console.unheard():
            if len(found):
                console.wide_output(160).print(table(found).on_terminal())
            else:
                console.say(f"{folder}: has no dataset of lienumba")
            for line in remarks(found.attrs["skipped"]):
                console.say(line)
        if output is not None:
            with claimed(output, "table", (".csv",)) as own:
                save(found, own)
            console.say(f"written to {output}")
