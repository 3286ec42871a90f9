"""The same bits on AArch64, under qemu-user: of scenarios that have every kernel and every driver between them;
`scripts/arm64` compares the whole gallery."""

import os
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lienumba.batch.integrate import Batch, Chunk
from lienumba.compiler import emit
from lienumba.integrators.layout import ORDER
from lienumba.integrators.tracing.machine import compile_program
from lienumba.integrators.tracing.program import Program
from tests.process.arm64.emulated import Guest, missing
from tests.rigs.chunks import (
    GALLERY,
    MORE,
    STEPS,
    asked,
    compared,
    different,
    example,
    made,
    shortened,
    simulated,
    traced,
)
from tests.rigs.places import SCENARIOS

TOP = str(SCENARIOS / "heavy_top.toml")
pytestmark = pytest.mark.usefixtures("vectors")  # the code that users run
CPUS = ("neoverse-v2", "apple-m1")  # the first has SVE; all else is made for a generic one
SOME = ("arm_sampled", "bouncing_ball", "dzhanibekov", "five_bar_leg", "gripper", "heavy_top_study", "pawl",
        "satellite", "satellite_settles", "separation", "thruster", "ur5")  # fmt: skip
AS_EVER = bool(os.environ.get("LIENUMBA_ARM64_AS_EVER"))  # the whole gallery, and code generated as for users
NAMES = [name for name in GALLERY if AS_EVER or name in SOME]
FAST = 0  # else LLVM's level of code generation that takes a tenth of the time


@pytest.fixture(scope="module")
def guest(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guest]:
    if why := missing():
        assert not os.environ.get("LIENUMBA_NEEDS_ARM64"), why
        pytest.skip(why)
    made = Guest(tmp_path_factory.mktemp("arm64"))
    yield made
    made.close()


def emulated(guest: Guest, program: Program, batch: Batch, **how: Any) -> Chunk:
    """The same runs by AArch64 code."""
    with guest.instead(**how):
        found = simulated(replace(batch, machine=compile_program(program)))
        copies = {name: x.copy() for name in compared(found) if (x := getattr(found, name)) is not None}
        return replace(found, **copies)


@pytest.mark.release
@pytest.mark.parametrize("cpu", CPUS)
def test_a_top_for_several_processors(guest: Guest, cpu: str) -> None:
    program, batch = made(asked(TOP))
    batch = shortened(batch)
    assert different(simulated(batch), emulated(guest, program, batch, cpu=(cpu, ""))) == []


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
    ours, v = simulated(batch), emit.VALUES.name
    twice = f"""define internal {v} @twice({v} %a, {v} %b, {v} %c) {{
        %p = fmul {v} %a, %b
        %s = fadd {v} %p, %c
        ret {v} %s
    }}"""
    monkeypatch.setattr(emit.VALUES, "fma", f"call {v} @twice")
    monkeypatch.setattr(emit.VALUES, "declarations", emit.VALUES.declarations + twice)
    assert different(ours, emulated(guest, program, batch, level=FAST)) == ["records", "states"]
