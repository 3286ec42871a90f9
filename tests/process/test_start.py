"""How a process begins: `lienumba run` leaves alone what it does not need."""

import json
import os
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


def loaded(*commands: list[str], cache: Path) -> list[str]:
    """The last word of each command, and what the process that does one after the other has loaded after it."""
    command = [sys.executable, "-c", LOADED, json.dumps(commands)]
    own = {"LIENUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True, env=os.environ | own)
    return done.stdout.splitlines()


def test_runs_load_neither_numba_nor_a_cluster_nor_figures(tmp_path: Path) -> None:
    """Not even the first ones ever, which have everything to compile."""
    run = ["run", "scenarios/heavy_top.toml", "-q", "--overwrite", "-o", str(tmp_path / "top.nc")]
    short = ["--set", "integrator.end_time=0.1", "--set"]
    commands = [[*run, *short, settings] for settings in SETTINGS]
    assert loaded(*commands, cache=tmp_path / "cache") == [f"{settings} []" for settings in SETTINGS]
