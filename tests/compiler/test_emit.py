"""Compiled graphs give, bit for bit, what their operations mean; however they are cut, called or hoisted."""

import re
from random import Random
from typing import Any

import numpy as np
import pytest

from lienumba.compiler import emit, segments
from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph, Symbol
from lienumba.numerics import operations
from lienumba.numerics.operations import minimum
from tests.compiler.evaluation import assert_same_bits, call
from tests.compiler.interpreter import RandomGraph, fma, interpret, numbers

STATE, PARAMETERS, CLOCK = 5, 4, 2


def arrays(seed: int) -> dict[str, np.ndarray]:
    rows = {"state": STATE, "parameters": PARAMETERS, "clock": CLOCK, "extra": 3}
    return {name: numbers(n, 10 * seed + i) for i, (name, n) in enumerate(rows.items())}


def functions(text: str) -> dict[str, str]:
    """The body of every function of a module by its name."""
    return dict(re.findall(r"^define [^@]*@([\w.]+)\([^)]*\)[^{]*\{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL))


def segments_called(text: str, kernel: str) -> list[str]:
    """The bodies of the segments that a kernel runs, one after the other."""
    bodies = functions(text)
    return [bodies[name] for name in re.findall(r"^call void @([\w.]+)", bodies[kernel], re.MULTILINE)]


def computed(body: str) -> int:
    """How many values a segment computes."""
    return len(re.findall(r"^%v\d+ =", body, re.MULTILINE))


def cut_every(operations: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(segments, "SIZE", operations)


def test_the_interpreters_fma_is_rounded_once():
    assert fma(1.0 + 2.0**-30, 1.0 - 2.0**-30, -1.0) == -(2.0**-60)
    assert fma(2.0**-1074, 0.5, 0.0) == 0.0
    assert fma(1e200, 1e200, -np.inf) == -np.inf
    assert str(fma(-1.0, 0.0, -0.0)) == "-0.0"


@pytest.mark.parametrize("seed", range(25))
def test_random_graphs(seed):
    made = RandomGraph(seed)
    values = made.grow(10 + 12 * seed)
    outputs = tuple(made.random.sample(values, min(8, len(values)))) + (values[-1],)
    kernel = Kernel("main", outputs, PARAMETERS)
    given = arrays(seed)
    assert_same_bits(call(kernel, **given)[: len(outputs)], interpret(outputs, **given))


@pytest.mark.parametrize("segment", [1, 2, 7, 50])
@pytest.mark.parametrize("seed", range(100, 104))
def test_cutting_a_graph_into_segments_changes_no_bit(seed, segment, monkeypatch):
    made = RandomGraph(seed)
    outputs = tuple(made.grow(200)[::7])
    given = arrays(seed)
    whole = call(Kernel("main", outputs, PARAMETERS), **given)
    cut_every(segment, monkeypatch)
    kernel = Kernel("main", outputs, PARAMETERS)
    assert_same_bits(call(kernel, **given), whole)
    text = kernel.text()
    sizes = [computed(body) for name in ("main", "main_prepare") for body in segments_called(text, name)]
    assert max(sizes) <= segment
    assert sum(sizes) == sum(1 for node in kernel.order if node.op != "input")


def motif(graph: Graph, seed: int, links: int, start: tuple[Any, ...], looked_up: list[int]) -> tuple[Any, ...]:
    """What a mechanism of equal links computes: forth along the links and back, with values kept for the way back, rows
    of states and parameters that go on by 2 and 3 per link, and some in an order of their own."""
    random, kept, x = Random(seed), [], start
    choices = [(random.randrange(8), random.choice("+-*/m")) for _ in range(60)]
    for link in range(2 * links):
        back = link >= links
        i = 2 * links - 1 - link if back else link
        rows = [graph.input("state", 2 * i), graph.input("state", 2 * i + 1), graph.input("parameters", 3 * i)]
        values = [*x, *rows, graph.input("extra", looked_up[i]), *(kept.pop() if back else (1.5,))]
        for n, (earlier, op) in enumerate(choices):  # every value is used
            p, q = values[n], values[-1 - earlier]
            new = {"+": p + q, "-": 0.5 * p - q, "*": 0.5 * p * q, "/": p / (1.0 + q * q), "m": minimum(p, q)}
            values.append(new[op])
        small = [v / (1.0 + v * v) for v in values[-8:]]
        x = tuple(small[:3])
        if not back:
            kept.append(tuple(small[3:]))
    return x


@pytest.mark.parametrize("seed", range(2))
def test_equal_links_share_their_code(seed, monkeypatch):
    """To the bit, and so that the text hardly grows with the number of links."""
    monkeypatch.setattr(emit, "LONG", 0)
    monkeypatch.setattr(segments, "SHORTEST", 15)
    monkeypatch.setattr(segments, "MEAN", 20)
    functions_of = {}
    for links in (20, 40):
        graph = Graph()
        looked_up = Random(seed).sample(range(links), links)
        outputs = motif(graph, seed, links, graph.inputs("clock", 3), looked_up)
        kernel = Kernel("main", outputs, 3 * links)
        given = {"state": numbers(2 * links, seed), "parameters": numbers(3 * links, seed + 1)}
        given |= {"clock": numbers(3, seed + 2), "extra": numbers(links, seed + 3)}
        assert_same_bits(call(kernel, **given)[: len(outputs)], interpret(outputs, **given))
        text = kernel.text()
        functions_of[links] = len(functions(text))
        assert ".rows = internal constant" in text  # what is looked up
        assert len(segments_called(text, "main")) > 2 * functions_of[links]
    assert functions_of[40] <= functions_of[20] + 4


def test_work_rows_are_used_again(monkeypatch):
    """A long thin computation needs a handful of rows, however often it is cut."""
    cut_every(10, monkeypatch)
    graph = Graph()
    a, b = graph.inputs("state", 2)
    for _ in range(500):
        a, b = b + 1.0 / a, a - 0.5 * b
    kernel = Kernel("main", (a, b), 0)
    given = {"state": numbers(2, 1)}
    assert_same_bits(call(kernel, **given)[:2], interpret((a, b), **given))
    assert kernel.work_rows <= 6


def test_outputs_may_be_inputs_and_numbers_and_repeat():
    graph = Graph()
    x, p = graph.input("state", 0), graph.input("parameters", 0)
    y = x * p
    outputs = (x, 2.5, y, p, 0.0, y, -1, p * p, -0.0)
    given = {"state": numbers(1, 3), "parameters": numbers(1, 4)}
    out = call(Kernel("main", outputs, 1), **given)
    assert_same_bits(out, interpret(outputs, **given))


def test_lanes_are_independent():
    made = RandomGraph(42)
    outputs = tuple(made.grow(120)[-10:])
    kernel = Kernel("main", outputs, PARAMETERS)
    given = arrays(42)
    out = call(kernel, **given)
    for lane in range(W):
        alone = {name: np.repeat(a[:, lane : lane + 1], W, axis=1) for name, a in given.items()}
        assert_same_bits(call(kernel, **alone)[:, 0], out[:, lane])


def test_no_instruction_is_left_any_freedom():
    made = RandomGraph(5)
    text = Kernel("main", tuple(made.grow(300)[-20:]), PARAMETERS).text()
    flags = r"\b(fast|contract|reassoc|nnan|ninf|nsz|arcp|afn|fmuladd)\b"
    assert not re.findall(flags, text)


def test_the_text_of_a_graph_is_the_same_each_time():
    def text() -> str:
        return Kernel("main", tuple(RandomGraph(6).grow(300)[-20:]), PARAMETERS).text()

    assert text() == text()


# ---------------------------------------------------------------- hoisting
def test_work_on_parameters_alone_is_not_in_the_main_function():
    graph = Graph()
    x, (p, q) = graph.input("state", 0), graph.inputs("parameters", 2)
    root = operations.sqrt(p / q)
    chosen = operations.where(p < q, root, 3.0 * q)
    outputs = (x * root + chosen, root)
    kernel = Kernel("main", outputs, 2)
    bodies = functions(kernel.text())
    main = "".join(body for name, body in bodies.items() if "prepare" not in name)
    prepare = "".join(body for name, body in bodies.items() if "prepare" in name)
    for instruction in ("fdiv", "sqrt", "select", "fcmp"):
        assert instruction not in main
        assert instruction in prepare
    assert kernel.counts() == {"add": 0, "multiply": 0, "fma": 1, "divide": 0, "sqrt": 0, "select": 0,
                               "operations": 1, "flops": 2}  # fmt: skip
    given = {"state": numbers(1, 5), "parameters": numbers(2, 6)}
    assert_same_bits(call(kernel, **given)[:2], interpret(outputs, **given))


@pytest.mark.parametrize("seed", range(200, 206))
def test_invariants_of_random_graphs_are_hoisted(seed):
    made = RandomGraph(seed)
    outputs = tuple(made.grow(150))
    kernel = Kernel("main", outputs, PARAMETERS)
    text, operations = kernel.text(), [node for node in kernel.order if node.op != "input"]
    invariant = sum(node.invariant for node in operations)
    assert invariant
    assert sum(map(computed, segments_called(text, "main_prepare"))) == invariant
    assert sum(map(computed, segments_called(text, "main"))) == len(operations) - invariant
    rows = sorted(kernel.hoisted.values())
    assert rows == list(range(PARAMETERS, PARAMETERS + len(rows)))


# ---------------------------------------------------------------- rows of the outputs
@pytest.mark.parametrize("segment", [3, 800])
def test_outputs_go_to_their_rows(segment, monkeypatch):
    """Computed values, inputs, constants and invariants alike; other rows stay untouched."""
    cut_every(segment, monkeypatch)
    made = RandomGraph(301)
    made.grow(40)
    computed = [x for x in made.values[STATE + PARAMETERS + CLOCK :] if isinstance(x, Symbol)][-3:]
    outputs = (*computed, made.values[0], 2.5)
    given = arrays(301)
    plain = call(Kernel("plain", outputs, PARAMETERS), **given)
    spread = call(Kernel("spread", outputs, PARAMETERS, (7, 0, 3, 9, 2)), **given)
    assert_same_bits(spread[[7, 0, 3, 9, 2]], plain)
    assert np.isnan(spread[[1, 4, 5, 6, 8]]).all()


@pytest.mark.parametrize("segment", [1, 3, 300])
def test_what_a_kernel_renews_is_read_before(segment: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """However it is cut: rows change places, and each is read again behind the first that is written."""
    cut_every(segment, monkeypatch)
    graph = Graph()
    a, b, c = graph.inputs("out", 3)
    outputs = (b + 0.0, c * a, (a + b) * c)
    old = numbers(3, 7)
    new = call(Kernel("main", outputs, PARAMETERS, renews=True), out=old, **arrays(0))
    np.testing.assert_array_equal(new[:3], [old[1] + 0.0, old[2] * old[0], (old[0] + old[1]) * old[2]])
