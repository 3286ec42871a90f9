"""Commands about what is asked for: sample, validate, check, info, schema, doctor."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from lienumba.cli.options import (
    AllowScenarioCodeOption,
    OverwriteTableOption,
    QuietOption,
    RunsOption,
    ScenarioArgument,
    SeedOption,
    SetOption,
)
from lienumba.present.terminal import console


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
    allow_code: AllowScenarioCodeOption = False,
    overwrite: OverwriteTableOption = False,
) -> None:
    """Draw the samples of a sweep and write them as a table, without running anything."""
    with console.exit_codes():
        from lienumba.scenario.base.arguments import parse_assignments, parse_labels
        from lienumba.scenario.resolve import resolve
        from lienumba.scenario.start.never import warnings_of
        from lienumba.scenario.start.samples_file import claimed_samples, sample

        target = output if output is not None else Path(scenario.stem + ".samples.csv")
        resolved = resolve(scenario, overrides=parse_assignments(settings or []), seed=seed, allow_code=allow_code)
        labels = resolved.labels if runs is None else parse_labels(runs, resolved.data.sweep.runs)
        with claimed_samples(target, overwrite) as own:
            console.print_warnings(warnings_of(resolved))
            statistics = sample(resolved, labels, own)

        from lienumba.present.terminal.samples import print_samples

        with console.unheard():
            print_samples(statistics, len(labels), resolved.weighted, target)


def validate(
    scenario: ScenarioArgument,
    settings: SetOption = None,
    seed: SeedOption = None,
    allow_code: AllowScenarioCodeOption = False,
) -> None:
    """Check a scenario and its initial state, and try its Python laws, without running it."""
    with console.exit_codes():
        from lienumba.scenario.base.arguments import parse_assignments
        from lienumba.scenario.resolve import resolve
        from lienumba.scenario.start.never import warnings_of

        resolved = resolve(scenario, overrides=parse_assignments(settings or []), seed=seed, allow_code=allow_code)
        console.print_warnings(warnings_of(resolved))

        from lienumba.scenario.start.hint import RESTS, hint
        from lienumba.scenario.start.study_start import check_starts

        nominal = check_starts(resolved)
        model, output = resolved.data.model, resolved.data.output
        named = model.requirements or model.measures or output.summary or output.at_events or resolved.data.sweep.stop
        if nominal is not None and named:  # of what the dataset will have
            from lienumba.engine.results import Results
            from lienumba.engine.stopping import stopping_of

            stopping_of(resolved, Results(resolved, nominal))
        console.say(f"{scenario} is valid: {resolved.headline()}")
        if nominal is not None and nominal.rests is not None:
            console.say(RESTS[nominal.rests])
        if nominal is not None and (told := hint(nominal)):
            console.say(f"hint: {told}")


def check(
    source: Annotated[
        Path, typer.Argument(metavar="FILE", help="A scenario (.toml) or a dataset (.nc).", show_default=False)
    ],
    runs: Annotated[int, typer.Option("--runs", metavar="N", min=1, help="How many runs, the first ones.")] = 8,
    steps: Annotated[int, typer.Option("--steps", metavar="N", min=1, help="How many steps of each.")] = 200,
    by: Annotated[
        Literal["numba", "mujoco"],
        typer.Option("--with", help='"numba": the paper\'s formulas in plain Numba; "mujoco": trees under gravity.'),
    ] = "numba",
    settings: SetOption = None,
    allow_code: AllowScenarioCodeOption = False,
    quiet: QuietOption = False,
) -> None:
    """Simulate the same samples by another engine, and print the largest differences."""
    with console.exit_codes():
        if by == "mujoco":
            from lienumba.engine.checks.mujoco import check as compared
        else:
            from lienumba.engine.checks.engines import check as compared
        from lienumba.scenario.base.arguments import parse_assignments

        overrides = parse_assignments(settings or [])
        with console.progress(quiet) as report:
            found = compared(source, runs, steps, report, overrides, allow_code)

        from lienumba.present.terminal.check import print_check

        if not quiet:
            with console.unheard():
                print_check(found)
        if not found.agrees:
            raise typer.Exit(console.SOME_FAILED)


def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A dataset (.nc) or a scenario (.toml).")],
    cite: Annotated[
        bool,
        typer.Option("--cite", help="Print BibTeX entries of what to cite instead."),
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Of a scenario: also the operations of its kernels.")
    ] = False,
    allow_code: AllowScenarioCodeOption = False,
) -> None:
    """Say what a dataset or a scenario holds."""
    with console.exit_codes():
        from lienumba.present import info

        console.say(info.cite(file, allow_code) if cite else info.describe(file, allow_code, verbose))


def schema() -> None:
    """Print the JSON schema of scenarios, for editors and other tools."""
    with console.exit_codes():
        import json

        from lienumba.scenario.schema.json_schema import json_schema

        console.say(json.dumps(json_schema(), indent=2, ensure_ascii=False))


def doctor() -> None:
    """Show versions, CPU and cache, and run a short self-test."""
    with console.exit_codes():
        from lienumba.present.doctor import environment, self_test

        console.say(environment())
        passed, sentence = self_test()
        console.say(sentence)
        if not passed:
            raise typer.Exit(console.SOME_FAILED)
