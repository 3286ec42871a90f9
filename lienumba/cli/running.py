"""Commands that simulate: run, merge, replay."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from lienumba.cli.options import (
    AllowCodeOption,
    AllowScenarioCodeOption,
    DatasetArgument,
    OverwriteOption,
    QuietOption,
    RunsOption,
    ScenarioArgument,
    SeedOption,
    SetOption,
    VerdictOption,
)
from lienumba.present.terminal import console

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.scenario.resolve import Scenario


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
    engine: Annotated[
        Literal["numba"] | None,
        typer.Option(
            "--engine", help='"numba": by the paper\'s formulas in plain Numba, to check.', show_default=False
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
        bool,
        typer.Option("--resume", help="Go on with an interrupted sweep, or add runs to a finished one."),
    ] = False,
    allow_code: AllowScenarioCodeOption = False,
    overwrite: OverwriteOption = False,
    max_failures: Annotated[
        str,
        typer.Option(
            "--max-failures", metavar="N|P%", help="How many runs may fail before the exit code is 1, such as 10 or 5%."
        ),
    ] = "0",
    verdict: VerdictOption = False,
    yes: Annotated[bool, typer.Option("--yes", help="Begin a sweep of more than 10 GB without a question.")] = False,
    quiet: QuietOption = False,
) -> None:
    """Simulate every run of a scenario and write one dataset."""
    with console.exit_codes():
        from lienumba.engine.part import SweepPart
        from lienumba.errors import ScenarioError
        from lienumba.scenario.base.arguments import parse_assignments, parse_labels, parse_share
        from lienumba.scenario.resolve import resolve
        from lienumba.scenario.start.never import warnings_of

        suffix = "" if part is None else SweepPart.parse(part).suffix
        target = output if output is not None else Path(f"{scenario.stem}{suffix}.nc")
        overrides = parse_assignments(settings or []) | ({} if engine is None else {"integrator.engine": engine})
        resolved = resolve(scenario, overrides=overrides, seed=seed, allow_code=allow_code)
        labels = None if runs is None else parse_labels(runs, resolved.data.sweep.runs)
        allowed = parse_share(max_failures, "--max-failures ")
        if verdict and not resolved.data.model.requirements:
            raise ScenarioError("--verdict: the scenario has no requirements; write some as [[requirements]]")
        if not quiet:
            console.print_warnings(warnings_of(resolved))
            _ask_if_large(resolved, labels, yes)

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
        total, too_many = dataset["status"].size, failed > allowed(dataset["status"].size)
        if not quiet:
            with console.unheard():
                _tell(dataset, target)
        elif too_many:
            typer.echo(f"error: {failed} of {total} runs failed; lienumba info {target} says how", err=True)
        if verdict:
            _require(dataset, quiet)
        if too_many:
            raise typer.Exit(console.SOME_FAILED)


def _ask_if_large(resolved: "Scenario", labels: "list[int] | None", yes: bool) -> None:
    """A question before a sweep whose dataset nobody may want; where nobody can answer, a warning."""
    from lienumba.engine.quality import expected_size

    size = expected_size.expected_bytes(resolved, labels)
    if size < expected_size.LARGE:
        return
    rule = f"output: the dataset has about {size / 1e9:.0f} GB before compression"
    remedy = 'give a longer output.every, fewer output.variables, or output.mode = "summary"'
    console.print_warnings([f"{rule}; {remedy}"])
    if not yes and _answers() and not typer.confirm("begin?"):
        raise typer.Exit(console.BAD_INPUT)


def _answers() -> bool:
    """Whether a person sits there."""
    import sys

    return sys.stdin.isatty()


def merge(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="Datasets of parts of a sweep.", show_default=False)
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The dataset to write.", show_default=False)
    ],
    allow_code: AllowCodeOption = False,
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
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


def replay(
    file: DatasetArgument,
    run: Annotated[
        int | None, typer.Option("--run", metavar="N", help="The label of the run.", show_default=False)
    ] = None,
    worst: Annotated[
        str | None,
        typer.Option("--worst", metavar="NAME", help="The run that misses it by most, or has the largest |NAME|."),
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
    overwrite: OverwriteOption = False,
    quiet: QuietOption = False,
) -> None:
    """Simulate one run of a dataset again, alone, with its whole course."""
    with console.exit_codes():
        from lienumba.engine.replay import again, warnings_of
        from lienumba.engine.select_run import select_run
        from lienumba.store.files import reading
        from lienumba.store.outputs import write
        from lienumba.store.targets import claimed_dataset

        with reading(file) as (dataset, where):
            choice = select_run(dataset, where, run, worst)
            target = output if output is not None else Path(f"{file.stem}.run{choice.run}.nc")
            with claimed_dataset(target, overwrite, resumable=False) as own:
                if not quiet:
                    console.print_warnings(warnings_of(dataset, where))
                with console.progress(quiet) as report:
                    done = again(dataset, where, choice.run, every, allow_code, report)
                write(done.dataset, own)
        if not done.same:
            console.print_warnings([done.sentence])
        if not quiet:
            with console.unheard():
                console.print_replay(done, choice.sentence, target)
        if not done.same:
            raise typer.Exit(console.SOME_FAILED)


def _tell(dataset: "xr.Dataset", target: Path) -> None:
    """Print what came out."""
    from lienumba.store.study_layout import is_study

    if not is_study(dataset):
        from lienumba.analysis.summary import summarise
        from lienumba.present.terminal.verdict import print_verdicts

        print_verdicts(dataset)
        console.print_summary(summarise(dataset), target)
        return
    from lienumba.engine.study import doubts
    from lienumba.present.terminal.study import print_study

    console.print_warnings(doubts(dataset))
    print_study(dataset, target)


def _require(dataset: "xr.Dataset", quiet: bool) -> None:
    """End with an exit code of its own where a requirement is not met for sure."""
    from lienumba.analysis.requirements.verdict import verdicts_of

    open_ = [x for x in verdicts_of(dataset) if not x.met]
    for x in open_ if quiet else ():
        console.say(f"error: {x.sentence()}", err=True)
    if open_:
        raise typer.Exit(console.NOT_MET)
