"""Kernels of doubles without optimisation, which most tests use, give the same bits as those of vectors, which users
have, whatever the width of their CPU: of short simulations of the whole gallery, and of more that have every kernel
between them."""

from dataclasses import replace

import pytest

from lienumba.compiler import emit, native
from lienumba.compiler.value_types import DOUBLE, ValueType
from lienumba.integrators.tracing.machine import compile_program
from tests.rigs.chunks import GALLERY, MORE, STEPS, different, example, made, shortened, simulated


def differing(name: str, values: ValueType = DOUBLE) -> list[str]:
    """What of a scenario's results has other bits with kernels of such values."""
    program, batch = made(example(name))
    batch = shortened(batch)
    vectors = simulated(batch)
    assert vectors.steps.min() >= STEPS // 3
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(emit, "VALUES", values)
        patch.setattr(native, "LEVEL", 0 if values is DOUBLE else native.LEVEL)
        return different(vectors, simulated(replace(batch, machine=compile_program(program))))


@pytest.mark.parametrize("name", [*MORE, *GALLERY])
def test_the_gallery(name: str) -> None:
    assert differing(name) == []


@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("name", ["heavy_top", *MORE])
def test_any_number_of_lanes_in_a_value(name: str, lanes: int) -> None:
    assert differing(name, ValueType(lanes)) == []


def test_an_operation_that_is_rounded_twice_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    twice = """define internal double @twice(double %a, double %b, double %c) {
        %p = fmul double %a, %b
        %s = fadd double %p, %c
        ret double %s
    }"""
    monkeypatch.setattr(DOUBLE, "fma", "call double @twice")
    monkeypatch.setattr(DOUBLE, "declarations", DOUBLE.declarations + twice)
    assert differing("heavy_top") == ["records", "states"]
