"""Conditions that compare what `where` and `sign` choose, as conditions of their branches.

The margin of `where(x > 1, a, c) > b` jumps where x passes 1, and a pulse of it between two samples shows nothing. That
of `x > 1 and a > b or not x > 1 and c > b` passes 0 as smoothly as x does.
"""

import ast
import copy
from math import inf

from lienumba.numerics.evaluation import Chooses, truth
from lienumba.numerics.functions import FUNCTIONS
from lienumba.numerics.grammar import CONSTANTS, dotted

NAMES = (ast.Name, ast.Attribute, ast.Subscript)
NEVER = ast.Compare(ast.Constant(0.0), [ast.Gt()], [ast.Constant(inf)])
MOST_BRANCHES = 4  # of one comparison


def branched(node: ast.expr) -> ast.expr:
    """A condition without `where` and `sign` in what it compares, unless these are many."""
    match node:
        case ast.BoolOp(op=word, values=values):
            return ast.BoolOp(word, [*map(branched, values)])
        case ast.UnaryOp(op=word, operand=x):
            return type(node)(word, branched(x))
        case ast.Compare() if chosen := _chosen(node):
            return branched(chosen)
    return node


def _varies(node: ast.expr) -> bool:
    """Whether names of numbers are in it."""
    return any(dotted(x) not in (*CONSTANTS, *FUNCTIONS) for x in ast.walk(node) if isinstance(x, NAMES))


def _chosen(node: ast.Compare) -> ast.expr | None:
    """The same comparison for each branch of the first `where` or `sign` in it; None without any, or with many."""
    calls = [x for x in ast.walk(node) if isinstance(x, ast.Call) and ast.unparse(x.func) in ("where", "sign")]
    if not 0 < len(calls) <= MOST_BRANCHES:
        return None
    call, args = calls[0], calls[0].args
    if len(args) == 1:
        above, below = (ast.Compare(args[0], [op()], [ast.Constant(0.0)]) for op in (ast.Gt, ast.Lt))
        other = ast.Call(ast.Name("where"), [below, ast.Constant(-1.0), ast.Constant(0.0)], [])
        args = [above, ast.Constant(1.0), other]
    condition, *branches = args
    found = list[ast.expr]()
    if not _varies(condition):
        return copy.deepcopy(node, {id(call): branches[0 if truth(condition, {}) > 0.5 else 1]})
    for word, branch in zip((ast.UAdd(), ast.Not()), branches, strict=True):
        chosen, own = Chooses(word, condition), copy.deepcopy(node, {id(call): branch})
        if _varies(own):
            found.append(ast.BoolOp(ast.And(), [chosen, own]))
        elif truth(own, {}) > 0.5:
            found.append(chosen)
    return ast.BoolOp(ast.Or(), found or [NEVER])
