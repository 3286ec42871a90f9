"""Series in time: from a recorded right-hand side to kernels that give the coefficients of its solution order by order.

Of x' = D(x) every operation has a recurrence (Moore 1966; Jorba and Zou, Experimental Mathematics 14 (2005)): its
coefficient k follows from those of its operands up to k, by products with coefficients 0 and by sums x_1 y_(k-1) + ...
of what is known since the last order. So an order is two functions: the sums of products of all operations
(`lienumba.compiler.loops.convolutions`), and straight-line code, in which k is a number like others: the size of the
code does not depend on the order. What depends on coefficients 0 alone, such as the pivots of an elimination, is
computed once, before the orders.

A comparison is decided by coefficients 0, so that `where` keeps its branch throughout a step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from lienumba.compiler.foreign import calls
from lienumba.compiler.symbols import COMPARISONS, FUSED, Graph, Symbol, live
from lienumba.numerics import operations
from lienumba.numerics.vector_math import ROUND

FULL, INNER = True, False  # sums over all products, or over those without a coefficient 0
BEFORE = ("state", "parameters", "clock")  # inputs that are known before the first order
NUMBER = "work"  # where the graph of everything has k, 1/k and 1/(k + 1), which the code of an order has in its clock
PLAIN, WEIGHTED, QUADRATURE, ASKED = "plain", "weighted", "quadrature", "asked"  # kinds of series
SLIGHT = 1e-12  # a root below this is 0 but for rounding
FLAT = 1e-13  # of what a power is taken: it has no series to any use below
LONGEST = 4  # products that are summed together
JUMPS = (*COMPARISONS, "power_of_two", "gather")  # constant but where they jump
# Where both of a sum are products, the second one is fused: so the fused one stands there again.
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": operations.divide,
    "fma": lambda a, b, c: c + a * b, "fms": lambda a, b, c: a * b - c, "fnma": lambda a, b, c: c - a * b,
    "neg": lambda a: -a, "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, "==": lambda a, b: a == b,
    "sqrt": operations.sqrt, "power": operations.power, "sin": operations.sin, "cos": operations.cos,
    "exp": operations.exp, "log": operations.log, "tanh": operations.tanh, "atan2": operations.atan2,
    "where": operations.where, "gather": operations.gather, "power_of_two": operations.power_of_two,
    "call": calls.call, "part": calls.part,
}  # fmt: skip


@dataclass(frozen=True)
class Sum:
    """sum of signs times x_j y_(k-j): (sign, x, y), first rows of series; full: over all j, or from 1 to k - 1."""

    full: bool
    terms: tuple[tuple[float, int, int], ...]


@dataclass(frozen=True)
class Orders:
    """The series of x' = D: of what is integrated, of what else is asked for, and of whatever sums read, one behind the
    other, each with its coefficients side by side.

    stride: rows from a series to the next one; rows: of all of them; start: (row, value) of coefficients 0 and 1;
    known: what orders read of what is known before. order: (row, value) of the coefficients k and k + 1, from the row
    of the first k on; its inputs are "state": what is known, and before it, at the rows -1, -2, ..., the sums; "extra":
    the coefficients k; "clock": k, 1/k, 1/(k + 1).
    """

    stride: int
    rows: int
    sums: tuple[Sum, ...]
    start: list[tuple[int, Any]]
    known: list[Any]
    order: list[tuple[int, Any]]


@dataclass(frozen=True)
class Linear:
    """Equations that are linear in unknown numbers, as A y = b: unknown: the inputs that stand for y; rest: b - A y;
    solve: on another graph, y from the rest without it, where A is that of the start. So A is eliminated once, and an
    order is one solution for b_k less the sum of A_j y_(k-j)."""

    unknown: Sequence[Symbol]
    rest: Sequence[object]
    solve: Callable[[Graph, Sequence[Any]], Sequence[Any]]


def orders(
    inputs: Sequence[Symbol],
    rates: Sequence[object],
    asked: Sequence[object],
    highest: int,
    linear: Linear | None = None,
) -> Orders:
    """inputs: of an analytic graph, what is integrated; rates: the derivative of each, and behind them those of
    quadratures; asked: what else is wanted as a series. All of these come first; highest: the last
    coefficient's order; linear: on what the rates depend without saying how."""
    return _Expansion(inputs, rates, asked, highest, linear or Linear((), (), lambda graph, rest: ())).made()


class _Expansion:
    def __init__(
        self,
        inputs: Sequence[Symbol],
        rates: Sequence[object],
        asked: Sequence[object],
        highest: int,
        linear: Linear,
    ) -> None:
        self.inputs, self.rates, self.asked, self.equations = inputs, rates, asked, linear
        self.stride = (highest + 1) | 1  # odd, so that coefficients of one order are spread over the cache
        self.partner = _partners(live([*rates, *asked, *linear.rest]))
        self.nodes = live([*rates, *asked, *linear.rest, *inputs, *linear.unknown, *self.partner.values()])
        self.unknown = {x.id for x in linear.unknown}
        self.graph = Graph()
        self.k, self.over_k, self.next_over = self.graph.inputs(NUMBER, 3)
        own = {x.id for x in inputs}
        self.moving: set[int] = set()
        self.ready: set[int] = set(own)  # whose coefficient k is known before order k
        self.linear: list[Symbol] = []  # of these, those that are computed from others
        for node in self.nodes:
            read = [x for x in node.args if isinstance(x, Symbol)]
            if node.id in own or node.id in self.unknown:
                self.moving.add(node.id)
            elif node.op not in JUMPS and not rounds(node) and any(x.id in self.moving for x in read):
                self.moving.add(node.id)
                if self._is_linear(node) and all(x.id in self.ready for x in read if x.id in self.moving):
                    self.ready.add(node.id)
                    self.linear.append(node)
        self.places: dict[tuple[str, int], int] = {}
        self.pairs: dict[Sum, int] = {}
        self.zero: dict[int, Any] = {}
        self.now: dict[int, Any] = {}

    def _is_linear(self, node: Symbol) -> bool:
        if node.op in ("+", "-", "neg"):
            return True
        factors = node.args[:2] if node.op in ("*", *FUSED) else ()
        return bool(factors) and not all(self._moves(x) for x in factors)

    def _moves(self, x: object) -> bool:
        return isinstance(x, Symbol) and x.id in self.moving

    # ------------------------------------------------------------ values
    def of(self, x: object, values: dict[int, Any]) -> Any:
        return values[x.id] if isinstance(x, Symbol) else x

    def at_start(self, x: object) -> Any:
        return self.of(x, self.zero)

    def here(self, x: object) -> Any:
        """The coefficient k."""
        if not self._moves(x):
            return 0.0
        assert isinstance(x, Symbol)
        if x.id in self.ready:
            return self.graph.input("extra", self.place(x))
        return self.now[x.id]

    def place(self, x: Symbol, kind: str = PLAIN) -> int:
        """The first row of a series."""
        return self.places.setdefault((kind, x.id), len(self.places) * self.stride)

    def sum_of(self, a: Symbol, b: Symbol, full: bool, kind: str = PLAIN) -> Any:
        """sum a_j b_(k-j); kind: of a's coefficients."""
        pair = Sum(full, ((1.0, self.place(a, kind), self.place(b)),))
        return self.graph.input("sums", self.pairs.setdefault(pair, len(self.pairs)))

    # ------------------------------------------------------------ the recurrences
    def product(self, a: Any, b: Any) -> Any:
        if not (self._moves(a) and self._moves(b)):
            a, b = (b, a) if self._moves(a) else (a, b)
            return self.at_start(a) * self.here(b)
        for x, y in ((a, b), (b, a)):  # a constant factor stays outside
            if x.op == "neg":
                return -self.product(x.args[0], y)
            if x.op == "*" and not all(map(self._moves, x.args)):
                constant, factor = x.args if self._moves(x.args[1]) else x.args[::-1]
                return self.at_start(constant) * self.product(factor, y)
        if a.id > b.id:
            a, b = b, a
        if a.id in self.ready and b.id in self.ready:
            return self.sum_of(a, b, FULL)
        found = self.sum_of(a, b, INNER)
        if a is b:
            return found + (2.0 * self.at_start(a)) * self.here(a)
        return (found + self.at_start(a) * self.here(b)) + self.at_start(b) * self.here(a)

    def function(self, node: Symbol) -> Any:
        a, op = node.args, node.op
        if op in ("*", "fma", "fms", "fnma"):
            found = self.product(a[0], a[1])
            if op == "*":
                return found
            c = self.here(a[2])
            return found + c if op == "fma" else found - c if op == "fms" else c - found
        if op in ("+", "-", "neg"):
            return FUNCTIONS[op](*map(self.here, a))
        if op == "where":
            return operations.where(self.at_start(a[0]), self.here(a[1]), self.here(a[2]))
        own, x = self.zero[node.id], a[0]
        if op == "/":
            inverse = 1.0 / self.at_start(a[1])
            if not self._moves(a[1]):
                return self.here(x) * inverse
            return ((self.here(x) - self.sum_of(a[1], node, INNER)) - self.here(a[1]) * own) * inverse
        if op == "sqrt":
            least = FLAT**0.5 if branches(node) else SLIGHT
            positive = own > least  # at 0 it has no series: it stays there until the first step shows what it becomes
            half = operations.where(positive, 0.5 / operations.where(positive, own, 1.0), 0.0)
            return (self.here(x) - self.sum_of(node, node, INNER)) * half
        if op == "exp":
            return self.over_k * self.sum_of(x, node, INNER, WEIGHTED) + self.here(x) * own
        if op == "log":
            return (self.here(x) - self.over_k * self.sum_of(node, x, INNER, WEIGHTED)) * (1.0 / self.at_start(x))
        if op == "power":
            return self._power(node)
        if op in ("sin", "cos"):
            other = self.partner[node.id]
            found = self.over_k * self.sum_of(x, other, INNER, WEIGHTED) + self.here(x) * self.at_start(other)
            return found if op == "sin" else -found
        if op == "tanh":
            slope = self.partner[node.id]
            return self.over_k * self.sum_of(x, slope, INNER, WEIGHTED) + self.here(x) * self.at_start(slope)
        if op == "atan2":
            return self._angle(node)
        if op == "call":
            raise calls.underivable(calls.name_of(node))
        raise ValueError(f"no series for the operation {op!r}")

    def _power(self, node: Symbol) -> Any:
        """x times the derivative is p x' x^p; at 0 it has no series, as a root has none."""
        x, p = node.args
        exponent, start = self.at_start(p), self.at_start(x)
        sums = exponent * self.sum_of(x, node, INNER, WEIGHTED) - self.sum_of(node, x, INNER, WEIGHTED)
        found = self.over_k * sums + (exponent * self.here(x)) * self.zero[node.id]
        positive = start > FLAT
        return operations.where(positive, found / operations.where(positive, start, 1.0), 0.0)

    def _angle(self, node: Symbol) -> Any:
        """x^2 + y^2 times the derivative is x y' - y x'; where both are 0 it has no series, as a root has none."""
        square, found = self.partner[node.id], -self.sum_of(node, self.partner[node.id], INNER, WEIGHTED)
        y, x = node.args
        newest: Any = 0.0
        for sign, a, b in ((1.0, y, x), (-1.0, x, y)):
            if self._moves(a):
                newest = newest + (sign * self.here(a)) * self.at_start(b)
                found = found + sign * self.sum_of(a, b, INNER, WEIGHTED) if self._moves(b) else found
        start = self.at_start(square)
        known = start > 0.0
        inverse = 1.0 / operations.where(known, start, 1.0)
        return operations.where(known, (self.over_k * found + newest) * inverse, 0.0)

    # ------------------------------------------------------------ all of it
    def made(self) -> Orders:
        self._evaluate(self.zero, self._first)
        for x in self.inputs:
            self.place(x)
        quadratures = self.rates[len(self.inputs) :]
        for kind, every in ((QUADRATURE, quadratures), (ASKED, self.asked)):
            self.places |= {(kind, n): (len(self.places) + n) * self.stride for n in range(len(every))}
        self._evaluate(self.now, lambda node: self.function(node) if self._waits(node) else None)
        first = self._ahead([self.at_start(rate) for rate in self.rates])
        after = [self.here(rate) * self.next_over for rate in self.rates]
        later = self._ahead(after)
        asked = [self.here(x) for x in self.asked]  # before the slice is measured: what is ready gets a place by this
        by_id = {node.id: node for node in self.nodes}
        start: list[tuple[int, Any]] = []
        order: list[tuple[int, Any]] = []
        for (kind, n), place in self.places.items():
            if kind == QUADRATURE:
                number = len(self.inputs) + n
                start += [(place, 0.0), (place + 1, self.at_start(self.rates[number]))]
                order.append((place + 1, after[number]))
            elif kind == ASKED:
                start.append((place, self.at_start(self.asked[n])))
                order.append((place, asked[n]))
            elif kind == WEIGHTED:
                start.append((place, 0.0))
                order.append((place, self.k * self.here(by_id[n])))
            elif n in self.ready:
                start += [(place, self.zero[n]), (place + 1, first[n])]
                order.append((place + 1, later[n]))
            else:
                start.append((place, self.zero[n]))
                order.append((place, self.now[n]))
        return _split(self.graph, list(self.pairs), self.stride, len(self.places), start, order)

    def _first(self, node: Symbol) -> Any:
        return (
            self.graph.input(*node.args) if node.op == "input" else FUNCTIONS[node.op](*map(self.at_start, node.args))
        )

    def _waits(self, node: Symbol) -> bool:
        """Whether its coefficient k is to be computed in order k."""
        return node.id in self.moving and node.id not in self.ready

    def _evaluate(self, values: dict[int, Any], value: Callable[[Symbol], Any]) -> None:
        """Of all nodes one coefficient: first as if the unknown had none, then with what the equations make of it. What
        the two have in common is there once, since sums end with the newest products."""
        values |= dict.fromkeys(self.unknown, 0.0)
        late = set(self.unknown)
        for node in self.nodes:
            if node.id not in late:
                values[node.id] = value(node)
        if not late:
            return
        of = self.at_start if values is self.zero else self.here
        solved = self.equations.solve(self.graph, [of(x) for x in self.equations.rest])
        values |= {x.id: y for x, y in zip(self.equations.unknown, solved, strict=True)}
        for node in self.nodes:
            if any(isinstance(x, Symbol) and x.id in late for x in node.args):
                late.add(node.id)
                values[node.id] = value(node)

    def _ahead(self, coefficients: Sequence[Any]) -> dict[int, Any]:
        """Of all that is ready the next coefficient, from those of what is integrated."""
        values = {x.id: c for x, c in zip(self.inputs, coefficients, strict=False)}
        for node in self.linear:
            x: list[Any] = [values[a.id] if self._moves(a) else None for a in node.args]
            if node.op in ("+", "-", "neg"):
                values[node.id] = FUNCTIONS[node.op](*(0.0 if c is None else c for c in x))
                continue
            constant, factor = (node.args[0], x[1]) if x[0] is None else (node.args[1], x[0])
            found = 0.0 if factor is None else self.at_start(constant) * factor
            if node.op != "*":
                c = 0.0 if x[2] is None else x[2]
                found = {"fma": found + c, "fms": found - c, "fnma": c - found}[node.op]
            values[node.id] = found
        return values


def branches(node: Symbol) -> bool:
    """Whether a function has a series beside 0 for as far as 0 is: a power, or the root of a size, as of what passes 0;
    a root of squares is 0 for a moment, and this for as long."""
    return node.op == "power" or (node.op == "sqrt" and node.args[0].op == "where")


def _partners(nodes: Sequence[Symbol]) -> dict[int, Symbol]:
    """What the recurrences of some functions ask for beside them: of sines the cosine, of tanh the
    derivative, of angles the square."""
    found: dict[int, Symbol] = {}
    for node in nodes:
        if node.op in ("sin", "cos"):
            pair = [node.graph.node(op, *node.args) for op in ("sin", "cos")]
            found |= {pair[0].id: pair[1], pair[1].id: pair[0]}
        elif node.op == "tanh":
            found[node.id] = 1.0 - node * node
        elif node.op == "atan2":
            y, x = node.args
            found[node.id] = y * y + x * x
    return found


def rounds(node: Symbol) -> bool:
    """Whether it adds what leaves whole numbers only."""
    return node.op in ("+", *FUSED) and any(not isinstance(x, Symbol) and abs(x) == ROUND for x in node.args)


def _split(
    graph: Graph,
    pairs: Sequence[Sum],
    stride: int,
    count: int,
    start: list[tuple[int, Any]],
    order: list[tuple[int, Any]],
) -> Orders:
    """What is known before the first order apart from what each order computes. Sums of which only another sum is made
    become one."""
    nodes = live([x for _, x in order])
    uses: dict[int, int] = {}
    for args in (*(node.args for node in nodes), [x for _, x in order]):
        for x in args:
            if isinstance(x, Symbol):
                uses[x.id] = uses.get(x.id, 0) + 1
    late: set[int] = set()
    made, known, sums = Graph(), dict[int, int](), dict[Sum, int]()
    values: dict[int, Any] = {}  # a value, or a sum that nobody has asked for yet

    def value(x: Any) -> Any:
        if not isinstance(x, Symbol):
            return x
        if x.id in late:
            if isinstance(values[x.id], Sum):
                values[x.id] = made.input("state", -1 - sums.setdefault(values[x.id], len(sums)))
            return values[x.id]
        if x.invariant:
            if x.id not in values:
                values[x.id] = made.input(*x.args) if x.op == "input" else made.node(x.op, *(value(a) for a in x.args))
            return values[x.id]
        return made.input("state", known.setdefault(x.id, len(known)))

    def merged(node: Symbol) -> Sum | None:
        if node.op not in ("+", "-", "neg"):
            return None
        own = [values.get(x.id) if isinstance(x, Symbol) and uses[x.id] == 1 else None for x in node.args]
        parts = [x for x in own if isinstance(x, Sum)]
        if len(parts) < len(node.args) or len({part.full for part in parts}) > 1:
            return None
        signs = (-1.0,) if node.op == "neg" else (1.0, 1.0 if node.op == "+" else -1.0)
        terms = tuple((s * t, x, y) for s, part in zip(signs, parts, strict=True) for t, x, y in part.terms)
        return Sum(parts[0].full, terms) if len(terms) <= LONGEST else None

    for node in nodes:
        if node.op == "input":
            if node.args[0] in BEFORE:
                continue
            array, row = node.args
            values[node.id] = pairs[row] if array == "sums" else made.input("clock" if array == NUMBER else array, row)
            late.add(node.id)
        elif any(isinstance(x, Symbol) and x.id in late for x in node.args):
            values[node.id] = merged(node) or made.node(node.op, *(value(x) for x in node.args))
            late.add(node.id)
    outputs = [(row, value(x)) for row, x in order]
    return Orders(stride, stride * count, tuple(sums), start, [graph.nodes[id_] for id_ in known], outputs)
