"""A step in one kernel and a step stage by stage, as large mechanisms take it, are the same step."""

from typing import Any

import numpy as np
import pytest

from lienumba.integrators.tracing import program, step_kernels
from lienumba.integrators.tracing.machine import compile_program
from tests.facade import METHODS
from tests.rigs.scenarios import LOOP, TOP, chain, scenario, simulate, start_of, state_at


def kernels_of(mechanism: dict[str, Any], method: str) -> set[str]:
    model, _ = start_of(scenario(mechanism, 1e-3, 1e-3))
    return set(program.build(model, program.Method(method, "local", "mass")).kernels)


def test_which_mechanisms_are_large() -> None:
    always = {"position", "velocity", "observe"}
    assert kernels_of(TOP, "rk4") == {"step"} | always
    stages = {"first", "stage", "combine1", "combine2", "combine3", "advance"}
    assert kernels_of(chain(5), "rk4") == stages | always
    assert kernels_of(chain(5), "euler") == {"step"} | always
    assert kernels_of(chain(24), "euler") == {"first", "stage", "advance"} | always


@pytest.mark.parametrize(
    ("mechanism", "method"),
    [
        *((TOP, name) for name, method in METHODS.items() if not (method.series or method.implicit)),
        (LOOP, "rk4"),
        (LOOP, "tsit54"),
    ],
    ids=lambda x: x if isinstance(x, str) else "top" if x is TOP else "loop",
)
def test_both_give_the_same_numbers(mechanism: dict[str, Any], method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keywords: Any = {"method": method, "projection": ("none", "mass"), "output": {"every": 0.01}}
    whole = simulate(mechanism, 1e-3, 0.1, **keywords)
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    assert "step" not in kernels_of(mechanism, method)
    staged = simulate(mechanism, 1e-3, 0.1, **keywords)
    for time in range(11):
        for a, b in zip(state_at(staged, time), state_at(whole, time), strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)


def test_a_staged_machine_has_no_step_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    model, _ = start_of(scenario(TOP, 1e-3, 1e-3))
    machine = compile_program(program.build(model, program.Method("rk38", "none", "none")))
    assert machine.kernels[0] == machine.kernels[1] == machine.kernels[2] == machine.kernels[3] == 0
    assert np.count_nonzero(machine.kernels) == 7  # observe, first, stage, advance, three arguments of stages
    np.testing.assert_allclose(machine.nodes, [0, 1 / 3, 2 / 3, 1, 1])
