"""How large what a graph computes is a sum of: no change of its inputs changes a value by more."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lienumba.compiler.symbols import Graph
from lienumba.compiler.tape import replayed
from lienumba.compiler.terms import terms
from lienumba.numerics import operations as o

SOME = st.floats(0.1, 3.0) | st.floats(-3.0, -0.1)


def values(x: Any, y: Any, z: Any) -> list[Any]:
    angle = o.atan2(y, x)
    return [
        x - y,
        (x + y) * (x - y) - (x * x - y * y),  # 0 in exact arithmetic
        o.sin(x) * o.cos(y) - o.cos(x) * o.sin(y) - o.sin(x - y),
        o.sqrt(x * x + y * y) * o.cos(angle) - x,
        x * y / z - (y / z) * x,
        o.exp(z) * o.exp(-z) - 1.0,
        o.where(x < y, x * z - y, 2.0 * y - x),
        o.tanh(z) + o.log(x * x),
        3.0,
    ]


def sizes(at: tuple[float, ...]) -> list[Any]:
    inputs = Graph(analytic=True).inputs("state", 3)
    return replayed(terms(values(*inputs)), lambda array, row: at[row])


@settings(max_examples=200, deadline=None)
@given(SOME, SOME, SOME, st.lists(st.sampled_from([-1.0, 1.0]), min_size=3, max_size=3))
def test_no_change_of_the_inputs_changes_a_value_by_more(x: float, y: float, z: float, signs: list[float]) -> None:
    at, least = (x, y, z), 1e-7
    moved = [a * (1.0 + least * s) for a, s in zip(at, signs, strict=True)]
    change = np.abs(np.array(values(*moved), float) - np.array(values(*at), float))
    known = np.array(sizes(at), float)
    assert (change <= least * known * (1.0 + 1e-4) + 1e-11).all() or abs(x - y) < 1e-5


@settings(max_examples=200, deadline=None)
@given(SOME, SOME, SOME)
def test_what_is_0_is_rounding_of_its_terms(x: float, y: float, z: float) -> None:
    found, known = values(x, y, z), sizes((x, y, z))
    for n in (1, 2, 3, 4, 5):
        assert abs(found[n]) <= 3e-16 * known[n]


def test_entries_of_rotations_are_rounded_as_those_that_are_1() -> None:
    """Whatever they are: of two that are 1e-17, by rounding, a difference may be all of a turned force."""
    graph = Graph(analytic=True)
    x, y, z = graph.inputs("state", 3)
    values = [1e6 * (x - y), x * z, y + z]
    found = replayed(terms(values, {("state", 0), ("state", 1)}), lambda array, row: (1e-17, -1e-17, 2.0)[row])
    assert found == [2e6, 2.0 + 2e-17, 3.0]


def test_sizes_of_some_sums() -> None:
    found = sizes((3.0, 2.0, 0.5))
    assert found[0] == 5.0
    assert found[1] == 5.0 * 5.0 + 5.0 * 1.0 + 2.0 * (9.0 + 4.0)
    assert found[6] == 7.0
    assert found[8] == 0.0


def test_a_direction_of_parameters_counts_as_given() -> None:
    """Across axes that are nearly parallel it is a matter of rounding; what moves is not."""
    graph = Graph(analytic=True)
    for array, known in (("parameters", 0.6), ("state", 1.0)):
        x, y = graph.inputs(array, 2)
        direction = x / o.sqrt(x * x + y * y)
        size = replayed(terms([direction]), lambda _, row: (3.0, 4.0)[row])[0]
        assert (size == pytest.approx(known)) if array == "parameters" else (size > known)


def test_what_no_branch_takes_does_not_count() -> None:
    x, y = Graph(analytic=True).inputs("state", 2)
    size = replayed(terms([o.where(x < y, x, 1.0 / (y - 2.0 * x))]), lambda _, row: (1.0, 2.0)[row])[0]
    assert size == 1.0
