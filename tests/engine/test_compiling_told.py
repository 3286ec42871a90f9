"""Compiling is told where something is compiled, and nowhere else."""

import subprocess
import sys
from pathlib import Path

from tests.rigs.places import ROOT

RUNS = """
import os, sys
import lienumba
from lienumba.compiler import cache
from lienumba.integrators.tracing.compiled import PROGRAMS

def stages(**more):
    events = []
    settings = {"integrator.end_time": 0.01, "output.every": 0.01, **more}
    lienumba.run("scenarios/heavy_top.toml", overrides=settings, progress=events.append)
    assert events[0].stage == "prepare"
    return list(dict.fromkeys(event.stage for event in events))[1:]

stages()  # loads the driver
os.environ["LIENUMBA_CACHE_DIR"] = sys.argv[1]
cache.folder.cache_clear()
PROGRAMS.clear()
print(stages(), stages(), stages(**{"bodies.top.mass": 14.0}))
PROGRAMS.clear()
print(stages())  # from the disk
"""


def test_compiling_is_told_where_something_is_compiled(tmp_path: Path) -> None:
    command = [sys.executable, "-c", RUNS, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.splitlines() == ["['compile', 'run'] ['run'] ['run']", "['run']"]
