"""The grammar of formulas: Python's own, of which each node is checked against the short list below."""

import ast
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from lienumba.errors import BadValueError
from lienumba.numerics import operations
from lienumba.numerics.functions import FUNCTIONS
from lienumba.numerics.operations import power
from lienumba.words import ALIKE, suggestion

CONSTANTS = {"pi": math.pi, "deg": math.pi / 180.0, "rpm": math.pi / 30.0}
LONGEST = 2000  # characters
DEEPEST = 200  # nested operations; a sum of n terms nests n - 1
SHOWN = 80  # characters of a part in a message
LARGEST_POWER = 64  # of an exponent that is a whole number
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


class Allowed(NamedTuple):
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


def check(node: ast.AST, names: Allowed, depth: int = 0) -> None:
    """Raise an ExpressionError unless the node and all below it are in the list."""
    if depth > DEEPEST:
        raise ExpressionError(f"nests more than {DEEPEST} operations", "split it")
    below: list[ast.AST] = []
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            if not abs(value) < 1e300:
                written = "a number" if value == math.inf else f"the number {_text(node)}"
                raise ExpressionError(f"has {written}, which is too large")
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
                check(args[0], names, depth + 1)
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
        check(part, names, depth + 1)


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
