"""Symbols: numbers that record what is computed with them.

Exact zeros and ones fold away, repeated expressions are shared, and a product that meets a sum is fused at once
into an explicit multiply-add. Each rule looks at one operation alone, never at how often its result is used: so
what is stored cannot change what is computed, and the recorded graph fixes every bit of the result.
"""

import gc
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from math import inf
from threading import Lock
from typing import Any

from lienumba.numerics import vector_math
from lienumba.numerics.number import Condition, Number
from lienumba.numerics.operations import absolute, exp, piecewise_tanh, power

COMPARISONS = ("<", "<=", "==")
FUSED = ("fma", "fms", "fnma")  # a*b + c, a*b - c, c - a*b
NUMBERS = (float, int)


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
    """The operations of one kernel, in the order in which they were recorded.

    analytic: whether sin, cos, exp, log, tanh and atan2 are operations of their own, for whoever expands the graph into
    series (`lienumba.compiler.series`); else they are the polynomials that machine code has for them.
    """

    def __init__(self, analytic: bool = False) -> None:
        self.analytic = analytic
        self.nodes: list[Symbol] = []
        self.bounds: dict[int, float] = {}  # promised, see at_most
        self.alike: set[int] = set()  # conditions, see alike
        self._memo: dict[tuple[Any, ...], Symbol] = {}

    def input(self, array: str, row: int) -> "Symbol":
        return self.node("input", array, row)

    def inputs(self, array: str, rows: int, first: int = 0) -> tuple["Symbol", ...]:
        return tuple(self.input(array, first + row) for row in range(rows))

    def node(self, op: str, *args: Any) -> "Symbol":
        key = (op, *[a.id if a.__class__ is Symbol else a.hex() if a.__class__ is float else (a,) for a in args])
        known = self._memo.get(key)
        return self._new(key, op, args) if known is None else known

    def pair(self, op: str, a: "Symbol", b: "Symbol") -> "Symbol":
        """`node` of two symbols."""
        key = (op, a.id, b.id)
        known = self._memo.get(key)
        return self._new(key, op, (a, b)) if known is None else known

    def fused(self, op: str, product: "Symbol", c: "Symbol") -> "Symbol":
        """`node` of a product's factors, of which the second may be a number, and a symbol."""
        a, b = args = product.args
        key = (op, a.id, b.id if b.__class__ is Symbol else b.hex(), c.id)
        known = self._memo.get(key)
        return self._new(key, op, (*args, c)) if known is None else known

    def _new(self, key: tuple[Any, ...], op: str, args: tuple[Any, ...]) -> "Symbol":
        symbol = self._memo[key] = Symbol(self, len(self.nodes), op, args)
        self.nodes.append(symbol)
        return symbol

    def recorded(self) -> tuple[Hashable, ...]:
        """All operations and their order, as a key."""
        return tuple(self._memo)

    def close(self) -> None:
        """Nothing more is recorded or looked for: operations go when nobody holds them, without the collector, which
        would have to walk through all of them."""
        self._memo.clear()
        self.nodes.clear()


class Symbol:
    """One value of a graph. `invariant`: depends on parameters alone."""

    __slots__ = ("args", "graph", "id", "invariant", "op")
    __array_ufunc__ = None  # array + symbol asks the symbol

    def __init__(self, graph: Graph, id_: int, op: str, args: tuple[Any, ...]) -> None:
        self.graph = graph
        self.id = id_
        self.op = op
        self.args = args
        self.invariant: bool = op != "input" or args[0] == "parameters"
        for a in args:
            if a.__class__ is Symbol and not a.invariant:
                self.invariant = False
                break

    # ------------------------------------------------------------ arithmetic
    def __add__(self, other: Number) -> Any:
        if other.__class__ is not Symbol:
            if not isinstance(other, NUMBERS):
                return NotImplemented
            return self if other == 0 else self._plus_number(float(other))
        if other.op == "neg":
            return self - other.args[0]
        if self.op == "neg":
            return other - self.args[0]
        return self._plus(other)

    def _plus(self, other: "Symbol") -> "Symbol":
        if other.op == "*":
            return self.graph.fused("fma", other, self)
        if self.op == "*":
            return self.graph.fused("fma", self, other)
        return self.graph.pair("+", self, other) if self.id <= other.id else self.graph.pair("+", other, self)

    def _plus_number(self, other: float) -> "Symbol":
        node = self.graph.node
        return node("fma", *self.args, other) if self.op == "*" else node("+", self, other)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Any:
        if other.__class__ is not Symbol:
            return self + -other if isinstance(other, NUMBERS) else NotImplemented
        if other.op == "neg":
            return self + other.args[0]
        if self is other:
            return 0.0
        if self.op == "neg":
            return -(self.args[0] + other)
        if other.op == "*":
            return self.graph.fused("fnma", other, self)
        return self.graph.fused("fms", self, other) if self.op == "*" else self.graph.pair("-", self, other)

    def __rsub__(self, other: float) -> Any:
        if other == 0:
            return -self
        if self.op == "neg":
            return self.args[0] + other
        node = self.graph.node
        return node("fnma", *self.args, float(other)) if self.op == "*" else node("-", float(other), self)

    def __mul__(self, other: Number) -> Any:
        if other.__class__ is not Symbol:
            if not isinstance(other, NUMBERS):
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
        return self.graph.pair("*", self, other) if self.id <= other.id else self.graph.pair("*", other, self)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Any:
        if other.__class__ is not Symbol:
            if not isinstance(other, NUMBERS):
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
        if other.__class__ is not Symbol:
            if not isinstance(other, NUMBERS):
                return NotImplemented
            if self.upper < other:
                return True
        return self.graph.node("<", self, other)

    def __le__(self, other: Number) -> Any:
        if other.__class__ is not Symbol:
            if not isinstance(other, NUMBERS):
                return NotImplemented
            if self.upper <= other:
                return True
        return self.graph.node("<=", self, other)

    def __gt__(self, other: Number) -> Any:
        known = other.__class__ is Symbol or isinstance(other, NUMBERS)
        return self.graph.node("<", other, self) if known else NotImplemented

    def __ge__(self, other: Number) -> Any:
        known = other.__class__ is Symbol or isinstance(other, NUMBERS)
        return self.graph.node("<=", other, self) if known else NotImplemented

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
        self.graph.bounds[self.id] = min(self.upper, bound)
        return self

    def alike(self) -> "Symbol":
        self.graph.alike.add(self.id)
        return self

    @property
    def upper(self) -> float:
        """A promised bound."""
        return self.graph.bounds.get(self.id, inf)

    # ------------------------------------------------------------ functions
    def sqrt(self) -> "Symbol":
        return self.graph.node("sqrt", self)

    def gather(self, index: Number) -> "Symbol":
        """The entry at an index of the numbers whose address this symbol is."""
        return self.graph.node("gather", self, index)

    def power_of_two(self) -> "Symbol":
        return self.graph.node("power_of_two", self)

    def sin(self) -> Any:
        return self.graph.node("sin", self) if self.graph.analytic else vector_math.sin(self)

    def cos(self) -> Any:
        return self.graph.node("cos", self) if self.graph.analytic else vector_math.cos(self)

    def exp(self) -> Any:
        return self.graph.node("exp", self) if self.graph.analytic else vector_math.exp(self)

    def log(self) -> Any:
        return self.graph.node("log", self) if self.graph.analytic else vector_math.log(self)

    def power(self, p: Number) -> Any:
        """p: a number that is not whole. At 0 x^p has a series and a derivative, and exp(p log x) has none."""
        if isinstance(p, float) and p == 0.5:
            return self.sqrt()
        given = p.invariant if isinstance(p, Symbol) else isinstance(p, float)
        return self.graph.node("power", self, p) if given and self.graph.analytic else exp(p * self.log())

    def tanh(self) -> Any:
        return self.graph.node("tanh", self) if self.graph.analytic else piecewise_tanh(self)

    def atan2(self, y: Number, x: Number) -> Any:
        for number in (y, x):
            if not isinstance(number, Symbol) and hasattr(number, "atan2"):
                return number.atan2(y, x)  # a jet
        return self.graph.node("atan2", y, x) if self.graph.analytic else vector_math.atan2(y, x)


def live(outputs: Sequence[object]) -> list[Symbol]:
    """The nodes that the outputs need, each behind all that it uses.

    What depends on a division stays in the order in which it was recorded: an elimination frees values as
    it goes. Everything else comes from inputs alone and is computed when it is first used, so that few values wait.
    """
    roots = [x for x in outputs if isinstance(x, Symbol)]
    if not roots:
        return []
    nodes = roots[0].graph.nodes
    size = max(root.id for root in roots) + 1
    needed, settled, done = bytearray(size), bytearray(size), bytearray(size)
    for root in roots:
        needed[root.id] = 1
    read: dict[int, list[Symbol]] = {}
    for id_ in range(size - 1, -1, -1):
        if needed[id_]:
            read[id_] = used = [x for x in nodes[id_].args if x.__class__ is Symbol]
            for x in used:
                needed[x.id] = 1
    first = []
    for id_, used in reversed(read.items()):
        node = nodes[id_]
        if node.op == "/" and not node.invariant:
            settled[id_] = 1
            first.append(node)
            continue
        for x in used:
            if settled[x.id]:
                settled[id_] = 1
                first.append(node)
                break
    order: list[Symbol] = []
    for root in (*first, *roots):
        stack = [] if done[root.id] else [root]
        while stack:
            node = stack[-1]
            waiting = [x for x in read[node.id] if not done[x.id]]
            if waiting:
                waiting.reverse()
                stack += waiting
            else:
                del stack[-1]
                if not done[node.id]:
                    done[node.id] = 1
                    order.append(node)
    return order


def reached(outputs: Sequence[object]) -> list[Symbol]:
    """The nodes that the outputs need, in any order, which takes a third of the time of `live`."""
    found = {x.id: x for x in outputs if isinstance(x, Symbol)}
    stack = list(found.values())
    while stack:
        for x in stack.pop().args:
            if x.__class__ is Symbol and x.id not in found:
                found[x.id] = x
                stack.append(x)
    return list(found.values())


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
