"""Tangents of what a graph computes: how its outputs change where its inputs change in one direction.

Forward mode (Griewank and Walther, *Evaluating Derivatives*, 2008, chapter 3), node by node, recorded in the same
graph. A comparison has no tangent: `where` keeps the branch that it is in.
"""

from collections.abc import Mapping, Sequence

from lienumba.compiler.derivatives import slopes
from lienumba.compiler.foreign import calls
from lienumba.compiler.symbols import Symbol, live
from lienumba.numerics import operations
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero


def tangents(outputs: Sequence[Number], seeds: Mapping[Symbol, Number]) -> list[Number]:
    """The tangent of each output, where inputs have these tangents, and 0 otherwise."""
    known: dict[int, Number] = {symbol.id: tangent for symbol, tangent in seeds.items()}

    def of(x: Number) -> Number:
        return known.get(x.id, 0.0) if isinstance(x, Symbol) else 0.0

    for node in live(outputs):
        total: Number = 0.0
        if node.op == "where":
            condition, x, y = node.args
            changes = of(x), of(y)
            if not all(map(is_zero, changes)):
                total = operations.where(condition, *changes)
        elif node.op == "call":
            if any(not is_zero(of(x)) for x in node.args):
                raise calls.underivable(calls.name_of(node))
        elif any(isinstance(x, Symbol) and x.id in known for x in node.args):
            for operand, slope in slopes(node):
                if operand.id in known:
                    total = total + slope * known[operand.id]
        if not is_zero(total):
            known[node.id] = total
    return [of(x) for x in outputs]
