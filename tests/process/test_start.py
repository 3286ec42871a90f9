"""How a process begins: `lienumba run` leaves alone what it does not need."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.rigs.places import ROOT

LOADED = """
import sys
from lienumba.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
print([name for name in ("dask", "distributed", "scipy", "matplotlib", "numba") if sys.modules.get(name)])
"""


def loaded(*words: str) -> str:
    done = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, cwd=ROOT, check=True)
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize(
    "settings", [(), ("integrator={method = 'dp54', tolerance = 1e-6, end_time = 0.1}",), ("sweep.runs=20",)]
)
def test_a_warm_run_loads_neither_numba_nor_a_cluster_nor_figures(tmp_path: Path, settings: tuple[str, ...]) -> None:
    """The first one may have to compile."""
    given = [word for setting in ("integrator.end_time=0.1", *settings) for word in ("--set", setting)]
    words = ["run", "scenarios/heavy_top.toml", "-q", "--overwrite", "-o", str(tmp_path / "top.nc"), *given]
    loaded(*words)
    assert loaded(*words) == "[]"
