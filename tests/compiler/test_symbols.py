"""Symbols fold, share and fuse by rules that look at one operation at a time."""

import operator

import numpy as np
import pytest

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph, Symbol, live, operation_counts
from lienumba.compiler.tape import replayed
from lienumba.numerics import operations
from lienumba.numerics.jets import Dual
from tests.compiler.evaluation import assert_same_bits, call
from tests.compiler.interpreter import RandomGraph, interpret, numbers


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def abc(graph):
    return graph.inputs("state", 3)


def shown(x):
    """The expression as nested tuples."""
    if not isinstance(x, Symbol):
        return x
    return "abcdefgh"[x.args[1]] if x.op == "input" else (x.op, *map(shown, x.args))


# ---------------------------------------------------------------- folding
def test_exact_zeros_and_ones_fold_away(abc):
    a, b, _ = abc
    for same in (a + 0.0, 0.0 + a, a - 0.0, a * 1.0, 1 * a, a / 1.0, a * -1.0 * -1, a + 0):
        assert same is a
    opposite = -a
    assert -opposite is a
    assert 0.0 - a is -a
    assert a / -1 is -a
    assert a * -1.0 is -a
    assert a - b is -(b - a)
    for zero in (a * 0.0, 0 * a, a - a, 0.0 / a, (-a) - (-a), (-a) + a):
        assert isinstance(zero, float)
        assert zero == 0.0


def test_nothing_but_zero_and_one_folds(abc):
    a, _, _ = abc
    assert shown(a + 1.0) == ("+", "a", 1.0)
    assert shown(a * 2.0) == ("*", "a", 2.0)
    assert shown(a / 2.0) == ("/", "a", 2.0)
    assert shown(1.0 / a) == ("/", 1.0, "a")
    assert shown(2.0 - a) == ("-", 2.0, "a")
    assert shown(a / a) == ("/", "a", "a")
    assert shown(a * 1.0000000000000002) == ("*", "a", 1.0000000000000002)


def test_signs_move_out_of_products_and_into_sums(abc):
    a, b, c = abc
    assert (-a) * b is -(a * b)
    assert a * (-b) is -(a * b)
    assert (-a) * (-b) is a * b
    assert (-a) / b is -(a / b)
    assert 2.0 / (-a) is -(2.0 / a)
    assert (-a) * 3.0 is a * -3.0
    assert a + (-b) is a - b
    assert (-a) + b is b - a
    assert a - (-b) is a + b
    assert (-a) - b is -(a + b)
    assert c - (-a) * b is c + a * b


# ---------------------------------------------------------------- sharing
def test_repeated_expressions_are_one_node(graph, abc):
    a, b, c = abc
    assert a + b is b + a
    assert a * b is b * a
    assert operations.sqrt(a * b + c) is operations.sqrt(b * a + c)
    assert graph.input("state", 1) is b
    count = len(graph.nodes)
    assert ((a + b) * c - (b + a) * c) == 0.0
    assert len(graph.nodes) == count + 1  # the product alone


def test_a_number_is_not_mistaken_for_a_node(abc):
    a, b, c = abc
    assert a + 1.0 is not a + b
    assert a * 2 is a * 2.0
    assert c.id == 2
    assert a + 2.0 is not a + c


@pytest.mark.parametrize("make", [
    lambda a, b, zero: operations.where(a < b, zero, a),
    lambda a, b, zero: a / zero,
], ids=["where", "divide"])  # fmt: skip
def test_the_sign_of_zero_is_part_of_a_number(abc, make):
    """Else the first of 0.0 and -0.0 that is recorded would stand for both."""
    a, b, _ = abc
    assert make(a, b, 0.0) is not make(a, b, -0.0)


def test_graphs_are_apart():
    assert Graph().input("state", 0) is not Graph().input("state", 0)


# ---------------------------------------------------------------- fusing
def test_a_product_that_meets_a_sum_becomes_a_multiply_add(abc):
    a, b, c = abc
    assert shown(a * b + c) == ("fma", "a", "b", "c")
    assert shown(c + a * b) == ("fma", "a", "b", "c")
    assert shown(a * b - c) == ("fms", "a", "b", "c")
    assert shown(c - a * b) == ("fnma", "a", "b", "c")
    assert shown(a * 2.0 + c) == ("fma", "a", 2.0, "c")
    assert shown(a * b + 2.0) == ("fma", "a", "b", 2.0)
    assert shown(2.0 - a * b) == ("fnma", "a", "b", 2.0)
    assert shown(c - (-a) * b) == ("fma", "a", "b", "c")
    assert shown(c + (-a) * b) == ("fnma", "a", "b", "c")


def test_the_second_of_two_products_is_fused(abc):
    a, b, c = abc
    assert shown(a * b + a * c) == ("fma", "a", "c", ("*", "a", "b"))
    assert shown(a * b - a * c) == ("fnma", "a", "c", ("*", "a", "b"))


def test_a_product_is_fused_however_often_it_is_used(abc):
    a, b, c = abc
    product = a * b
    kept, twice = product * 2.0, product / c
    assert shown(product + c)[0] == "fma"
    assert shown(kept) == ("*", ("*", "a", "b"), 2.0)
    assert shown(twice) == ("/", ("*", "a", "b"), "c")


def test_what_is_stored_cannot_change_what_is_computed():
    """The same rows, alone, among all others, and behind work that is recorded and dropped: the same bits."""
    given = {"state": numbers(5, 1), "parameters": numbers(4, 2), "clock": numbers(2, 3)}
    for seed in range(8):
        made = RandomGraph(seed)
        values = made.grow(80)
        everything = call(Kernel("main", tuple(values), 4), **given)[: len(values)]
        for some in (values[5::9], values[-1:], values[::-1][:7]):
            alone = call(Kernel("main", tuple(some), 4), **given)[: len(some)]
            rows = [next(i for i, v in enumerate(values) if v is x) for x in some]
            assert_same_bits(alone, everything[rows])


def test_what_was_recorded_before_cannot_change_what_is_computed():
    """Identical work traced into a fresh graph and into a crowded one."""
    given = {"state": numbers(5, 4), "parameters": numbers(4, 5), "clock": numbers(2, 6)}

    def trace(crowd: int):
        made = RandomGraph(77)
        if crowd:
            other = RandomGraph(crowd)
            other.graph, other.values = made.graph, list(made.values)
            other.grow(200)
        return tuple(made.grow(120))

    for crowd in (1, 2, 3):
        assert_same_bits(interpret(trace(crowd), **given), interpret(trace(0), **given))


def test_what_is_computed_again_has_the_same_bits():
    """A recorded graph on another one's symbols: also where sums are of products, of which one is rounded first."""
    given = {"state": numbers(5, 7), "parameters": numbers(4, 8), "clock": numbers(2, 9)}
    for seed in range(12):
        values = tuple(RandomGraph(seed).grow(150))
        assert_same_bits(interpret(tuple(replayed(values, Graph().input)), **given), interpret(values, **given))


# ---------------------------------------------------------------- branching
def test_a_kernel_cannot_branch_on_a_symbol(abc):
    a, b, _ = abc
    for condition in (a < b, a <= 1.0, a == b, a):
        with pytest.raises(TypeError, match=r"where\(condition, x, y\)"):
            bool(condition)
    with pytest.raises(TypeError):
        max(a, b)


def test_comparisons_and_choices(abc):
    a, b, c = abc
    assert shown(a < b) == ("<", "a", "b")
    assert shown(a > b) == ("<", "b", "a")
    assert shown(a >= b) == ("<=", "b", "a")
    assert shown(a > 1.0) == ("<", 1.0, "a")
    assert shown(operations.where(a < b, c, 1.0)) == ("where", ("<", "a", "b"), "c", 1.0)
    assert shown(operations.where(a < b, 1.0, 0.0)) == ("where", ("<", "a", "b"), 1.0, 0.0)
    assert operations.where(a < b, c, c) is c


def test_a_promised_bound_decides_comparisons(abc):
    a, b, _ = abc
    operations.at_most(a, 5.0)
    assert (a < 6.0) is True
    assert (a <= 5.0) is True
    assert isinstance(a < 5.0, Symbol)
    assert isinstance(a < b, Symbol)
    assert isinstance(b < 6.0, Symbol)
    assert operations.where(a < 6.0, b, a) is b
    operations.at_most(a, 7.0)
    assert (a < 6.0) is True  # the tighter promise stands


@pytest.mark.parametrize("compare", [operator.lt, operator.le, operator.gt, operator.ge])
def test_comparisons_with_jets_are_of_what_they_are_jets_of(abc, compare):
    a, b, c = abc
    moving = Dual(b, c)
    assert shown(compare(a, moving)) == shown(compare(a, b))
    assert shown(compare(moving, a)) == shown(compare(b, a))


# ---------------------------------------------------------------- company and account
def test_arrays_and_strings_are_no_partners(abc):
    a, _, _ = abc
    for other in (np.ones(3), "x", None, 1j):
        with pytest.raises(TypeError):
            a + other
        with pytest.raises(TypeError):
            other * a
    assert shown(np.float64(2.0) * a) == ("*", "a", 2.0)


def test_invariance_spreads_from_parameters_alone(graph):
    p, q = graph.inputs("parameters", 2)
    x, t = graph.input("state", 0), graph.input("clock", 0)
    assert operations.sqrt(p * q + 2.0).invariant
    assert operations.where(p < q, p, 1.0).invariant
    assert not (p * x).invariant
    assert not (t + p).invariant


def test_live_keeps_what_is_needed_each_behind_what_it_uses():
    for seed in range(20):
        made = RandomGraph(seed)
        made.grow(100)
        outputs = tuple(made.values[-3:])
        order = live(outputs)
        seen: set[int] = set()
        for node in order:
            assert all(x.id in seen for x in node.args if isinstance(x, Symbol))
            seen.add(node.id)
        assert len(seen) == len(order)
        used = {x.id for node in order for x in node.args if isinstance(x, Symbol)}
        assert seen <= used | {x.id for x in outputs if isinstance(x, Symbol)}


def test_operation_counts(abc):
    a, b, c = abc
    x = operations.where(a < b, (a + b) / c, operations.sqrt(a * b - c)) * (a - b)
    counts = operation_counts(live((x,)))
    assert counts.pop("operations") == sum(n for kind, n in counts.items() if kind != "flops") == 8
    assert counts.pop("flops") == 2 + 1 + 2 * 1 + 1 + 1
    assert counts == {"add": 2, "multiply": 1, "fma": 1, "divide": 1, "sqrt": 1, "select": 2}
