"""Short runs of gallery scenarios that cover every kernel and driver, for comparisons of bits."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from lienumba.batch.integrate import Batch, Chunk, integrate
from lienumba.engine.programs import batch_of, program_of
from lienumba.integrators.tracing.machine import compile_program
from lienumba.integrators.tracing.program import Program
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared, prepare
from tests.facade import resolve
from tests.rigs.places import SCENARIOS

GALLERY = sorted(path.stem for path in SCENARIOS.glob("*.toml"))
MORE = {  # what no small scenario of the gallery has
    "capture": ("docking", {"bodies.chaser.position": [-1.023, 0.003, 0.001]}),
    "capture of joints": (
        "docking",
        {"bodies.chaser.position": [-1.023, 0.003, 0.001], "integrator.coordinates": "joint"},
    ),
    "chord": ("heavy_top", {"projection.chord": True}),
    "measures": ("heavy_top", {"measures": [{"name": "slow", "value": "mean(t)"}, {"name": "end", "value": "max(t)"}]}),
    "quadrature": ("satellite", {"measures": [{"name": "slow", "value": "mean(t)"}]}),
    "radau": ("heavy_top", {"integrator.method": "radau5"}),
    "loop": ("four_bar", {"integrator": {"method": "bs32", "tolerance": 1e-6, "end_time": 1.0}}),
    "taylor": ("heavy_top", {"integrator": {"method": "taylor", "order": 4, "tolerance": 1e-12, "end_time": 1.0}}),
}
STEPS = 9  # of each run
MEASURED = ("runs", "seconds")  # of a chunk


def asked(name: str, **overrides: Any) -> Scenario:
    """A scenario; of a study its first point."""
    scenario = resolve(name, overrides=overrides)
    return scenario if scenario.plan is None else scenario.plan.points[0].scenario


def made(scenario: Scenario, runs: int = 2) -> tuple[Program, Batch]:
    """The program and a few of the runs, as this machine has them."""
    prepared, program = traced(scenario, runs)
    return program, batch_of(scenario, prepared, program, compile_program(program))


def traced(scenario: Scenario, runs: int = 1) -> tuple[Prepared, Program]:
    prepared = prepare(scenario, list(scenario.labels)[:runs])
    return prepared, program_of(scenario, prepared, True)


def shortened(batch: Batch) -> Batch:
    """So many steps, or about so many where a tolerance chooses them, and outputs at both ends and between."""
    if batch.h is not None:
        return replace(batch, end=STEPS * batch.h, outputs=batch.h * np.array([0, STEPS // 3, STEPS]))
    assert batch.pace is not None
    end = 3 * STEPS * float(np.max(batch.pace.first))
    return replace(batch, end=end, outputs=np.linspace(0.0, end, 4))


def simulated(batch: Batch) -> Chunk:
    return integrate(batch, slice(0, batch.runs), np.zeros(1, np.int64), np.zeros(1, np.int64))


def different(a: Chunk, b: Chunk) -> list[str]:
    """What has other bits."""
    return [name for name in compared(a) if bits(getattr(a, name)) != bits(getattr(b, name))]


def compared(chunk: Chunk) -> list[str]:
    """The fields that are not measured, nor derived from others."""
    return [f.name for f in fields(chunk) if f.name not in (*MEASURED, "variables")]


def bits(x: np.ndarray | None) -> bytes | None:
    return None if x is None else x.tobytes()


def example(name: str) -> Scenario:
    scenario, overrides = MORE.get(name, (name, {}))
    return asked(str(SCENARIOS / f"{scenario}.toml"), **overrides)
