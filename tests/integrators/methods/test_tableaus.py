"""Every tableau proves its order by the rooted-tree conditions, in fractions (Butcher 1963)."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache

import pytest

from lienumba.integrators.methods.tableau import Tableau
from tests.facade import METHODS

TABLEAUS = {name: method for name, method in METHODS.items() if not (method.series or method.carries)}
Tree = tuple["Tree", ...]  # a root's branches, sorted
NUMBER_OF_TREES = [1, 1, 2, 4, 9, 20, 48, 115, 286]  # of order 1, 2, ... (A000081)
DIGITS = {
    "radau5": 1e-40,
    "radau9": 1e-40,
    "tsit54": 1e-38,
    "dop853": 1e-28,
}  # to which published coefficients fulfil the conditions; the others exactly


def trees(order: int) -> list[Tree]:
    """All rooted trees with so many vertices."""
    return sorted({tuple(sorted(forest)) for forest in forests(order - 1)})


def forests(vertices: int) -> Iterator[Tree]:
    if vertices == 0:
        yield ()
    for first in range(1, vertices + 1):
        for tree in trees(first):
            for rest in forests(vertices - first):
                yield (tree, *rest)


def size(tree: Tree) -> int:
    return 1 + sum(size(branch) for branch in tree)


def density(tree: Tree) -> int:
    """gamma(t)."""
    product = size(tree)
    for branch in tree:
        product *= density(branch)
    return product


@cache
def derivative_weights(tableau: Tableau, tree: Tree) -> tuple[Fraction, ...]:
    """The elementary weights of all stages: products over branches of sum_j a_ij times those of the branch."""
    weights = [Fraction(1)] * len(tableau.stages)
    for branch in tree:
        inner = derivative_weights(tableau, branch)
        weights = [w * sum((a * x for a, x in zip(row, inner, strict=False)), Fraction(0))
                   for w, row in zip(weights, tableau.stages, strict=True)]  # fmt: skip
    return tuple(weights)


def sum_of(b: Sequence[Fraction], tableau: Tableau, tree: Tree) -> Fraction:
    return sum((x * w for x, w in zip(b, derivative_weights(tableau, tree), strict=False)), Fraction(0))


def holds(tableau: Tableau, tree: Tree) -> bool:
    return abs(sum_of(tableau.b, tableau, tree) - Fraction(1, density(tree))) <= DIGITS.get(tableau.name, 0)


def most(b: Sequence[Fraction], tableau: Tableau, order: int, s: Fraction | int) -> float:
    """By how much the conditions of an order are missed at the fraction s of a step; s = 0: those of a difference."""
    every = trees(order)
    return float(max(abs(sum_of(b, tableau, tree) - Fraction(s**order, density(tree))) for tree in every))


ERRORS = {"bs32": [3], "dp54": [5], "tsit54": [5], "dop853": [6, 4]}  # of one step, that each estimate sees first
EXTENSIONS = {"radau3": 2, "radau9": 5, "dp54": 4, "tsit54": 4, "dop853": 7}  # of the continuous one; else 3 at most
PRINTED = {"radau5": 1e-30, "radau9": 1e-30, "tsit54": 1e-15, "dop853": 1e-26}  # digits of these


@pytest.mark.parametrize("name", ERRORS)
def test_estimates_see_the_error_of_their_order_and_nothing_below(name: str) -> None:
    tableau = METHODS[name]
    for weights, first in zip(tableau.errors, ERRORS[name], strict=True):
        assert all(most(weights, tableau, order, 0) <= PRINTED.get(name, 0) for order in range(1, first))
        assert most(weights, tableau, first, 0) > 1e-4


@pytest.mark.parametrize("tableau", TABLEAUS.values(), ids=TABLEAUS)
def test_extensions_have_their_order_everywhere_in_the_step(tableau: Tableau) -> None:
    order = EXTENSIONS.get(tableau.name, min(tableau.order, 3))
    assert tableau.extension(Fraction(0)) == (0,) * len(tableau.stages)
    end = tableau.extension(Fraction(1))
    assert end[: len(tableau.b)] == tableau.b
    assert not any(end[len(tableau.b) :])
    for s in (Fraction(1, 7), Fraction(1, 2), Fraction(9, 10)):
        weights = tableau.extension(s)
        assert all(most(weights, tableau, below, s) <= PRINTED.get(tableau.name, 0) for below in range(1, order + 1))
        assert most(weights, tableau, order + 1, s) > 1e-6


@pytest.mark.parametrize("name", ["radau3", "radau5", "radau9"])
def test_places_are_integrals_of_one_order_more(name: str) -> None:
    tableau = METHODS[name]
    nodes, s = tableau.c, Fraction(2, 5)
    for power in range(len(nodes) + 1):
        total = sum(w * c**power for w, c in zip(tableau.places(s), nodes, strict=False))
        missed = abs(total - s ** (power + 1) / (power + 1))
        assert (missed > 1e-6) if power == len(nodes) else (missed < 1e-30)
    assert tableau.places(Fraction(0)) == (0,) * len(tableau.stages)
    end = tableau.extension(Fraction(1))
    assert max(abs(a - b) for a, b in zip(tableau.places(Fraction(1)), end, strict=True)) < 1e-30


def test_there_are_as_many_trees_as_there_should_be() -> None:
    assert [len(trees(order)) for order in range(1, 10)] == NUMBER_OF_TREES
    assert [density(tree) for tree in trees(4)] == [4, 8, 12, 24]


@pytest.mark.parametrize("tableau", TABLEAUS.values(), ids=TABLEAUS)
def test_all_conditions_up_to_the_order_hold_and_one_of_the_next_fails(tableau: Tableau) -> None:
    for order in range(1, tableau.order + 1):
        assert all(holds(tableau, tree) for tree in trees(order)), order
    assert not all(holds(tableau, tree) for tree in trees(tableau.order + 1))


@pytest.mark.parametrize("tableau", TABLEAUS.values(), ids=TABLEAUS)
def test_tableaus_are_as_they_say_and_exact(tableau: Tableau) -> None:
    assert all(len(row) <= stage for stage, row in enumerate(tableau.A)) is not tableau.implicit
    assert len(tableau.A) == len(tableau.b) == len(tableau.c)
    assert tableau.c == tuple(sum(row) for row in tableau.A)
    assert all(isinstance(x, Fraction) for row in (*tableau.A, tableau.b, tableau.c) for x in row)


def test_the_methods_and_their_orders() -> None:
    orders = {name: tableau.order for name, tableau in METHODS.items()}
    assert orders == {"euler": 1, "midpoint": 2, "heun": 2, "kutta3": 3, "rk4": 4, "rk38": 4, "cf4": 4} | {
        "bs32": 3, "dp54": 5, "tsit54": 5, "dop853": 8, "taylor": 8, "radau3": 3, "radau5": 5,
        "radau9": 9, "generalized_alpha": 2,
    }  # fmt: skip


def test_classical_stages() -> None:
    assert [float(c) for c in METHODS["rk4"].c] == [0, 0.5, 0.5, 1]
    assert METHODS["rk38"].c == (0, Fraction(1, 3), Fraction(2, 3), 1)
    assert METHODS["kutta3"].c == (0, Fraction(1, 2), 1)
    assert METHODS["midpoint"].c == (0, Fraction(1, 2))
    assert METHODS["heun"].c == (0, 1)
