"""Memory is bounded by what is stored and in flight, not by steps, and not by runs beside what they store."""

import json
import subprocess
import sys
from typing import Any

import pytest

from .sweeps import ROOT

SCRIPT = """
import json, resource, sys
import lienumba
data = json.loads(sys.argv[1])
dataset = lienumba.run(data, workers=2)
assert (dataset["status"] == 0).all()
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, dataset.nbytes)
"""
MEBIBYTE = 2**20


def peak(overrides: dict[str, Any]) -> tuple[float, float]:
    """Peak resident memory of a process and the size of its dataset, in MiB."""
    from lienumba.scenario.loading import apply_overrides, load

    data = load(ROOT / "scenarios" / "heavy_top_monte_carlo.toml")
    assert not apply_overrides(data, overrides)
    done = subprocess.run([sys.executable, "-c", SCRIPT, json.dumps(data)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    resident, dataset = map(int, done.stdout.split())
    return resident * 1024 / MEBIBYTE if sys.platform == "linux" else resident / MEBIBYTE, dataset / MEBIBYTE


pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no resource module")
SMALL = {"sweep.runs": 400, "integrator.end_time": 1.0, "output.every": 0.01}


def test_ten_times_the_steps_cost_no_memory() -> None:
    few, _ = peak({**SMALL, "integrator.step": 1e-3})
    many, _ = peak({**SMALL, "integrator.step": 1e-4})
    assert many < few + 10


def test_memory_grows_with_what_is_stored_only() -> None:
    """A hundred times as much computed with four outputs costs what four outputs cost."""
    base, _ = peak({**SMALL, "sweep.runs": 8, "output.every": 0.25})
    long, stored = peak({**SMALL, "sweep.runs": 4000, "output.every": 0.25})
    assert stored < 10
    assert long < base + 5 * stored + 20


def test_the_stored_output_is_held_once_beside_the_chunks_in_flight() -> None:
    base, _ = peak({**SMALL, "sweep.runs": 8})
    full, stored = peak({**SMALL, "sweep.runs": 4000, "output.every": 0.005})
    assert stored > 200
    assert full < base + 1.25 * stored + 100
