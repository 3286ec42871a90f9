"""Numbers written as formulas: "0.3*sin(2*t) + 0.1*t**2".

A formula is parsed by Python's own grammar, checked node by node against the short list below, and evaluated with the
named operations, so that it runs on floats, arrays, jets and symbols. Nothing is ever passed to `eval`.
"""

import ast
import copy
import math
import operator
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import reduce
from itertools import pairwise
from typing import Any

from lienumba.errors import BadValueError
from lienumba.numerics import operations
from lienumba.numerics.functions import FUNCTIONS, floor
from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, minimum, power, where
from lienumba.words import ALIKE, suggestion

CONSTANTS = {"pi": math.pi, "deg": math.pi / 180.0, "rpm": math.pi / 30.0}
LONGEST = 2000  # characters
DEEPEST = 200  # nested operations; a sum of n terms nests n - 1
SHOWN = 80  # characters of a part in a message
WITHIN = "t within"  # the time that tells in which piece of a table t lies, and on which side of a comparison, where
# this is not t itself; and the names that are no functions of the time. Only for straight lines in t: there steps land.
LARGEST_POWER = 64  # of an exponent that is a whole number
HOLDS = 1e-300  # the margin of what holds where both sides are equal


Names = Mapping[str, Any]  # numbers, and tables, which are called with two
WHOLE = ("floor", "ceil", "mod")  # functions that jump where a whole number is reached
KINKED = (*WHOLE, "abs", "sign", "min", "max", "clip", "where")
OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda x, y: x + y,
    ast.Sub: lambda x, y: x - y,
    ast.Mult: lambda x, y: x * y,
    ast.Div: operations.divide,
    ast.Pow: power,
}
COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: lambda x, y: x < y,
    ast.LtE: lambda x, y: x <= y,
    ast.Gt: lambda x, y: x > y,
    ast.GtE: lambda x, y: x >= y,
}


class ExpressionError(BadValueError):
    """What is wrong with a formula, and the remedy."""


class NotAFormulaError(ExpressionError):
    """A text that is not written as formulas are."""


@dataclass(frozen=True)
class Formula:
    """A number as a function of time, and of whatever other names are allowed: formula(t), formula(t, kp=40.0).

    allowed: may have dots and indices (pointing.x, points[1]); tables: names of functions of one number that are
    handed over as well;
    condition: whether it is one: a number that is above 0 where it holds;
    told: of names and tables those that a remedy may give, by default all.
    constant: its value if it depends on nothing, else None; used: the names that it depends on, tables included.
    """

    text: str
    allowed: frozenset[str] = frozenset({"t"})
    tables: frozenset[str] = frozenset()
    condition: bool = False
    told: frozenset[str] | None = field(compare=False, repr=False, default=None)
    constant: float | None = field(init=False, compare=False, default=None)
    used: frozenset[str] = field(init=False, compare=False, default=frozenset())
    _tree: ast.expr = field(init=False, compare=False, repr=False, default=ast.Constant(0.0))

    def __post_init__(self) -> None:
        if len(self.text) > LONGEST:
            raise ExpressionError(f"is {len(self.text)} characters long, at most {LONGEST} are allowed", "shorten it")
        try:
            tree = ast.parse(self.text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise NotAFormulaError("is not a formula", 'write one such as "0.3*sin(2*t) + 0.1*t**2"') from None
        used: set[str] = set()
        _check(tree, _Names(self.allowed, self.tables, used, self.told), 0)
        if is_condition(tree) and not self.condition:
            raise ExpressionError("is a condition, not a number", "write where(condition, number, other number)")
        if self.condition and not is_condition(tree):
            raise ExpressionError("is a number, not a condition", 'compare it, such as in "t > 0.5"')
        if self.condition and not used:
            raise ExpressionError("never changes", "name a quantity in it, or the time t")
        object.__setattr__(self, "_tree", tree)
        object.__setattr__(self, "used", frozenset(used))
        if not used:
            value = _value(tree, {})
            if not math.isfinite(value):
                raise ExpressionError(f"has the value {value}", "it must be a finite number")
            object.__setattr__(self, "constant", float(value))

    def __call__(self, t: Number, **names: Any) -> Any:
        return (_margin if self.condition else _value)(self._tree, {"t": t, **names})

    def bound(self, values: Mapping[str, float]) -> str:
        """The text of the same formula with numbers for these names."""
        return ast.unparse(_Binding(values).visit(copy.deepcopy(self._tree)))

    def rewritten(self, texts: Mapping[str, str], names: Iterable[str]) -> "Formula":
        """The same with other formulas, or names, for these names; names: that may stand in them besides."""
        trees = {name: ast.parse(text, mode="eval").body for name, text in texts.items()}
        written = ast.unparse(_Rewriting(trees).visit(copy.deepcopy(self._tree)))
        return Formula(written, self.allowed.union(names), self.tables, self.condition)

    def is_line(self, state: frozenset[str]) -> bool:
        """Whether it is a straight line in t, as it is written; state: the names that vary in time, too."""
        return _degree(self._tree, state) == 1

    @property
    def smooth(self) -> bool:
        """Whether it has, as it is written, neither kinks nor jumps."""
        nodes = list(ast.walk(self._tree))
        if any(isinstance(x, ast.BoolOp) or (isinstance(x, ast.Compare) and len(x.ops) > 1) for x in nodes):
            return False
        calls = [node.func for node in nodes if isinstance(node, ast.Call)]
        return not any(isinstance(x, ast.Name) and (x.id in KINKED or x.id in self.tables) for x in calls)

    def switches(self, state: frozenset[str]) -> list["Formula"]:
        """The differences of the straight lines in t that it compares; state: the names that vary in time, too."""
        found = []
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Compare):
                sides = [node.left, *node.comparators]
                for x, y in pairwise(sides):
                    difference = ast.BinOp(x, ast.Sub(), y)
                    if _degree(difference, state) == 1:
                        found.append(Formula(ast.unparse(difference), self.allowed, self.tables))
        return found

    def wholes(self, state: frozenset[str]) -> list["Formula"]:
        """The straight lines in t whose whole numbers are jumps of it; state: the names that vary in time, too."""
        found = []
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in WHOLE:
                line = node.args[0] if len(node.args) == 1 else ast.BinOp(node.args[0], ast.Div(), node.args[1])
                if _degree(line, state) == 1:
                    found.append(Formula(ast.unparse(line), self.allowed, self.tables))
        return found

    def may_hold(self, t: Any, state: frozenset[str], numbers: Mapping[str, Any]) -> Any:
        """Whether a condition may hold at times t, whatever varies in another way than a straight line in t; state: the
        names of what varies, too; numbers: the values of the others."""
        return _may_hold(self._tree, {**numbers, "t": t}, state)

    def table_calls(self) -> list[tuple[str, "Formula"]]:
        """The tables that it reads, each with the formula of its argument."""
        calls = [n for n in ast.walk(self._tree) if isinstance(n, ast.Call)]
        return [
            (n.func.id, Formula(ast.unparse(n.args[0]), self.allowed, self.tables))
            for n in calls
            if isinstance(n.func, ast.Name) and n.func.id in self.tables
        ]


@dataclass(frozen=True)
class _Names:
    """What a formula may name, and what it has named."""

    allowed: frozenset[str]
    tables: frozenset[str]
    used: set[str]
    told: frozenset[str] | None

    def remedies(self, names: frozenset[str]) -> list[str]:
        """Of these names those that may be told."""
        return sorted(names if self.told is None else names & self.told)

    @property
    def indexed(self) -> bool:
        """Whether names may have indices."""
        return any(name.endswith("]") for name in self.allowed)

    def may_be(self, name: str) -> bool:
        """Whether a name with dots may be meant as that of a quantity."""
        if name in self.allowed:
            return True
        first = name.partition(".")[0]
        return first != "" and not ({first} & (self.allowed | self.tables | CONSTANTS.keys() | FUNCTIONS.keys()))

    def check(self, name: str) -> None:
        """Raise an ExpressionError unless the name, which may have dots, is one of a number."""
        if name in self.allowed:
            self.used.add(name)
            return
        if name in CONSTANTS:
            return
        if name in FUNCTIONS or name in self.tables:
            what = "table" if name in self.tables else "function"
            raise ExpressionError(f'uses the {what} "{name}" without arguments', f"write {name}(...)")
        below = [x for x in self.remedies(self.allowed) if x.startswith((f"{name}.", f"{name}["))]
        if below:
            raise ExpressionError(f'uses "{name}", which has several numbers', f"write {' or '.join(below)}")
        known = sorted([*self.remedies(self.allowed), *CONSTANTS])
        raise ExpressionError(f'has the unknown name "{name}"', suggestion(name, known, ALIKE))


class _Replacing(ast.NodeTransformer):
    """Knows names of numbers: a function may have the same one."""

    def visit_Call(self, node: ast.Call) -> ast.expr:
        node.args = [self.visit(x) for x in node.args]
        return node


class _Binding(_Replacing):
    """Puts numbers in the place of names."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.values = values

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.Constant(self.values[node.id]) if node.id in self.values else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return self._bound(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return self._bound(node)

    def _bound(self, node: ast.expr) -> ast.expr:
        name = dotted(node)
        return ast.Constant(self.values[name]) if name in self.values else node


class _Rewriting(_Replacing):
    """Puts formulas in the place of names."""

    def __init__(self, trees: Mapping[str, ast.expr]) -> None:
        self.trees = trees

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self.trees.get(node.id, node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return self.trees.get(dotted(node), node)


def dotted(node: ast.AST) -> str:
    """The name with dots and indices that a node is; empty if it is anything else."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=inner, attr=name) if first := dotted(inner):
            return f"{first}.{name}"
        case ast.Subscript(value=inner, slice=ast.Constant(value=int() as index)) if first := dotted(inner):
            return f"{first}[{index}]"
    return ""


def _check(node: ast.AST, names: _Names, depth: int) -> None:
    """Raise an ExpressionError unless the node and all below it are in the list."""
    if depth > DEEPEST:
        raise ExpressionError(f"nests more than {DEEPEST} operations", "split it")
    below: list[ast.AST] = []
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            if not abs(value) < 1e300:
                raise ExpressionError(f"has the number {_text(node)}, which is too large")
        case ast.Name(id=name):
            names.check(name)
        case ast.Attribute() if names.may_be(name := dotted(node)):
            names.check(name)
        case ast.Subscript() if names.indexed and (name := dotted(node)):
            names.check(name)
        case ast.Attribute() if (first := dotted(node).partition(".")[0]) in (names.allowed | names.tables) - {"t"}:
            written = f"{first}(t)" if first in names.tables else first
            raise ExpressionError(f'reads "{dotted(node)}", but {first} has no components', f"write {written}")
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=x):
            below = [x]
        case ast.UnaryOp(op=ast.Not(), operand=x):
            _need_conditions([x])
            below = [x]
        case ast.BoolOp(values=values):
            _need_conditions(values)
            below = list(values)
        case ast.BinOp(left=x, op=op, right=y) if type(op) in OPERATORS:
            if isinstance(op, ast.Pow) and _whole(y) > LARGEST_POWER:
                raise ExpressionError(f"has the exponent {_text(y)}, at most {LARGEST_POWER} is allowed")
            below = [x, y]
        case ast.Compare(left=x, ops=ops, comparators=others) if all(type(op) in COMPARISONS for op in ops):
            below = [x, *others]
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            _check_arguments(name, args)
            below = list(args[1:] if name == "where" else args)
            if name == "where":
                _need_conditions(args[:1])
                _check(args[0], names, depth + 1)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in names.tables:
            if len(args) != 1:
                raise ExpressionError(f"gives the table {name} {len(args)} arguments, it takes 1", f"write {name}(t)")
            names.used.add(name)
            below = list(args)
        case ast.Call(func=ast.Name(id=name)) if name not in FUNCTIONS:
            functions = [*FUNCTIONS, *names.remedies(names.tables)]
            raise ExpressionError(f'calls the unknown function "{name}"', suggestion(name, sorted(functions), ALIKE))
        case _:
            raise NotAFormulaError(
                f'contains "{_text(node)}", which is not allowed',
                (
                    f"use numbers, + - * / **, comparisons, {', '.join(sorted(names.allowed))}, {', '.join(CONSTANTS)} "
                    f"and the functions {', '.join([*FUNCTIONS, *sorted(names.tables)])}"
                ),
            )
    if not isinstance(node, ast.BoolOp) and not _is_negation(node):
        for part in below:
            if is_condition(part):
                condition = _text(part)
                raise ExpressionError(
                    f'computes with the condition "{condition}"', f"write where({condition}, number, other number)"
                )
    for part in below:
        _check(part, names, depth + 1)


def _degree(node: ast.AST, state: frozenset[str]) -> int:
    """0 for what does not vary in time, 1 for a straight line in t, 2 for the rest."""
    match node:
        case ast.Name() | ast.Attribute() | ast.Subscript():
            name = dotted(node)
            return 1 if name == "t" else 2 if name in state else 0
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=x):
            return _degree(x, state)
        case ast.BinOp(left=x, op=ast.Add() | ast.Sub(), right=y):
            return max(_degree(x, state), _degree(y, state))
        case ast.BinOp(left=x, op=ast.Mult(), right=y):
            return min(_degree(x, state) + _degree(y, state), 2)
        case ast.BinOp(left=x, op=ast.Div(), right=y) if _degree(y, state) == 0:
            return _degree(x, state)
    below = [x for x in ast.iter_child_nodes(node) if isinstance(x, ast.expr)]
    return 2 if any(_degree(x, state) for x in below) else 0


def _check_arguments(name: str, args: list[ast.expr]) -> None:
    fewest, most, _ = FUNCTIONS[name]
    if not fewest <= len(args) <= most:
        count = str(fewest) if fewest == most else f"{fewest} to {most}"
        raise ExpressionError(f"gives {name} {len(args)} argument{'s' * (len(args) != 1)}, it takes {count}")


def is_condition(node: ast.AST) -> bool:
    """Whether a node is one: a comparison, or some of them."""
    return isinstance(node, ast.Compare | ast.BoolOp) or _is_negation(node)


def _is_negation(node: ast.AST) -> bool:
    return isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)


def _need_conditions(nodes: list[ast.expr]) -> None:
    for node in nodes:
        if not is_condition(node):
            raise ExpressionError(f'needs a condition instead of "{_text(node)}"', "write one such as t > 1")


def _whole(node: ast.AST) -> float:
    """The size of a whole number, with or without a sign; 0 for anything else."""
    match node:
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=x):
            return _whole(x)
        case ast.Constant(value=int() | float() as value) if isinstance(value, int) or value.is_integer():
            return abs(value)
    return 0.0


def _text(node: ast.AST) -> str:
    """A part of a formula, cut to what can be read."""
    try:
        text = ast.unparse(node)
    except RecursionError:
        return "..."
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."


def _value(node: ast.AST, names: Names) -> Any:
    """The value of a checked node."""
    match node:
        case ast.Constant(value=value):
            return float(value)  # type: ignore[arg-type]
        case ast.Name() | ast.Attribute() | ast.Subscript():
            name = dotted(node)
            return names[name] if name in names else CONSTANTS[name]
        case ast.UnaryOp(op=ast.UAdd(), operand=x):
            return _value(x, names)
        case ast.UnaryOp(op=ast.USub(), operand=x):
            return -_value(x, names)
        case ast.BinOp(left=x, op=op, right=y):
            return OPERATORS[type(op)](_value(x, names), _value(y, names))
        case ast.Call(func=ast.Name(id="where"), args=[condition, x, y]):
            return where(_truth(condition, names) > 0.5, _value(x, names), _value(y, names))
        case ast.Call(func=ast.Name(id=name), args=args) if name in WHOLE and WITHIN in names:
            within, state = names[WITHIN]
            straight = max(_degree(x, state) for x in args) <= 1
            x, *rest = (_value(x, {**names, "t": within} if straight else names) for x in args)
            if not rest:
                return FUNCTIONS[name][2](x)
            return _value(args[0], names) - rest[0] * floor(x / rest[0])
        case ast.Call(func=ast.Name(id=name), args=args) if name in FUNCTIONS:
            return FUNCTIONS[name][2](*(_value(x, names) for x in args))
        case ast.Call(func=ast.Name(id=name), args=[x]):
            within, state = names.get(WITHIN, (names["t"], frozenset()))
            straight = _degree(x, state) <= 1
            return names[name](_value(x, names), _value(x, {**names, "t": within} if straight else names))
    raise AssertionError("checked before")


def _truth(node: ast.AST, names: Names) -> Any:
    """1 where a condition holds, else 0."""
    match node:
        case ast.BoolOp(op=ast.And(), values=values):
            return reduce(minimum, (_truth(x, names) for x in values))
        case ast.BoolOp(op=ast.Or(), values=values):
            return reduce(maximum, (_truth(x, names) for x in values))
        case ast.UnaryOp(operand=x):
            return 1.0 - _truth(x, names)
        case ast.Compare():
            return reduce(minimum, (where(COMPARISONS[op](x, y), 1.0, 0.0) for op, x, y in _compared(node, names)))
    raise AssertionError("checked before")


def _compared(node: ast.Compare, names: Names) -> list[tuple[type[ast.cmpop], Any, Any]]:
    """The comparisons in a chain of them, each with both sides."""
    parts = [node.left, *node.comparators]
    within, state = names.get(WITHIN, (names.get("t"), frozenset()))
    straight = max(_degree(x, state) for x in parts) <= 1
    sides = [_value(x, {**names, "t": within} if straight else names) for x in parts]
    return list(zip(map(type, node.ops), sides, sides[1:], strict=False))


def _may_hold(node: ast.AST, names: Names, state: frozenset[str], holds: bool = True) -> Any:
    """Whether a condition may hold (or, not `holds`, may not), where only straight lines in t are known."""
    match node:
        case ast.BoolOp(op=word, values=values):
            every = [_may_hold(x, names, state, holds) for x in values]
            return reduce(operator.and_ if isinstance(word, ast.And) == holds else operator.or_, every)
        case ast.UnaryOp(operand=x):
            return _may_hold(x, names, state, not holds)
        case ast.Compare(left=x, comparators=others):
            if max(_degree(side, state) for side in (x, *others)) > 1:
                return True
            return (_truth(node, names) > 0.5) == holds
    raise AssertionError("checked before")


def _both(x: Number, y: Number) -> Any:
    """The margin of two conditions at once: undefined where one is, unless the other does not hold."""
    fails = where(x <= 0.0, x, where(y <= 0.0, y, x + y))
    return where(x < y, x, where(y <= x, y, fails))


def _either(x: Number, y: Number) -> Any:
    """That of one of two conditions: undefined where one is, unless the other holds."""
    holds = where(x > 0.0, x, where(y > 0.0, y, x + y))
    return where(x > y, x, where(y >= x, y, holds))


def _margin(node: ast.AST, names: Names, holds: bool = True) -> Any:
    """A number that is above 0 exactly where a condition holds (or, not `holds`, where it does not), and passes 0 as
    smoothly as its sides do."""
    match node:
        case ast.BoolOp(op=word, values=values):
            least = isinstance(word, ast.And) == holds
            return reduce(_both if least else _either, [_margin(x, names, holds) for x in values])
        case ast.UnaryOp(operand=x):
            return _margin(x, names, not holds)
        case ast.Compare():
            margins = []
            for op, x, y in _compared(node, names):
                upwards = (op in (ast.Gt, ast.GtE)) == holds
                difference = x - y if upwards else y - x
                equal = (op in (ast.GtE, ast.LtE)) == holds
                margins.append(
                    where(difference >= 0.0, maximum(difference, HOLDS), difference) if equal else difference
                )
            return reduce(_both if holds else _either, margins)
    raise AssertionError("checked before")
