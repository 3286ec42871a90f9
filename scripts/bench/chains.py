"""Chains of k bodies: what it takes to compile one from nothing, and what a stage costs per body.

Run as a script, with k and a LIENUMBA_CACHE_DIR, it compiles and prints the seconds as JSON.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from bench.clock import Spent

STAGES = 4  # of RK4
BLOCKS = 2
STEP = 1e-4
WORK = 6_000_000  # stages times bodies times runs of one sample


class Chain:
    """A chain that is ready to run on one thread, without projection."""

    def __init__(self, k: int) -> None:
        from bench import engine

        model, states = engine.chain(k, BLOCKS * engine.W)
        program = engine.build(model, engine.METHODS["none"])
        self.k, self.flops = k, engine.step_flops(program)
        self.steps = max(10, WORK // (STAGES * k * len(states)))
        machine = engine.compile_program(program)
        self.batch = engine.batch(model, machine, states, STEP, self.steps, np.array([self.steps]))
        self.evaluations = STAGES * k * len(states) * self.steps
        self.run_steps = len(states) * self.steps

    def spend(self) -> Spent:
        from bench import engine

        return engine.spend(self.batch, 1)


def cold(sizes: list[int]) -> dict[int, dict[str, float]]:
    """Seconds to trace and compile chains, projections included, each in a new process; the cache is empty before the
    first, which compiles the driver."""
    found: dict[int, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = [str(Path(__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = os.environ | {"LIENUMBA_CACHE_DIR": folder, "PYTHONPATH": os.pathsep.join(path)}
        for k in sizes:
            command = [sys.executable, __file__, str(k)]
            done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
            found[k] = json.loads(done.stdout)
    return found


def _compile(k: int) -> dict[str, float]:
    from bench import engine
    from lienumba.compiler.flat import kept

    model, _ = engine.chain(k, 1)
    start = time.perf_counter()
    kept("lienumba.integrators.drivers.fixed_step", "drive")

    ready = time.perf_counter()
    program = engine.build(model, engine.METHODS["both"])
    traced = time.perf_counter()
    engine.compile_program(program)
    end = time.perf_counter()
    return {"driver": ready - start, "trace": traced - ready, "compile": end - traced, "total": end - ready}


if __name__ == "__main__":
    print(json.dumps(_compile(int(sys.argv[1]))))
