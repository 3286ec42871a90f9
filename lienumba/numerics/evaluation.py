"""What a checked formula is worth: a number, whether a condition holds, and the margin by which it does."""

import ast
import operator
from collections.abc import Mapping
from functools import reduce
from math import inf
from typing import Any

from lienumba.numerics.functions import FUNCTIONS, floor
from lienumba.numerics.grammar import COMPARISONS, CONSTANTS, OPERATORS, dotted
from lienumba.numerics.number import Number
from lienumba.numerics.operations import HOLDS, maximum, minimum, where

WITHIN = "t within"  # the time that tells in which piece of a table t lies, and on which side of a comparison, where
# this is not t itself; and the names that are no functions of the time. Only for straight lines in t: there steps land.
Names = Mapping[str, Any]  # numbers, and tables, which are called with two
WHOLE = ("floor", "ceil", "mod")  # functions that jump where a whole number is reached


class Chooses(ast.UnaryOp):
    """A condition, or with `not` its contrary, that chooses a branch (`branches`)."""


def degree(node: ast.AST, state: frozenset[str]) -> int:
    """0 for what does not vary in time, 1 for a straight line in t, 2 for the rest."""
    match node:
        case ast.Name() | ast.Attribute() | ast.Subscript():
            name = dotted(node)
            return 1 if name == "t" else 2 if name in state else 0
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=x):
            return degree(x, state)
        case ast.BinOp(left=x, op=ast.Add() | ast.Sub(), right=y):
            return max(degree(x, state), degree(y, state))
        case ast.BinOp(left=x, op=ast.Mult(), right=y):
            return min(degree(x, state) + degree(y, state), 2)
        case ast.BinOp(left=x, op=ast.Div(), right=y) if degree(y, state) == 0:
            return degree(x, state)
    below = [x for x in ast.iter_child_nodes(node) if isinstance(x, ast.expr)]
    return 2 if any(degree(x, state) for x in below) else 0


def value(node: ast.AST, names: Names) -> Any:
    """The value of a checked node."""
    match node:
        case ast.Constant(value=number):
            return float(number)  # type: ignore[arg-type]
        case ast.Name() | ast.Attribute() | ast.Subscript():
            name = dotted(node)
            return names[name] if name in names else CONSTANTS[name]
        case ast.UnaryOp(op=ast.UAdd(), operand=x):
            return value(x, names)
        case ast.UnaryOp(op=ast.USub(), operand=x):
            return -value(x, names)
        case ast.BinOp(left=x, op=op, right=y):
            return OPERATORS[type(op)](value(x, names), value(y, names))
        case ast.Call(func=ast.Name(id="where"), args=[condition, x, y]):
            return where(truth(condition, names) > 0.5, value(x, names), value(y, names))
        case ast.Call(func=ast.Name(id=name), args=args) if name in WHOLE and WITHIN in names:
            within, state = names[WITHIN]
            straight = max(degree(x, state) for x in args) <= 1
            x, *rest = (value(x, {**names, "t": within} if straight else names) for x in args)
            if not rest:
                return FUNCTIONS[name][2](x)
            return value(args[0], names) - rest[0] * floor(x / rest[0])
        case ast.Call(func=ast.Name(id=name), args=args) if name in FUNCTIONS:
            return FUNCTIONS[name][2](*(value(x, names) for x in args))
        case ast.Call(func=ast.Name(id=name), args=[x]):
            within, state = names.get(WITHIN, (names["t"], frozenset()))
            straight = degree(x, state) <= 1
            return names[name](value(x, names), value(x, {**names, "t": within} if straight else names))
    raise AssertionError("checked before")


def truth(node: ast.AST, names: Names) -> Any:
    """1 where a condition holds, else 0."""
    match node:
        case ast.BoolOp(op=ast.And(), values=values):
            return reduce(minimum, (truth(x, names) for x in values))
        case ast.BoolOp(op=ast.Or(), values=values):
            return reduce(maximum, (truth(x, names) for x in values))
        case ast.UnaryOp(operand=x):
            return 1.0 - truth(x, names)
        case ast.Compare():
            return reduce(minimum, (where(COMPARISONS[op](x, y), 1.0, 0.0) for op, x, y in _compared(node, names)))
    raise AssertionError("checked before")


def _compared(node: ast.Compare, names: Names, chooses: bool = True) -> list[tuple[type[ast.cmpop], Any, Any]]:
    """The comparisons in a chain of them, each with both sides; chooses: whether it is asked on which side t lies."""
    parts = [node.left, *node.comparators]
    within, state = names.get(WITHIN, (names.get("t"), frozenset()))
    straight = chooses and max(degree(x, state) for x in parts) <= 1
    sides = [value(x, {**names, "t": within} if straight else names) for x in parts]
    return list(zip(map(type, node.ops), sides, sides[1:], strict=False))


def may_hold(node: ast.AST, names: Names, state: frozenset[str], holds: bool = True) -> Any:
    """Whether a condition may hold (or, not `holds`, may not), where only straight lines in t are known."""
    match node:
        case ast.BoolOp(op=word, values=values):
            every = [may_hold(x, names, state, holds) for x in values]
            return reduce(operator.and_ if isinstance(word, ast.And) == holds else operator.or_, every)
        case ast.UnaryOp(operand=x):
            return may_hold(x, names, state, not holds)
        case ast.Compare(left=x, comparators=others):
            if max(degree(side, state) for side in (x, *others)) > 1:
                return True
            return (truth(node, names) > 0.5) == holds
    raise AssertionError("checked before")


def _both(x: Number, y: Number) -> Any:
    """The margin of two conditions at once: undefined where one is, unless the other does not hold."""
    fails = where(x <= 0.0, x, where(y <= 0.0, y, x + y))
    return where(x < y, x, where(y <= x, y, fails))


def _either(x: Number, y: Number) -> Any:
    """That of one of two conditions: undefined where one is, unless the other holds."""
    holds = where(x > 0.0, x, where(y > 0.0, y, x + y))
    return where(x > y, x, where(y >= x, y, holds))


def _alone(x: Number) -> Any:
    """The margin of a condition that chooses: infinite where both of its sides are the same number, so that the branch
    alone has the say."""
    tied = where(x > 0.0, inf, where(x <= 0.0, -inf, x))
    return where(x < 0.0, x, where(x > HOLDS, x, tied))


def margin(node: ast.AST, names: Names, holds: bool = True) -> Any:
    """A number that is above 0 exactly where a condition holds (or, not `holds`, where it does not), and passes 0 as
    smoothly as its sides do."""
    match node:
        case ast.BoolOp(op=word, values=values):
            least = isinstance(word, ast.And) == holds
            return reduce(_both if least else _either, [margin(x, names, holds) for x in values])
        case Chooses(op=word, operand=x):
            return _alone(margin(x, names, isinstance(word, ast.UAdd) == holds))
        case ast.UnaryOp(operand=x):
            return margin(x, names, not holds)
        case ast.Compare():
            margins = []
            for op, x, y in _compared(node, names, chooses=False):
                upwards = (op in (ast.Gt, ast.GtE)) == holds
                difference = x - y if upwards else y - x
                equal = (op in (ast.GtE, ast.LtE)) == holds
                margins.append(
                    where(difference >= 0.0, maximum(difference, HOLDS), difference) if equal else difference
                )
            return reduce(_both if holds else _either, margins)
    raise AssertionError("checked before")
