"""Memory is bounded by what is stored and in flight, not by steps, and not by runs beside what they store."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.rigs.places import SCENARIOS

SCRIPT = """
import json, resource, sys
import lienumba
data = json.loads(sys.argv[1])
dataset = lienumba.run(data, workers=2, output=sys.argv[2] if len(sys.argv) > 2 else None)
assert (dataset["status"] == 0).all()
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, dataset.nbytes)
"""
MEBIBYTE = 2**20


def peak(overrides: dict[str, Any], *output: Path) -> tuple[float, float]:
    """Peak resident memory of a process and the size of its dataset, in MiB; output: where that is written."""
    from lienumba.scenario.reading.loading import apply_overrides, load

    data = load(SCENARIOS / "heavy_top_monte_carlo.toml")
    assert not apply_overrides(data, overrides)
    command = [sys.executable, "-c", SCRIPT, json.dumps(data), *map(str, output)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    resident, dataset = map(int, done.stdout.split())
    return resident * 1024 / MEBIBYTE if sys.platform == "linux" else resident / MEBIBYTE, dataset / MEBIBYTE


pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no resource module")
SMALL = {"sweep.runs": 100, "integrator.step": 1e-3, "integrator.end_time": 1.0, "output.every": 0.01}
LONG = {**SMALL, "output.every": 0.005}


@pytest.fixture(scope="module")
def base() -> float:
    """What a small sweep takes."""
    return peak(SMALL)[0]


@pytest.mark.release
def test_ten_times_the_steps_cost_no_memory(base: float) -> None:
    many, _ = peak({**SMALL, "integrator.step": 1e-4})
    assert many < base + 10


def test_memory_grows_with_what_is_stored_only(base: float) -> None:
    """A hundred times as much computed with four outputs costs what four outputs cost."""
    long, stored = peak({**SMALL, "sweep.runs": 4000, "output.every": 0.25})
    assert stored < 10
    assert long < base + 5 * stored + 20


def test_the_stored_output_is_held_once_beside_the_chunks_in_flight(base: float) -> None:
    full, stored = peak({**LONG, "sweep.runs": 4000})
    assert stored > 200
    assert full < base + 1.25 * stored + 100


@pytest.mark.release
def test_what_is_written_is_never_in_memory(tmp_path: Path) -> None:
    """Beyond what is in flight, which both have."""
    some, few = peak({**LONG, "sweep.runs": 1500}, tmp_path / "some.nc")
    full, stored = peak({**LONG, "sweep.runs": 3500}, tmp_path / "full.nc")
    assert stored > few + 100
    assert full < some + 50


@pytest.mark.release
def test_many_runs_of_summaries(tmp_path: Path) -> None:
    """2.5 KiB for each, beside what numba, xarray and scipy take, and compiling before."""
    short = {"integrator.end_time": 0.02, "output.every": 0.01, "output.mode": "summary"}
    few, _ = peak({"sweep.runs": 100, **short}, tmp_path / "few.nc")
    many, _ = peak({"sweep.runs": 40_000, **short}, tmp_path / "many.nc")
    assert many < few + 100
