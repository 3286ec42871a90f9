"""How a process begins: `lienumba run` leaves alone what it does not need."""

import json
import subprocess
import sys
from pathlib import Path

from tests.rigs.places import ROOT

LOADED = """
import json
import sys
from lienumba.cli import main
for words in json.loads(sys.argv.pop()):
    sys.argv[1:] = words
    try:
        main()
    except SystemExit as end:
        assert not end.code, end.code
    heavy = ("dask", "distributed", "scipy", "matplotlib", "numba")
    print(words[-1], [name for name in heavy if sys.modules.get(name)])
"""
SETTINGS = ("integrator.step=1e-3", "integrator={method = 'dp54', tolerance = 1e-6, end_time = 0.1}", "sweep.runs=20")


def loaded(*commands: list[str]) -> list[str]:
    """The last word of each command, and what the process that does one after the other has loaded after it."""
    command = [sys.executable, "-c", LOADED, json.dumps(commands)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    return done.stdout.splitlines()


def test_warm_runs_load_neither_numba_nor_a_cluster_nor_figures(tmp_path: Path) -> None:
    """The first ones may have to compile."""
    run = ["run", "scenarios/heavy_top.toml", "-q", "--overwrite", "-o", str(tmp_path / "top.nc")]
    short = ["--set", "integrator.end_time=0.1", "--set"]
    commands = [[*run, *short, settings] for settings in SETTINGS]
    loaded(*commands)
    assert loaded(*commands) == [f"{settings} []" for settings in SETTINGS]
