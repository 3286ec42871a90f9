"""Numbers written as formulas: "0.3*sin(2*t) + 0.1*t**2".

A formula is parsed by Python's own grammar, checked node by node (`grammar`), and evaluated with the named operations
(`evaluation`), so that it runs on floats, arrays, jets and symbols. Nothing is ever passed to `eval`.
"""

import ast
import copy
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any

from lienumba.numerics import evaluation
from lienumba.numerics.branches import branched
from lienumba.numerics.evaluation import WHOLE, degree
from lienumba.numerics.grammar import LONGEST, Allowed, ExpressionError, NotAFormulaError, check, dotted, is_condition
from lienumba.numerics.number import Number

JUMPING = (*WHOLE, "sign", "where")


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
        check(tree, Allowed(self.allowed, self.tables, used, self.told))
        if is_condition(tree) and not self.condition:
            raise ExpressionError("is a condition, not a number", "write where(condition, number, other number)")
        if self.condition and not is_condition(tree):
            raise ExpressionError("is a number, not a condition", 'compare it, such as in "t > 0.5"')
        if self.condition and not used:
            raise ExpressionError("never changes", "name a quantity in it, or the time t")
        object.__setattr__(self, "_tree", tree)
        object.__setattr__(self, "used", frozenset(used))
        if not used:
            value = evaluation.value(tree, {})
            if not math.isfinite(value):
                raise ExpressionError(f"has the value {value}", "it must be a finite number")
            object.__setattr__(self, "constant", float(value))

    def __call__(self, t: Number, **names: Any) -> Any:
        return (evaluation.margin if self.condition else evaluation.value)(self._branched, {"t": t, **names})

    @cached_property
    def _branched(self) -> ast.expr:
        return branched(self._tree) if self.condition else self._tree

    def bound(self, values: Mapping[str, float]) -> str:
        """The text of the same formula with numbers for these names."""
        return self._with({name: ast.Constant(x) for name, x in values.items()})

    def rewritten(self, texts: Mapping[str, str], names: Iterable[str]) -> "Formula":
        """The same with other formulas, or names, for these names; names: that may stand in them besides."""
        written = self._with({name: ast.parse(text, mode="eval").body for name, text in texts.items()})
        return Formula(written, self.allowed.union(names), self.tables, self.condition)

    def _with(self, trees: Mapping[str, ast.expr]) -> str:
        return ast.unparse(Replacing(trees).visit(copy.deepcopy(self._tree)))

    @property
    def plain(self) -> str:
        """Its text as it is written without needless blanks and brackets."""
        return ast.unparse(self._tree)

    def is_line(self, state: frozenset[str]) -> bool:
        """Whether it is a straight line in t, as it is written; state: the names that vary in time, too."""
        return degree(self._tree, state) == 1

    def is_multiple(self, name: str) -> bool:
        """Whether it is, as it is written, this name, alone or times plain numbers."""

        def multiple(node: ast.expr) -> bool:
            match node:
                case ast.UnaryOp(operand=x):
                    return multiple(x)
                case ast.BinOp(left=ast.Constant(), op=ast.Mult(), right=x):
                    return multiple(x)
                case ast.BinOp(left=x, op=ast.Mult() | ast.Div(), right=ast.Constant()):
                    return multiple(x)
            return dotted(node) == name

        return multiple(self._tree)

    @cached_property
    def bends(self) -> "tuple[Formula, ...] | None":
        """Numbers at whose zeros it may have, as it is written, a kink or a jump, and nowhere else; None if there are
        no such ones."""
        if self._calls(()):
            return None
        tree = self._branched
        alone = isinstance(tree, ast.Compare) and len(tree.ops) == 1  # itself the margin of the condition
        nodes = [node for node in ast.walk(tree) if not (alone and node is tree)]
        found = {ast.unparse(x): x for node in nodes for x in _bends(node)}
        moving = [text for text, x in found.items() if any(dotted(y) in self.used for y in ast.walk(x))]
        try:
            return tuple(Formula(text, self.allowed, self.tables) for text in moving)
        except ExpressionError:  # longer than formulas may be
            return None

    @property
    def leaps(self) -> bool:
        """Whether it may jump at some time, as it is written, where what it reads does not."""
        return ("t" in self.used or bool(self.used & self.tables)) and self._calls(JUMPING)

    def _calls(self, names: Iterable[str]) -> bool:
        """Whether it calls one of these functions, or a table."""
        calls = [node.func for node in ast.walk(self._tree) if isinstance(node, ast.Call)]
        return any(isinstance(x, ast.Name) and (x.id in names or x.id in self.tables) for x in calls)

    def switches(self, state: frozenset[str]) -> list["Formula"]:
        """The differences of the straight lines in t that it compares; state: the names that vary in time, too."""
        found = []
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Compare):
                sides = [node.left, *node.comparators]
                for x, y in pairwise(sides):
                    difference = ast.BinOp(x, ast.Sub(), y)
                    if degree(difference, state) == 1:
                        found.append(Formula(ast.unparse(difference), self.allowed, self.tables))
        return found

    def wholes(self, state: frozenset[str]) -> list["Formula"]:
        """The straight lines in t whose whole numbers are jumps of it; state: the names that vary in time, too."""
        found = []
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in WHOLE:
                line = _counted(node.args)
                if degree(line, state) == 1:
                    found.append(Formula(ast.unparse(line), self.allowed, self.tables))
        return found

    def may_hold(self, t: Any, state: frozenset[str], numbers: Mapping[str, Any]) -> Any:
        """Whether a condition may hold at times t, whatever varies in another way than a straight line in t; state: the
        names of what varies, too; numbers: the values of the others."""
        return evaluation.may_hold(self._tree, {**numbers, "t": t}, state)

    def table_calls(self) -> list[tuple[str, "Formula"]]:
        """The tables that it reads, each with the formula of its argument."""
        calls = [n for n in ast.walk(self._tree) if isinstance(n, ast.Call)]
        return [
            (n.func.id, Formula(ast.unparse(n.args[0]), self.allowed, self.tables))
            for n in calls
            if isinstance(n.func, ast.Name) and n.func.id in self.tables
        ]


def _bends(node: ast.AST) -> list[ast.expr]:
    """The numbers at whose zeros a node itself has a kink or a jump."""
    pairs: Iterable[tuple[ast.expr, ast.expr]] = ()
    match node:
        case ast.Call(func=ast.Name(id="abs" | "sign"), args=args):
            return list(args)
        case ast.Call(func=ast.Name(id=name), args=args) if name in WHOLE:
            quarter = ast.BinOp(ast.Constant(0.5 * math.pi), ast.Mult(), _counted(args))
            return [ast.Call(ast.Name(of), [quarter], []) for of in ("sin", "cos")]  # 0 at even, and at odd numbers
        case ast.Call(func=ast.Name(id="min" | "max"), args=args):
            pairs = combinations(args, 2)
        case ast.Call(func=ast.Name(id="clip"), args=[x, low, high]):
            pairs = [(x, low), (x, high)]
        case ast.Compare(left=x, comparators=others):
            pairs = pairwise([x, *others])
    return [ast.BinOp(x, ast.Sub(), y) for x, y in pairs]


def _counted(args: list[ast.expr]) -> ast.expr:
    """Of `WHOLE` functions the number that is whole where they jump."""
    return args[0] if len(args) == 1 else ast.BinOp(args[0], ast.Div(), args[1])


class Replacing(ast.NodeTransformer):
    """Puts trees in the place of names of numbers; a function may have the same name."""

    def __init__(self, trees: Mapping[str, ast.expr]) -> None:
        self.trees = trees

    def visit_Call(self, node: ast.Call) -> ast.expr:
        node.args = [self.visit(x) for x in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self._replaced(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return self._replaced(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return self._replaced(node)

    def _replaced(self, node: ast.expr) -> ast.expr:
        return self.trees.get(dotted(node), node)
