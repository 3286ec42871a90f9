"""The command line: run, merge, replay, budget, rare, worst, equilibrium, modes, sample, validate, check, info, plot,
animate, report, analyse, compare, table, list, import, schema, doctor.

Exit codes: 0 all runs good; 1 finished, some runs failed, a replay is another run, or engines do not agree; 2 bad
input, nothing computed; 4 with --verdict, where runs do not show that all requirements are met; 130 interrupted,
resumable.
Heavy modules are imported inside the commands: `--help` and `validate` must answer at once.
"""

import gc
import os
import signal
import sys
from typing import Annotated

import typer

from lienumba.cli.budget import budget
from lienumba.cli.checking import check, doctor, info, sample, schema, validate
from lienumba.cli.commands import Command, Group
from lienumba.cli.importing import import_
from lienumba.cli.linear import equilibrium, modes
from lienumba.cli.rare import rare, worst
from lienumba.cli.running import merge, replay, run
from lienumba.cli.showing import analyse, animate, compare, list_, plot, report, table
from lienumba.present.terminal.console import hush

app = typer.Typer(
    cls=Group,
    name="lienumba",
    help="Monte-Carlo simulation of rigid multibody systems: a TOML scenario in, one netCDF file out.",
    epilog="Start with: lienumba run scenarios/heavy_top.toml",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        from lienumba import __version__

        typer.echo(f"lienumba {__version__}")
        raise typer.Exit()


@app.callback()
def _main(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit."),
    ] = False,
) -> None:
    pass


COMPUTING = (run, merge, replay, budget, rare, worst, equilibrium, modes, sample)
SHOWING = (plot, animate, report, analyse, compare, table)
for command in (*COMPUTING, validate, check, info, *SHOWING, schema, doctor):
    app.command(cls=Command)(command)
app.command("import", cls=Command)(import_)
app.command("list", cls=Command)(list_)


def main() -> None:
    """The entry point of the command `lienumba`."""
    gc.set_threshold(1_000_000)  # what is imported stays: looking for cycles in it takes a fifth of a short command
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its matrices are small: threads would only wait for each other
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # to look for them reads every installed package
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a title may hold what this terminal's encoding cannot show
    if sys.argv[1:2] == ["run"] and not any(word.startswith("--dask") for word in sys.argv):
        # xarray would import it, which takes a quarter of a second, to ask whether arrays of NumPy are dask's
        sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    try:
        app()
    finally:
        hush()
        for number in (signal.SIGINT, signal.SIGTERM):  # what ends Python itself says nothing of an interrupt
            signal.signal(number, signal.SIG_DFL)
