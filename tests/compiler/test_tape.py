"""Tapes: what is compiled to a Python function computes what a loop over the operations does."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.compiler import tape
from lienumba.compiler.series import FUNCTIONS
from lienumba.compiler.symbols import Graph
from lienumba.compiler.tape import Tape
from lienumba.numerics import operations as o
from tests.compiler.interpreter import RandomGraph

KINDS = {"float": None, "array": (5,)}


def assert_compiled_is_looped(values: list[Any], given: dict[tuple[str, int], Any], monkeypatch: Any) -> None:
    def replayed(often: float) -> list[Any]:
        monkeypatch.setattr(tape, "REPLAYS_BEFORE_COMPILING", often)
        with np.errstate(all="ignore"):
            return Tape.of(values).replayed(lambda *place: given[place])

    for compiled, looped in zip(replayed(0), replayed(np.inf), strict=True):
        assert type(compiled) is type(looped)
        np.testing.assert_array_equal(np.signbit(compiled), np.signbit(looped))
        np.testing.assert_array_equal(compiled, looped)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_random_graphs(kind: str, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made, rng = RandomGraph(seed), np.random.default_rng(seed)
    sizes = {"state": 5, "parameters": 4, "clock": 2}
    given = {(name, n): rng.normal(size=KINDS[kind]) for name, size in sizes.items() for n in range(size)}
    assert_compiled_is_looped(made.grow(400), given, monkeypatch)


@lienumba.jit
def halved(x, y):
    return 0.5 * x, y


@pytest.mark.parametrize("kind", KINDS)
def test_every_operation(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With numbers that have no literal, and values that are inputs or numbers themselves."""
    graph, rng = Graph(analytic=True), np.random.default_rng(1)
    a, b, c = graph.inputs("x", 3)
    table = graph.input("x", 3)
    values = [
        a + b, a - b, a * b, a / b, -a, a * b + c, a * b - c, c - a * b, o.sqrt(a), o.power(a, 1.5), o.sin(a), o.cos(b),
        o.exp(a), o.log(b), o.tanh(c), o.atan2(a, b), o.where(a < b, a, float("nan")), o.where(a <= b, c, -0.0),
        o.where(a == b, b, float("inf")), o.gather(table, o.where(a < b, 0.0, 1.0)),
        o.power_of_two(o.where(a < b, 3.0, 4.0)), *halved(a, b), a, a, 2.5,
    ]  # fmt: skip
    recorded = {node.op for node in graph.nodes}
    assert recorded == {"input", *FUNCTIONS}
    given: dict[tuple[str, int], Any] = {("x", n): rng.uniform(0.5, 2.0, size=KINDS[kind]) for n in range(3)}
    given["x", 3] = _Numbers()
    assert_compiled_is_looped(values, given, monkeypatch)


class _Numbers:
    def gather(self, index: Any) -> Any:
        return 10.0 + index
