"""Symbols: numbers that record what is computed with them.

Exact zeros and ones fold away, repeated expressions are shared, and a product that meets a sum is fused at once
into an explicit multiply-add. Each rule looks at one operation alone, never at how often its result is used: so
what is stored cannot change what is computed, and the recorded graph fixes every bit of the result.
"""

import gc
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from threading import Lock
from typing import Any

from lienumba.numerics.number import Condition, Number
from lienumba.numerics.operations import absolute, power

COMPARISONS = ("<", "<=", "==")
FUSED = ("fma", "fms", "fnma")  # a*b + c, a*b - c, c - a*b


_inside: list[bool] = []  # for everyone in `uncollected`, whether garbage was collected when the first came
_lock = Lock()


@contextmanager
def uncollected() -> Iterator[None]:
    """Millions of small objects are made here, and nearly all stay: walking through them again and again to look for
    garbage would double the time. For any number of threads."""
    with _lock:
        _inside.append(_inside[0] if _inside else gc.isenabled())
        gc.disable()
    try:
        yield
    finally:
        with _lock:
            enabled = _inside.pop()
            if enabled and not _inside:
                gc.enable()


class Graph:
    """The operations of one kernel, in the order in which they were recorded."""

    def __init__(self) -> None:
        self.nodes: list[Symbol] = []
        self._memo: dict[tuple[Any, ...], Symbol] = {}

    def input(self, array: str, row: int) -> "Symbol":
        return self.node("input", array, row)

    def inputs(self, array: str, rows: int, first: int = 0) -> tuple["Symbol", ...]:
        return tuple(self.input(array, first + row) for row in range(rows))

    def node(self, op: str, *args: Any) -> "Symbol":
        key = (op, *[a.id if a.__class__ is Symbol else a.hex() if a.__class__ is float else (a,) for a in args])
        symbol = self._memo.get(key)
        if symbol is None:
            symbol = self._memo[key] = Symbol(self, len(self.nodes), op, args)
            self.nodes.append(symbol)
        return symbol

    def recorded(self) -> tuple[Hashable, ...]:
        """All operations and their order, as a key."""
        return tuple(self._memo)


class Symbol:
    """One value of a graph. `invariant`: depends on parameters alone. `upper`: a promised bound (see at_most)."""

    __slots__ = ("args", "graph", "id", "invariant", "op", "upper")
    __array_ufunc__ = None  # array + symbol asks the symbol

    def __init__(self, graph: Graph, id_: int, op: str, args: tuple[Any, ...]) -> None:
        self.graph, self.id, self.op, self.args = graph, id_, op, args
        self.upper = float("inf")
        if op == "input":
            self.invariant = args[0] == "parameters"
        else:
            self.invariant = all(a.invariant for a in args if isinstance(a, Symbol))

    # ------------------------------------------------------------ arithmetic
    def __add__(self, other: Number) -> Any:
        if not isinstance(other, Symbol):
            if not isinstance(other, float | int):
                return NotImplemented
            return self if other == 0 else self._sum(float(other))
        if other.op == "neg":
            return self - other.args[0]
        if self.op == "neg":
            return other - self.args[0]
        return self._sum(other)

    def _sum(self, other: Number) -> "Symbol":
        node = self.graph.node
        if isinstance(other, Symbol):
            if other.op == "*":
                return node("fma", *other.args, self)
            if self.op == "*":
                return node("fma", *self.args, other)
            return node("+", *((self, other) if self.id <= other.id else (other, self)))
        return node("fma", *self.args, other) if self.op == "*" else node("+", self, other)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Any:
        node = self.graph.node
        if not isinstance(other, Symbol):
            return self + -other if isinstance(other, float | int) else NotImplemented
        if other.op == "neg":
            return self + other.args[0]
        if self is other:
            return 0.0
        if self.op == "neg":
            return -(self.args[0] + other)
        if other.op == "*":
            return node("fnma", *other.args, self)
        return node("fms", *self.args, other) if self.op == "*" else node("-", self, other)

    def __rsub__(self, other: float) -> Any:
        if other == 0:
            return -self
        if self.op == "neg":
            return self.args[0] + other
        node = self.graph.node
        return node("fnma", *self.args, float(other)) if self.op == "*" else node("-", float(other), self)

    def __mul__(self, other: Number) -> Any:
        if not isinstance(other, Symbol):
            if not isinstance(other, float | int):
                return NotImplemented
            if other == 0:
                return 0.0
            if other == 1:
                return self
            if other == -1:
                return -self
            if self.op == "neg":
                return self.args[0] * -other
            return self.graph.node("*", self, float(other))
        if self.op == "neg":
            return -(self.args[0] * other)
        if other.op == "neg":
            return -(self * other.args[0])
        return self.graph.node("*", *((self, other) if self.id <= other.id else (other, self)))

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Any:
        if not isinstance(other, Symbol):
            if not isinstance(other, float | int):
                return NotImplemented
            return self if other == 1 else -self if other == -1 else self.graph.node("/", self, float(other))
        if self.op == "neg":
            return -(self.args[0] / other)
        if other.op == "neg":
            return -(self / other.args[0])
        return self.graph.node("/", self, other)

    def __rtruediv__(self, other: float) -> Any:
        if other == 0:
            return 0.0
        if self.op == "neg":
            return -(other / self.args[0])
        return self.graph.node("/", float(other), self)

    def __neg__(self) -> "Symbol":
        if self.op == "neg":
            return self.args[0]
        if self.op == "-":
            return self.graph.node("-", self.args[1], self.args[0])
        return self.graph.node("neg", self)

    # ------------------------------------------------------------ comparisons and choice
    def __lt__(self, other: Number) -> Any:
        if not isinstance(other, Symbol) and self.upper < other:
            return True
        return self.graph.node("<", self, other)

    def __le__(self, other: Number) -> Any:
        if not isinstance(other, Symbol) and self.upper <= other:
            return True
        return self.graph.node("<=", self, other)

    def __gt__(self, other: Number) -> Any:
        return self.graph.node("<", other, self)

    def __ge__(self, other: Number) -> Any:
        return self.graph.node("<=", other, self)

    def __eq__(self, other: object) -> Any:
        return self.graph.node("==", self, other)

    def __hash__(self) -> int:
        return self.id

    def __pos__(self) -> "Symbol":
        return self

    def __abs__(self) -> Any:
        return absolute(self)

    def __pow__(self, p: Number) -> Any:
        return power(self, p)

    def __repr__(self) -> str:
        return f"Symbol({self.op}, {self.id})"

    def __bool__(self) -> bool:
        raise TypeError("a kernel may not branch on a number: use where(condition, x, y)")

    def where(self, condition: Condition, x: Number, y: Number) -> Any:
        if not isinstance(y, Symbol) and hasattr(y, "where"):
            return y.where(condition, x, y)  # a jet
        return x if x is y else self.graph.node("where", condition, x, y)

    def at_most(self, bound: float) -> "Symbol":
        self.upper = min(self.upper, bound)
        return self

    # ------------------------------------------------------------ functions
    def sqrt(self) -> "Symbol":
        return self.graph.node("sqrt", self)

    def gather(self, index: Number) -> "Symbol":
        """The entry at an index of the numbers whose address this symbol is, in every lane the same."""
        return self.graph.node("gather", self, index)

    def power_of_two(self) -> "Symbol":
        return self.graph.node("power_of_two", self)


def live(outputs: Sequence[object]) -> list[Symbol]:
    """The nodes that the outputs need, each behind all that it uses.

    What depends on a division stays in the order in which it was recorded: an elimination frees values as
    it goes. Everything else comes from inputs alone and is computed when it is first used, so that few values wait.
    """
    found: dict[int, Symbol] = {}
    stack = [x for x in outputs if isinstance(x, Symbol)]
    while stack:
        node = stack.pop()
        if node.id not in found:
            found[node.id] = node
            stack += [x for x in node.args if isinstance(x, Symbol)]
    settled: set[int] = set()
    for id_ in sorted(found):
        node = found[id_]
        if (node.op == "/" and not node.invariant) or any(isinstance(x, Symbol) and x.id in settled for x in node.args):
            settled.add(id_)
    order: dict[int, Symbol] = {}
    for root in [*(found[id_] for id_ in sorted(settled)), *outputs]:
        stack = [root] if isinstance(root, Symbol) else []
        while stack:
            waiting = [x for x in stack[-1].args if isinstance(x, Symbol) and x.id not in order]
            if waiting:
                stack += reversed(waiting)
            else:
                node = stack.pop()
                order.setdefault(node.id, node)
    return list(order.values())


def operation_counts(order: list[Symbol]) -> dict[str, int]:
    """How many of each kind; `flops` counts a fused multiply-add as two."""
    counts = {"add": 0, "multiply": 0, "fma": 0, "divide": 0, "sqrt": 0, "select": 0}
    kinds = {"+": "add", "-": "add", "*": "multiply", "/": "divide", "sqrt": "sqrt", "power_of_two": "select"}
    kinds |= dict.fromkeys(FUSED, "fma") | dict.fromkeys((*COMPARISONS, "where"), "select")
    for node in order:
        if node.op in kinds:
            counts[kinds[node.op]] += 1
    arithmetic = counts["add"] + counts["multiply"] + 2 * counts["fma"] + counts["divide"] + counts["sqrt"]
    return counts | {"operations": sum(counts.values()), "flops": arithmetic}
