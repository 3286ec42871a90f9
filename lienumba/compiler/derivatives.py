"""Partial derivatives of what a graph computes.

The chain rule makes a graph of local derivatives along the edges from operands to results. Its inner nodes are
eliminated one by one: each edge into a node is multiplied with each edge out of it, and products that meet are summed
(Griewank and Walther, *Evaluating Derivatives*, 2008, chapter 9). From inputs to outputs this is the forward mode, the
other way the reverse mode; always the node with the fewest products (Markowitz) sees the sparsity on both sides.
Everything is recorded in the same graph, which shares what is repeated.

The graph has to be analytic (`Graph`), so that sin and cos are known as such. A comparison has no derivative: `where`
keeps the branch that it is in.
"""

from collections.abc import Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import Any

from lienumba.compiler.foreign import calls
from lienumba.compiler.series import JUMPS, rounds
from lienumba.compiler.symbols import FUSED, Symbol, live
from lienumba.numerics import operations
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero


def partials(outputs: Sequence[object], columns: Sequence[Mapping[Symbol, Number]]) -> dict[tuple[int, int], Any]:
    """The derivatives of outputs that are not exactly zero, by (output, column); each column says how the inputs change
    along it."""
    nodes = live(outputs)
    first = 1 + max((node.id for node in nodes), default=-1)  # columns and outputs are numbered behind the nodes
    behind = first + len(columns)
    chain = _Chain()
    for n, along in enumerate(columns, first):
        for symbol, value in along.items():
            chain.connect(n, symbol.id, value)
    for node in nodes:
        if node.op == "call" and any(isinstance(x, Symbol) and x.id in chain.into for x in node.args):
            raise calls.underivable(calls.name_of(node))
        for operand, value in slopes(node):
            if operand.id in chain.into:
                chain.connect(operand.id, node.id, value)
    for n, x in enumerate(outputs, behind):
        if isinstance(x, Symbol) and x.id in chain.into:
            chain.connect(x.id, n, 1.0)
    chain.eliminate([node.id for node in nodes if node.id in chain.into])
    return {
        (row, column - first): value
        for row in range(len(outputs))
        for column, value in sorted(chain.into.get(behind + row, {}).items())
        if not is_zero(value)
    }


class _Chain:
    """Derivatives along edges: into[y][x] is that of y by x."""

    def __init__(self) -> None:
        self.into: dict[int, dict[int, Any]] = {}
        self.out: dict[int, set[int]] = {}

    def connect(self, x: int, y: int, value: Any) -> None:
        if not is_zero(value):
            edges = self.into.setdefault(y, {})
            edges[x] = edges[x] + value if x in edges else value
            self.out.setdefault(x, set()).add(y)

    def _products(self, node: int) -> int:
        return len(self.into[node]) * len(self.out.get(node, ()))

    def eliminate(self, inner: Sequence[int]) -> None:
        """These nodes, always that with the fewest products."""
        left = set(inner)
        heap = [(self._products(node), node) for node in inner]
        heapify(heap)
        while heap:
            products, node = heappop(heap)
            if node not in left:
                continue
            if products != self._products(node):
                heappush(heap, (self._products(node), node))
                continue
            left.discard(node)
            before, after = self.into.pop(node), sorted(self.out.pop(node, ()))
            for x in before:
                self.out[x].discard(node)
            for y in after:
                b = self.into[y].pop(node)
                for x, a in before.items():
                    self.connect(x, y, product(b, a))
            for other in (*before, *after):
                if other in left:
                    heappush(heap, (self._products(other), other))


def product(a: Number, b: Number) -> Any:
    """a b, where what `where` does not choose may be infinite or NaN."""
    for x, y in ((a, b), (b, a)):
        if isinstance(x, Symbol) and x.op == "neg":
            return -product(x.args[0], y)
        if isinstance(x, Symbol) and x.op == "where" and any(map(is_zero, x.args[1:])):
            condition, *branches = x.args
            return operations.where(condition, *(0.0 if is_zero(p) else product(p, y) for p in branches))
    return a * b


def slopes(node: Symbol) -> list[tuple[Symbol, Any]]:
    """The derivatives of one operation by its operands; an operand that is there twice has two."""
    if node.op in ("input", "call", "part") or node.op in JUMPS or rounds(node):
        return []
    a, op = node.args, node.op
    found: Sequence[Any]
    if op in ("*", *FUSED):
        sign = -1.0 if op == "fnma" else 1.0
        found = (sign * a[1], sign * a[0], -1.0 if op == "fms" else 1.0)
    elif op in ("+", "-"):
        found = (1.0, 1.0 if op == "+" else -1.0)
    elif op == "neg":
        found = (-1.0,)
    elif op == "where":
        found = (0.0, operations.where(a[0], 1.0, 0.0), operations.where(a[0], 0.0, 1.0))
    elif op == "/":
        inverse = 1.0 / a[1]
        found = (inverse, -(node * inverse))
    elif op == "sqrt":
        positive = node > 0.0  # at 0 it counts as level, and with it what leans on it: the drag of what is at rest
        found = (operations.where(positive, 0.5 / operations.where(positive, node, 1.0), node),)
    elif op == "sin":
        found = (operations.cos(a[0]),)
    elif op == "cos":
        found = (-operations.sin(a[0]),)
    elif op == "exp":
        found = (node,)
    elif op == "log":
        found = (1.0 / a[0],)
    elif op == "power":  # at 0 it counts as level, as a root does
        x, p = a
        positive = x > 0.0
        found = (
            operations.where(positive, p * operations.power(x, p - 1.0), 0.0),
            operations.where(positive, node * operations.log(x), 0.0),
        )
    elif op == "tanh":
        found = (1.0 - node * node,)
    elif op == "atan2":
        square = a[0] * a[0] + a[1] * a[1]
        known = square > 0.0  # an angle of nothing counts as level
        inverse = 1.0 / operations.where(known, square, 1.0)
        found = tuple(operations.where(known, x * inverse, 0.0) for x in (a[1], -a[0]))
    else:
        raise ValueError(f"no derivative of the operation {op!r}")
    return [(x, value) for x, value in zip(a, found, strict=False) if isinstance(x, Symbol) and not is_zero(value)]
