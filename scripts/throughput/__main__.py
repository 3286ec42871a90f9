"""How much of the cores goes into integrating where results are stored: python -m throughput [RUNS]

Each case is a process of its own. kernels: the time that threads spend in the driver, of all cores and the whole time
between preparing the first run and the dataset that is closed; memory: the largest that was resident.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

SCENARIO = Path(__file__).parents[2] / "scenarios" / "heavy_top_monte_carlo.toml"
STATE = ["position", "rotation", "velocity", "angular_velocity"]
SUMMARY = {"output.mode": "summary", "output.summary": {"position": ["max", "rms"]}}
FINE = {"integrator.step": 1e-4}
CASES: dict[str, tuple[int, bool, dict[str, Any]]] = {
    "10,000 runs, 2,000 steps, nothing stored": (10_000, False, SUMMARY),
    "10,000 runs, 2,000 steps, summaries": (10_000, True, SUMMARY),
    "10,000 runs, 2,000 steps, positions at 201 times": (10_000, True, {"output.variables": ["position"]}),
    "10,000 runs, 2,000 steps, all variables at 201 times": (10_000, True, {}),
    "10,000 runs, 20,000 steps, nothing stored": (10_000, False, SUMMARY | FINE),
    "10,000 runs, 20,000 steps, summaries": (10_000, True, SUMMARY | FINE),
    "10,000 runs, 20,000 steps, positions at 201 times": (10_000, True, {"output.variables": ["position"]} | FINE),
    "10,000 runs, 20,000 steps, states at 201 times": (10_000, True, {"output.variables": STATE} | FINE),
    "10,000 runs, 20,000 steps, all variables at 201 times": (10_000, True, FINE),
    "100,000 runs, 2,000 steps, summaries": (100_000, True, SUMMARY),
    "1,000,000 runs, 2,000 steps, summaries": (1_000_000, True, SUMMARY),
}


def measure(name: str) -> dict[str, float]:
    """One case, in this process."""
    import lienumba
    from lienumba.batch import execute

    runs, stored, settings = CASES[name]
    settings = {"output.every": 0.01, **settings}
    busy, integrate = [0.0], execute.integrate

    def timed(*arguments: Any) -> Any:
        chunk = integrate(*arguments)
        busy[0] += chunk.seconds
        return chunk

    lienumba.run(SCENARIO, overrides=settings | {"sweep.runs": 8})  # everything is compiled and imported
    execute.integrate = timed
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "out.nc"
        began = time.perf_counter()
        lienumba.run(SCENARIO, overrides=settings | {"sweep.runs": runs}, output=target if stored else None).close()
        seconds = time.perf_counter() - began
        size = target.stat().st_size if stored else 0
    cores = len(os.sched_getaffinity(0))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {
        "runs per s": runs / seconds, "seconds": seconds, "kernels": busy[0] / seconds / cores, "memory": peak,
        "file": size / 1e6,
    }  # fmt: skip


def main(chosen: list[str]) -> None:
    print("| | s | runs/s | of the cores in kernels | memory | file |\n|---|---|---|---|---|---|")
    for name in CASES:
        if chosen and not any(part in name for part in chosen):
            continue
        line = [sys.executable, "-m", "throughput", "--case", name]
        found = json.loads(subprocess.run(line, check=True, capture_output=True, text=True).stdout)
        file = f"{found['file']:,.0f} MB" if found["file"] else ""
        print(
            f"| {name} | {found['seconds']:.1f} | {found['runs per s']:,.0f} | {found['kernels']:.0%} | "
            f"{found['memory']:,.0f} MiB | {file} |",
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--case"]:
        print(json.dumps(measure(sys.argv[2])))
    else:
        main(sys.argv[1:])
