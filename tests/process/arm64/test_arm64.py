"""The same bits on AArch64, under qemu-user: of scenarios that have every kernel and every driver between them;
`scripts/arm64` compares the whole gallery."""

import os
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lienumba.batch.integrate import Batch, Chunk, integrate
from lienumba.compiler import emit
from lienumba.engine.programs import batch_of, program_of
from lienumba.integrators.layout import ORDER
from lienumba.integrators.tracing.machine import compile_program
from lienumba.integrators.tracing.program import Program
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import Prepared, prepare
from tests.process.arm64.emulated import Guest, missing

SCENARIOS = Path(__file__).parents[3] / "scenarios"
TOP = str(SCENARIOS / "heavy_top.toml")
CPUS = ("neoverse-v2", "apple-m1")  # the first has SVE; all else is made for a generic one
SOME = ("arm_sampled", "bouncing_ball", "dzhanibekov", "five_bar_leg", "gripper", "heavy_top_study", "pawl",
        "satellite", "satellite_settles", "separation", "thruster", "ur5")  # fmt: skip
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
AS_EVER = bool(os.environ.get("LIENUMBA_ARM64_AS_EVER"))  # the whole gallery, and code generated as for users
NAMES = sorted(path.stem for path in SCENARIOS.glob("*.toml") if AS_EVER or path.stem in SOME)
FAST = 0  # else LLVM's level of code generation that takes a tenth of the time
MEASURED = ("runs", "seconds")  # of a chunk


@pytest.fixture(scope="module")
def guest(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guest]:
    if why := missing():
        assert not os.environ.get("LIENUMBA_NEEDS_ARM64"), why
        pytest.skip(why)
    made = Guest(tmp_path_factory.mktemp("arm64"))
    yield made
    made.close()


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


def emulated(guest: Guest, program: Program, batch: Batch, **how: Any) -> Chunk:
    """The same runs by AArch64 code."""
    with guest.instead(**how):
        found = simulated(replace(batch, machine=compile_program(program)))
        copies = {name: x.copy() for name in compared(found) if (x := getattr(found, name)) is not None}
        return replace(found, **copies)


def different(a: Chunk, b: Chunk) -> list[str]:
    """What has other bits."""
    return [name for name in compared(a) if bits(getattr(a, name)) != bits(getattr(b, name))]


def compared(chunk: Chunk) -> list[str]:
    """The fields that are not measured."""
    return [f.name for f in fields(chunk) if f.name not in MEASURED]


def bits(x: np.ndarray | None) -> bytes | None:
    return None if x is None else x.tobytes()


@pytest.mark.release
@pytest.mark.parametrize("cpu", CPUS)
def test_a_top_for_several_processors(guest: Guest, cpu: str) -> None:
    program, batch = made(asked(TOP))
    batch = shortened(batch)
    assert different(simulated(batch), emulated(guest, program, batch, cpu=(cpu, ""))) == []


def example(name: str) -> Scenario:
    scenario, overrides = MORE.get(name, (name, {}))
    return asked(str(SCENARIOS / f"{scenario}.toml"), **overrides)


@pytest.mark.parametrize("name", [*NAMES, *MORE])
def test_the_gallery(guest: Guest, name: str) -> None:
    program, batch = made(example(name))
    batch = shortened(batch)
    ours = simulated(batch)
    assert ours.steps.min() >= STEPS // 3
    level = {} if AS_EVER else {"level": FAST}
    assert different(ours, emulated(guest, program, batch, **level)) == []


@pytest.mark.release
def test_every_kernel_is_compared() -> None:
    """Of those that the driver may call, by what is traced for these scenarios."""
    found = {kernel for name in (*NAMES, *MORE) for kernel in traced(example(name))[1].kernels}
    assert {*ORDER} <= found


@pytest.mark.release
def test_what_is_no_number(guest: Guest) -> None:
    """The sign of a NaN that is computed is the processor's: negative on x86, positive on ARM."""
    tip = {"name": "tip", "type": "point", "body": "top"}
    quantities = [tip, {"name": "none", "type": "expression", "value": "sqrt(tip.z - 1e3 - t)"}]
    program, batch = made(asked(TOP, quantities=quantities))
    batch = shortened(batch)
    ours = simulated(batch)
    nothing = ours.records[np.isnan(ours.records)]
    assert nothing.size
    assert {x.tobytes() for x in nothing} == {np.array(np.nan).tobytes()}
    assert different(ours, emulated(guest, program, batch, level=FAST)) == []


@pytest.mark.release
def test_runs_that_fail(guest: Guest) -> None:
    fast = {"bodies.top.angular_velocity[0]": {"distribution": "uniform", "low": 0, "high": 1e80}}
    program, batch = made(asked(TOP, sweep={"runs": 9, "vary": fast}), runs=9)
    batch = shortened(batch)
    ours = simulated(batch)
    assert ours.codes.all()
    assert different(ours, emulated(guest, program, batch, level=FAST)) == []


@pytest.mark.release
def test_an_operation_that_is_rounded_twice_is_seen(guest: Guest, monkeypatch: pytest.MonkeyPatch) -> None:
    program, batch = made(asked(TOP))
    batch = shortened(batch)
    ours, v = simulated(batch), emit.VECTOR
    twice = f"""define internal {v} @twice({v} %a, {v} %b, {v} %c) {{
        %p = fmul {v} %a, %b
        %s = fadd {v} %p, %c
        ret {v} %s
    }}"""
    monkeypatch.setattr(emit, "FMA", f"call {v} @twice")
    monkeypatch.setattr(emit, "DECLARATIONS", emit.DECLARATIONS + twice)
    assert different(ours, emulated(guest, program, batch, level=FAST)) == ["records", "states"]
