"""The command line: run, merge, replay, sample, validate, info, plot, animate, report, analyse, schema, doctor.

Exit codes: 0 all runs good; 1 finished, some runs failed, or a replay is another run; 2 bad input, nothing computed;
130 interrupted, resumable.
Heavy modules are imported inside the commands: `--help` and `validate` must answer at once.
"""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lienumba.present.terminal import console

if TYPE_CHECKING:
    import xarray as xr

app = typer.Typer(
    name="lienumba",
    help="Monte-Carlo simulation of rigid multibody systems: a TOML scenario in, one netCDF file out.",
    epilog="Start with: lienumba run scenarios/heavy_top.toml",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

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
SeedOption = Annotated[int | None, typer.Option("--seed", help="Replace sweep.seed.", show_default=False, metavar="N")]


def _version(wanted: bool) -> None:
    if wanted:
        from lienumba import __version__

        typer.echo(f"lienumba {__version__}")
        raise typer.Exit()


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass


@app.command()
def run(
    scenario: ScenarioArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="The dataset to write (default: SCENARIO's stem with .nc)."
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "-j", "--workers", metavar="N", min=1, help="Threads, or processes of --dask local (default: one per core)."
        ),
    ] = None,
    seed: SeedOption = None,
    settings: SetOption = None,
    runs: RunsOption = None,
    part: Annotated[
        str | None,
        typer.Option("--part", metavar="K/N", help="Only the K-th of N parts of these runs, such as 3/20."),
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option("--dask", metavar="WHERE", help='On a cluster: the address of its scheduler, or "local".'),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with an interrupted sweep, or add runs to a finished one.")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing dataset.")] = False,
    max_failures: Annotated[
        str,
        typer.Option(
            "--max-failures", metavar="N|P%", help="How many runs may fail before the exit code is 1, such as 10 or 5%."
        ),
    ] = "0",
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
) -> None:
    """Simulate every run of a scenario and write one dataset."""
    with console.exit_codes():
        from lienumba.engine.part import Part
        from lienumba.scenario.base.arguments import parse_assignments, parse_labels, parse_share
        from lienumba.scenario.resolve import resolve
        from lienumba.store.targets import check_dataset_target

        suffix = "" if part is None else Part.parse(part).suffix
        target = output if output is not None else Path(f"{scenario.stem}{suffix}.nc")
        resolved = resolve(scenario, overrides=parse_assignments(settings or []), seed=seed)
        labels = None if runs is None else parse_labels(runs, resolved.data.sweep.runs)
        allowed = parse_share(max_failures, "--max-failures ")
        check_dataset_target(target, overwrite, resume)
        if not quiet:
            console.print_warnings(resolved.warnings)

        from lienumba.batch.statuses import GOOD
        from lienumba.engine import runner

        with console.progress(quiet) as report:
            dataset = runner.run(
                resolved,
                output=target,
                workers=workers,
                runs=labels,
                part=part,
                resume=resume,
                overwrite=overwrite,
                dask=dask,
                progress=report,
            )
        failed = int((~dataset["status"].isin(GOOD)).sum())
        if not quiet:
            with console.unheard():
                _tell(dataset, target)
        if failed > allowed(dataset["status"].size):
            raise typer.Exit(console.SOME_FAILED)


@app.command()
def merge(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="Datasets of parts of a sweep.", show_default=False)
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The dataset to write.", show_default=False)
    ],
    allow_code: AllowCodeOption = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing dataset.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
) -> None:
    """Make one dataset of those of the parts of a sweep."""
    with console.exit_codes():
        from lienumba.engine.disk.merge import gaps, merged

        with console.progress(quiet) as report:
            dataset = merged(files, output, allow_code, overwrite, report)
        if not quiet:
            console.print_warnings(gaps(dataset))
            with console.unheard():
                _tell(dataset, output)


def _tell(dataset: "xr.Dataset", target: Path) -> None:
    """Print what came out."""
    from lienumba.store.study_layout import is_study

    if not is_study(dataset):
        from lienumba.analysis.summary import summarise

        console.print_summary(summarise(dataset), target)
        return
    from lienumba.engine.study import doubts
    from lienumba.present.terminal.study import print_study

    console.print_warnings(doubts(dataset))
    print_study(dataset, target)


@app.command()
def replay(
    file: Annotated[Path, typer.Argument(metavar="DATASET", help="A dataset (.nc).", show_default=False)],
    run: Annotated[
        int | None, typer.Option("--run", metavar="N", help="The label of the run.", show_default=False)
    ] = None,
    worst: Annotated[
        str | None,
        typer.Option("--worst", metavar="NAME", help="The run with the largest |NAME|, such as pointing.angle."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="The dataset to write (default: DATASET's stem.runN.nc)."),
    ] = None,
    every: Annotated[
        float | None,
        typer.Option("--every", metavar="DT", help="Interval between stored times in s (default: every step)."),
    ] = None,
    allow_code: AllowCodeOption = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing dataset.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
) -> None:
    """Simulate one run of a dataset again, alone, with its whole course."""
    with console.exit_codes():
        from lienumba.engine.replay import again, warnings_of
        from lienumba.engine.select_run import select_run
        from lienumba.store.files import read, write
        from lienumba.store.targets import check_dataset_target

        with read(file) as dataset:
            choice = select_run(dataset, str(file), run, worst)
            target = output if output is not None else Path(f"{file.stem}.run{choice.run}.nc")
            check_dataset_target(target, overwrite, resumable=False)
            if not quiet:
                console.print_warnings(warnings_of(dataset, str(file)))
            with console.progress(quiet) as report:
                done = again(dataset, str(file), choice.run, every, allow_code, report)
        write(done.dataset, target)
        if not done.same:
            console.print_warnings([done.sentence])
        if not quiet:
            with console.unheard():
                console.print_replay(done, choice.sentence, target)
        if not done.same:
            raise typer.Exit(console.SOME_FAILED)


@app.command()
def sample(
    scenario: ScenarioArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="The table to write, .csv or .nc (default: SCENARIO's stem with .samples.csv).",
        ),
    ] = None,
    seed: SeedOption = None,
    settings: SetOption = None,
    runs: RunsOption = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing table.")] = False,
) -> None:
    """Draw the samples of a sweep and write them as a table, without running anything."""
    with console.exit_codes():
        from lienumba.scenario.base.arguments import parse_assignments, parse_labels
        from lienumba.scenario.resolve import resolve
        from lienumba.scenario.start.samples_file import check_samples_target, sample

        target = output if output is not None else Path(scenario.stem + ".samples.csv")
        resolved = resolve(scenario, overrides=parse_assignments(settings or []), seed=seed)
        labels = resolved.labels if runs is None else parse_labels(runs, resolved.data.sweep.runs)
        check_samples_target(target, overwrite)
        console.print_warnings(resolved.warnings)
        statistics = sample(resolved, labels, target)

        from lienumba.present.terminal.samples import print_samples

        with console.unheard():
            print_samples(statistics, len(labels), target)


@app.command()
def validate(scenario: ScenarioArgument, settings: SetOption = None, seed: SeedOption = None) -> None:
    """Check a scenario and its initial state without running it."""
    with console.exit_codes():
        from lienumba.scenario.base.arguments import parse_assignments
        from lienumba.scenario.resolve import resolve

        resolved = resolve(scenario, overrides=parse_assignments(settings or []), seed=seed)
        console.print_warnings(resolved.warnings)

        from lienumba.scenario.start.study_start import check

        check(resolved)
        typer.echo(f"{scenario} is valid: {resolved.headline()}")


@app.command()
def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset (.nc) or a scenario (.toml).")],
    cite: Annotated[
        bool, typer.Option("--cite", help="Print a paragraph for a section on methods, and BibTeX, instead.")
    ] = False,
) -> None:
    """Say what a dataset or a scenario holds."""
    with console.exit_codes():
        from lienumba.present import info

        typer.echo(info.cite(file) if cite else info.describe(file))


@app.command()
def plot(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset (.nc).", show_default=False)],
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
) -> None:
    """Draw a dataset: how its runs spread over the time; of a study, orders and work against precision."""
    with console.exit_codes():
        from lienumba.figures.plots import save
        from lienumba.store.files import read

        target = output if output is not None else Path(file.stem + ".png")
        with read(file) as dataset:
            save(dataset, target, variables or ())
        typer.echo(f"written to {target}")


@app.command()
def animate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset (.nc).", show_default=False)],
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
        typer.Option("--worst", metavar="NAME", help="Beside it the run with the largest |NAME|, such as tip."),
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option("--duration", metavar="S", help="How long it takes to watch in s (default: real time, 4 to 8 s)."),
    ] = None,
    fps: Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second.")] = 20,
    allow_code: AllowCodeOption = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
) -> None:
    """Draw the mechanism in motion: bodies of equivalent inertia, joints, and the paths of mass centres."""
    with console.exit_codes():
        from lienumba.figures.animate import animate, check_film, runs_of
        from lienumba.scene import scene
        from lienumba.store.files import read

        target = output if output is not None else Path(file.stem + ".gif")
        check_film(target)
        with read(file) as dataset:
            labels = runs_of(runs, worst)
            with console.progress(quiet) as report:
                seen = scene(
                    dataset,
                    str(file),
                    count=1 if worst is None else 2,
                    runs=labels,
                    worst=worst,
                    allow_code=allow_code,
                    tell=report,
                )
            title = str(dataset.attrs.get("title", ""))
        if not quiet:
            console.print_warnings(list(seen.remarks))
        with console.drawing(quiet) as frame:
            animate(seen, target, title=title, fps=fps, duration=duration, progress=frame)
        if not quiet:
            typer.echo(f"written to {target}: {', '.join(run.label for run in seen.runs)}")


@app.command()
def report(
    file: Annotated[Path, typer.Argument(metavar="DATASET", help="A dataset (.nc).", show_default=False)],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="PAGE", help="An HTML file, replaced (default: DATASET's stem with .html)."
        ),
    ] = None,
    allow_code: AllowCodeOption = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
) -> None:
    """Write a page about a dataset that opens anywhere, offline, with the mechanism moving."""
    with console.exit_codes():
        from lienumba.present.html import report

        target = output if output is not None else Path(f"{file.stem}.html")
        with console.progress(quiet) as tell:
            report(file, target, allow_code=allow_code, progress=tell)
        if not quiet:
            typer.echo(f"written to {target}, {target.stat().st_size / 1e6:.1f} MB; open it in a browser")


@app.command()
def analyse(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset of a sweep (.nc).", show_default=False)],
    outputs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[OUTPUT]...",
            help="Such as tip, position.top.z, event_time.far or failed (default: what says most).",
            show_default=False,
        ),
    ] = None,
    time: Annotated[
        float | None,
        typer.Option(
            "--time", metavar="T", help="The stored time of series, in s (default: the last).", show_default=False
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="TABLE", help="A CSV or netCDF file to write.", show_default=False),
    ] = None,
) -> None:
    """Say which inputs of a sweep an output depends on: rank correlations, a tornado, Sobol' indices."""
    with console.exit_codes():
        from lienumba.analysis.sensitivities import sensitivity_file
        from lienumba.analysis.sensitivities.sensitivity import sensitivity
        from lienumba.present.terminal.sensitivity import print_sensitivity
        from lienumba.store.files import read
        from lienumba.store.targets import CHOOSE, check_target

        if output is not None:
            check_target(output, "table", sensitivity_file.ENDINGS, f"{CHOOSE}, or delete it")
        with read(file) as dataset:
            found = sensitivity(dataset, outputs or (), time)
        if output is not None:
            sensitivity_file.save(found, output)
        with console.unheard():
            print_sensitivity(found)
            if output is not None:
                typer.echo(f"written to {output}")


@app.command()
def schema() -> None:
    """Print the JSON schema of scenarios, for editors and other tools."""
    with console.exit_codes():
        import json

        from lienumba.scenario.schema.scenario import json_schema

        typer.echo(json.dumps(json_schema(), indent=2, ensure_ascii=False))


@app.command()
def doctor() -> None:
    """Show versions, CPU and cache, and run a short self-test."""
    with console.exit_codes():
        from lienumba.present.doctor import environment, self_test

        typer.echo(environment())
        passed, sentence = self_test()
        typer.echo(sentence)
        if not passed:
            raise typer.Exit(console.SOME_FAILED)


def main() -> None:
    """The entry point of the command `lienumba`."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its matrices are small: threads would only wait for each other
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a title may hold what this terminal's encoding cannot show
    app()
