"""How large what a graph computes is a sum of: what rounding leaves of sums that should be 0.

To first order every input x changes a value by its derivative times dx. Where each change of an operand is carried to
the result by its size, so that none cancels another, and each dx is x itself, the value's change is the size of its
terms: times the unit of rounding, what rounding can make of it (running error analysis; Higham, *Accuracy and Stability
of Numerical Algorithms*, 2002, 3.3). Entries of rotations are rounded as those that are 1 are. What is exactly 0 has
none. Directions that follow from parameters alone count as given: across axes that are nearly parallel they are a
matter of rounding, and what is turned by them is turned back.
"""

from collections.abc import Container, Sequence
from typing import Any

from lienumba.compiler.derivatives import product, slopes
from lienumba.compiler.symbols import Symbol, live
from lienumba.numerics.operations import absolute, where

FUNCTIONS = ("sin", "cos", "exp", "log", "power", "tanh", "atan2")  # rounded themselves, where they hardly change, too
ROUNDED = 3e-16  # of the size of its terms: what a sum may be, and is not known by


def terms(values: Sequence[object], rotations: Container[tuple[str, int]] = ()) -> list[Any]:
    """The size of the terms of each value, recorded in its graph, which has to be analytic; numbers have none.
    rotations: inputs that are entries of these."""
    found: dict[int, Any] = {}
    for node in live(values):
        if node.op == "input":
            found[node.id] = 1.0 if node.args in rotations else absolute(node)
        else:
            found[node.id] = absolute(node) if _is_direction(node) else _carried(node, found)
    return [found[x.id] if isinstance(x, Symbol) else 0.0 for x in values]


def _is_direction(node: Symbol) -> bool:
    return node.invariant and node.op == "/" and isinstance(node.args[1], Symbol) and node.args[1].op == "sqrt"


def _carried(node: Symbol, found: dict[int, Any]) -> Any:
    if node.op == "where":
        condition, *branches = node.args
        return where(condition, *(found[x.id] if isinstance(x, Symbol) else 0.0 for x in branches))
    total: Any = absolute(node) if node.op in FUNCTIONS else 0.0
    for operand, slope in slopes(node):
        total = total + product(absolute(slope), found[operand.id])
    return total
