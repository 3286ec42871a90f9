"""How a process begins: `lienumba run` leaves alone what it does not need."""

import subprocess
import sys
from pathlib import Path

from tests.rigs.places import ROOT

LOADED = """
import sys
from lienumba.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
print([name for name in ("dask", "distributed", "scipy.stats", "matplotlib") if sys.modules.get(name)])
"""


def loaded(*words: str) -> str:
    done = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, cwd=ROOT, check=True)
    return done.stdout.splitlines()[-1]


def test_a_run_loads_neither_a_cluster_nor_statistics_nor_figures(tmp_path: Path) -> None:
    words = [
        "run",
        "scenarios/heavy_top.toml",
        "-q",
        "-o",
        str(tmp_path / "top.nc"),
        "--set",
        "integrator.end_time=0.1",
    ]
    assert loaded(*words) == "[]"
