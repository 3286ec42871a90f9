"""Units of formulas, where those of what they read are known: "m s-1" times "s" is "m"."""

import ast
from collections.abc import Mapping
from functools import reduce

from lienumba.keys.units import factors, written
from lienumba.numerics.functions import FUNCTIONS
from lienumba.numerics.grammar import dotted, is_condition

UNKNOWN = "1"  # also of plain numbers
CONSTANTS = {"t": "s", "deg": "rad", "rpm": "rad s-1", "pi": UNKNOWN}
ANGLES = ("asin", "acos", "atan", "atan2")
ALIKE = ("abs", "floor", "ceil", "mod")  # of which the first argument says the units
SUMS = ("min", "max", "clip", "hypot")

Powers = dict[str, float]  # of symbols; empty of a plain number
Known = Powers | None


def units_of(text: str, names: Mapping[str, str], reducers: Mapping[str, str]) -> str:
    """The units of a formula of a whole run, "1" where nobody says.

    Parameters
    ----------
    text
        The formula, as it is written.
    names
        The units of what it may read; what is missing, such as a parameter, may be anything.
    reducers
        The units of numbers of whole runs, "{u}" for those of what is reduced.
    """
    known = {**names, **CONSTANTS}

    def found(node: ast.expr) -> Known:
        match node:
            case ast.Constant():
                return {}
            case ast.UnaryOp(operand=x):
                return found(x)
            case ast.BinOp(left=x, op=ast.Add() | ast.Sub(), right=y):
                return _sum(_added(x), _added(y))
            case ast.BinOp(left=x, op=ast.Mult() | ast.Div() as op, right=y):
                return _product(found(x), found(y), -1 if isinstance(op, ast.Div) else 1)
            case ast.BinOp(left=x, op=ast.Pow(), right=ast.Constant(value=int() as power)):
                return _product({}, found(x), power)
            case ast.Call(args=[first, *_] as args):
                return _called(dotted(node.func), first, args)
        return _parsed(known[name]) if (name := dotted(node)) in known else None

    def _added(node: ast.expr) -> Known:
        """In a sum, what may have any units has those of the others."""
        unsaid = not isinstance(node, ast.BinOp | ast.Call) and dotted(node) not in known
        return {} if unsaid else found(node)

    def _called(name: str, first: ast.expr, args: list[ast.expr]) -> Known:
        several = len(args) > 1 and not is_condition(args[1])
        if name in reducers and not (name in SUMS and several):
            inner, _, more = reducers[name].partition("{u}")
            return _parsed(inner) if "{u}" not in reducers[name] else _product(found(first), _parsed(more), 1)
        if name == "sqrt":
            inside = found(first)
            even = inside is not None and all(power % 2 == 0 for power in inside.values())
            return {symbol: power // 2 for symbol, power in inside.items()} if inside is not None and even else None
        if name in SUMS or name == "where":
            return reduce(_sum, map(_added, args[1:] if name == "where" else args))
        if name in ALIKE or name not in FUNCTIONS:
            return found(first) if name in ALIKE else None  # a table may give anything
        return _parsed("rad") if name in ANGLES else {}

    powers = found(ast.parse(text.strip(), mode="eval").body)
    return written([*(powers or {}).items()])


def _parsed(units: str) -> Known:
    """Symbols with their powers; None of a text that cannot be read."""
    every = factors(units)
    found: Known = None if every is None else {}
    for symbol, power in every or ():
        found = _product(found, {symbol: power}, 1)
    return found


def _sum(x: Known, y: Known) -> Known:
    if x is None or y is None:
        return None
    return y if not x else x if not y or x == y else None


def _product(x: Known, y: Known, power: int) -> Known:
    """x times a power of y."""
    if x is None or y is None:
        return None
    every = {symbol: x.get(symbol, 0) + power * y.get(symbol, 0) for symbol in (*x, *y)}
    return {symbol: n for symbol, n in every.items() if n}
