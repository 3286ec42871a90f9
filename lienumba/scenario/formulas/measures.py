"""Formulas of whole runs: "max(root.angle, t > 5) - final(root.angle)".

Reducers make one number of the course of a formula of quantities, or of a condition; what stands around them is
arithmetic of such numbers.
"""

import ast
import copy
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

from lienumba.keys.formulas import explained
from lienumba.mechanics.mechanism.model import COUNT, FIRST, INTEGRAL, LARGEST, LAST, NONE, SMALLEST, Kept
from lienumba.numerics.expressions import Formula, Replacing
from lienumba.numerics.functions import FUNCTIONS
from lienumba.numerics.grammar import (
    CONSTANTS,
    Allowed,
    ExpressionError,
    NotAFormulaError,
    check,
    dotted,
    is_condition,
)
from lienumba.scenario.formulas.measure_formula import VALUE, WHEN, MeasureFormula, name_of
from lienumba.scenario.formulas.parameters import TIME, Parameters
from lienumba.words import listed, plural, suggestion


def measure(
    text: str,
    parameters: Parameters,
    names: frozenset[str],
    events: Mapping[str, str],
    others: Collection[str] = (),
    end: float = inf,
) -> MeasureFormula:
    """A formula of a whole run.

    Parameters
    ----------
    text
        As people write it.
    parameters
        Whose names, and those of whose tables, it may use.
    names
        All that formulas may read of a state, the time among it.
    events
        The conditions of events, by their names.
    others
        The names of other measures, which it may not use.
    end
        When the run ends at the latest (s).

    Raises
    ------
    ExpressionError
        With what is wrong, and the remedy.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        error = NotAFormulaError("is not a formula", 'write one such as "max(pointing.angle, t > 5)"')
        raise explained(text, error) from None
    found = _Parsing(parameters, names, events, others, end)
    written = found.visit(copy.deepcopy(tree))
    if not any(isinstance(node, ast.Call) and _reduces(node) for node in ast.walk(tree)):
        rule = "is no number of a whole run"
        raise ExpressionError(rule, f"write one of {listed(f'{name}(...)' for name in REDUCERS)} in it")
    check(written, Allowed(frozenset(found.trees), frozenset(), set(), None))
    outer = Replacing(found.trees).visit(written)
    if is_condition(outer):
        raise ExpressionError("is a condition, not a number", "write where(condition, 1, 0)")
    known = frozenset(name_of(n, what) for n in range(len(found.kept)) for what in (VALUE, WHEN))
    return MeasureFormula(text, tuple(found.signals), tuple(found.kept), Formula(ast.unparse(outer), known))


def is_formula(text: str) -> bool:
    """Whether a text is meant as a formula of a whole run, and not as the name of a number that each run has."""
    return "(" in text


@dataclass
class _Parsing(ast.NodeTransformer):
    """Makes names of reducers and of what has a name, as they are written; trees: what these are, of what is kept."""

    parameters: Parameters
    names: frozenset[str]
    events: Mapping[str, str]
    others: Collection[str]
    end: float
    signals: list[Formula] = field(default_factory=list)
    kept: list[Kept] = field(default_factory=list)
    trees: dict[str, ast.expr] = field(default_factory=dict)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = dotted(node.func)
        if _reduces(node):
            return self._named(ast.unparse(node), self._reduced(name, node))
        if name in self.parameters.tables:
            raise ExpressionError(f"reads the table {name} outside of a reducer", f"write it inside: max({name}(...))")
        if name not in FUNCTIONS:
            known = [*REDUCERS, *FUNCTIONS]
            raise ExpressionError(
                f'calls the unknown function "{name or ast.unparse(node.func)}"', suggestion(name, known)
            )
        node.args = [self.visit(x) for x in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self._outside(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return self._outside(node) if dotted(node) else self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        return self._outside(node) if dotted(node) else self.generic_visit(node)

    def _named(self, name: str, tree: ast.expr) -> ast.expr:
        self.trees[name] = tree
        return ast.Name(name)

    def _outside(self, node: ast.expr) -> ast.expr:
        """A name outside of reducers: a parameter, which is as at the start."""
        name = dotted(node)
        if name in CONSTANTS:
            return node
        if name in self.parameters.numbers or name in self.parameters.formulas or name in self.parameters.inputs:
            return self._named(name, self.keep(FIRST, node, None))
        if name == TIME:
            raise ExpressionError("has t outside of a reducer", "write final(t), when the run ends, or first_time(...)")
        if name in self.names:
            rule = f"reads {name} outside of a reducer, but that is another number at every time"
            raise ExpressionError(rule, f"write final({name}), max({name}) or another number of its course")
        below = sorted(x for x in self.names if x.startswith(f"{name}."))
        if below:
            raise ExpressionError(f'uses "{name}", which has several numbers', f"write {' or '.join(below)}")
        if name in REDUCERS or name in FUNCTIONS:
            raise ExpressionError(f'uses "{name}" without arguments', f"write {name}(...)")
        if name in self.others:
            rule = f'uses the measure "{name}", but a measure is made of the course of a run, not of other measures'
            raise ExpressionError(rule, f"write the formula of {name} in its place")
        raise ExpressionError(f'has the unknown name "{name}"', suggestion(name, [*sorted(self.names), *REDUCERS]))

    def _reduced(self, name: str, node: ast.Call) -> ast.expr:
        reducer, args = REDUCERS[name], node.args
        least = len(reducer.takes)
        if node.keywords or not least <= len(args) <= least + reducer.windowed:
            takes = " and ".join(f"a {x}" for x in reducer.takes) + (", and a condition or none" * reducer.windowed)
            rule = f"gives {name} {plural(len(args) + len(node.keywords), 'argument', 'arguments')}, it takes {takes}"
            raise ExpressionError(rule, f"write {reducer.example}")
        for argument in args:
            nested = next((x for x in ast.walk(argument) if isinstance(x, ast.Call) and _reduces(x)), None)
            if nested is not None:
                rule = f"has {ast.unparse(nested)} inside of {name}, but that is one number for the whole run"
                raise ExpressionError(rule, f"compute with it outside of {name}")
        for what, argument in zip(reducer.takes, args, strict=False):
            if what == CONDITION and not is_condition(argument):
                rule = f'gives {name} the number "{ast.unparse(argument)}", it takes a condition'
                raise ExpressionError(rule, "compare it, such as in pointing.angle > 0.1")
            if what != CONDITION and is_condition(argument):
                rule = f'gives {name} the condition "{ast.unparse(argument)}" where it takes a {what}'
                raise ExpressionError(rule, f"write {reducer.example}; how long one holds is time_when(condition)")
        window = args[least] if len(args) > least else None
        if window is not None and not is_condition(window):
            rule = f'gives {name} "{ast.unparse(window)}" where it takes a condition'
            raise ExpressionError(rule, f"write {reducer.example}")
        return reducer.made(self, [*args[:least], window])

    def keep(self, kind: str, value: ast.expr | None, condition: ast.expr | None, event: str = "") -> ast.expr:
        """The value of what is kept: its time is beside it."""
        kept = Kept(kind, self._signal(value, False), self._signal(condition, True), event)
        if kept not in self.kept:
            self.kept.append(kept)
        return ast.parse(name_of(self.kept.index(kept), VALUE), mode="eval").body

    def _signal(self, node: ast.expr | None, condition: bool) -> int:
        """Its number among the signals."""
        if node is None:
            return NONE
        text = ast.unparse(node)
        try:
            formula = Formula(text, self.names, frozenset(self.parameters.tables), condition)
        except ExpressionError as error:
            raise explained(text, error) from None
        if formula not in self.signals:
            self.signals.append(formula)
        return self.signals.index(formula)

    def at(self, value: ast.expr, node: ast.expr) -> ast.expr:
        """A value at an event, or at a time."""
        name = dotted(node)
        if name not in self.events:
            return self.keep(FIRST, value, self._instant(node))
        if name in self.names:
            raise ExpressionError(f'has "{name}", an event and a number', "give one of the two another name")
        return self.keep(FIRST, value, ast.parse(self.events[name].strip(), mode="eval").body, name)

    def _instant(self, node: ast.expr) -> ast.expr:
        """The condition that begins at a time."""
        name = dotted(node)
        if isinstance(node, ast.Name) and name not in self.names and name not in CONSTANTS:
            known = [*self.events, *sorted(self.names)]
            raise ExpressionError(f'has "{name}", which is no event and no number', suggestion(name, known))
        numbers = {*CONSTANTS, *self.parameters.numbers, *self.parameters.formulas}
        changing = sorted({text for x in ast.walk(node) if (text := dotted(x)) in self.names} - numbers)
        if changing:
            rule = f'gives at "{ast.unparse(node)}", which changes with time, where it takes a time or event'
            raise ExpressionError(rule, "give a number or a parameter, or the name of an event")
        try:
            time = float(Formula(ast.unparse(node), frozenset())(0.0))
        except ExpressionError:
            return self._from(node)  # of parameters, which may vary
        if not 0.0 <= time <= self.end:
            rule = f"asks for a value at {time!r} s, but runs go from 0 to {self.end!r} s"
            raise ExpressionError(rule, "give a time in between, or write final(...)")
        return self._from(node)

    def _from(self, time: ast.expr) -> ast.expr:
        """From a time on. Where values jump at that time, the value behind the jump counts, as in stored states, whose
        time may be roundoff later; at the end of a run there is nothing behind."""
        given = ast.unparse(time)
        behind = f"({given}) + {JUMP_ROUNDOFF * self.end!r}"
        text = f"{TIME} >= where({behind} > {self.end!r}, {given}, {behind})"
        return ast.parse(text, mode="eval").body


# ---------------------------------------------------------------- reducers
CONDITION = "condition"
JUMP_ROUNDOFF = 2.0**-39  # of a run: a time at which something jumps may be so much later by roundoff
EXAMPLES = {  # of what reducers take
    "number": "pointing.angle", CONDITION: "pointing.angle > 0.1", "time or event": "0.5", "target": "0.2",
    "limit": "0.2",
}  # fmt: skip
Arguments = list[Any]  # nodes, the condition or None behind them


class Reducer(NamedTuple):
    """takes: what it is told, in words; windowed: whether a condition may stand behind that; unit: that of its value,
    or this one; {u}: that of the value."""

    name: str
    words: str
    takes: tuple[str, ...]
    windowed: bool
    made: Callable[[_Parsing, Arguments], ast.expr]
    unit: str = "{u}"

    @property
    def example(self) -> str:
        """How it is written."""
        return f"{self.name}({', '.join([*(EXAMPLES[x] for x in self.takes), *(['t > 5'] * self.windowed)])})"


def _time_of(value: ast.expr) -> ast.expr:
    """The time beside a value that is kept."""
    return ast.parse(ast.unparse(value).removesuffix(VALUE) + WHEN, mode="eval").body


def _square(x: ast.expr) -> ast.expr:
    return ast.BinOp(x, ast.Mult(), copy.deepcopy(x))


def _mean(parsing: _Parsing, value: ast.expr, condition: ast.expr | None) -> ast.expr:
    total = parsing.keep(INTEGRAL, value, condition)
    return ast.BinOp(total, ast.Div(), _time_of(total))


def _time_above(parsing: _Parsing, x: ast.expr, limit: ast.expr, condition: ast.expr | None) -> ast.expr:
    above: ast.expr = ast.Compare(x, [ast.Gt()], [limit])
    if condition is not None:
        above = ast.BoolOp(ast.And(), [above, condition])
    return _time_of(parsing.keep(INTEGRAL, None, above))


def _overshoot(parsing: _Parsing, x: ast.expr, target: ast.expr, condition: ast.expr | None) -> ast.expr:
    beyond = ast.BinOp(x, ast.Sub(), target)
    first, most, least = (ast.unparse(parsing.keep(kind, beyond, condition)) for kind in (FIRST, LARGEST, SMALLEST))
    text = f"where({first} <= 0, max(0, {most}), max(0, -{least})) + 0*{first}"
    return ast.parse(text, mode="eval").body


def _reduces(node: ast.Call) -> bool:
    """Whether a call is one of a reducer: max and min of several numbers are functions."""
    name = dotted(node.func)
    several = len(node.args) > 1 and not is_condition(node.args[1])
    return name in REDUCERS and not (name in FUNCTIONS and several)


_NUMBER = ("number",)
REDUCERS: dict[str, Reducer] = {
    x.name: x
    for x in (
        Reducer("max", "the largest value", _NUMBER, True, lambda p, a: p.keep(LARGEST, *a)),
        Reducer("min", "the smallest value", _NUMBER, True, lambda p, a: p.keep(SMALLEST, *a)),
        Reducer("mean", "the mean over the time", _NUMBER, True, lambda p, a: _mean(p, *a)),
        Reducer(
            "rms",
            "the root of the mean square over the time",
            _NUMBER,
            True,
            lambda p, a: ast.Call(ast.Name("sqrt"), [_mean(p, _square(a[0]), a[1])], []),
        ),
        Reducer("final", "the value where the run ends", _NUMBER, True, lambda p, a: p.keep(LAST, *a)),
        Reducer("integral", "the integral over the time", _NUMBER, True, lambda p, a: p.keep(INTEGRAL, *a), "{u} s"),
        Reducer("time_of_max", "when it is largest", _NUMBER, True, lambda p, a: _time_of(p.keep(LARGEST, *a)), "s"),
        Reducer("time_of_min", "when it is smallest", _NUMBER, True, lambda p, a: _time_of(p.keep(SMALLEST, *a)), "s"),
        Reducer(
            "at",
            "the value at a time, or where an event first happens",
            ("number", "time or event"),
            False,
            lambda p, a: p.at(a[0], a[1]),
        ),
        Reducer(
            "first_time",
            "when a condition first holds",
            (CONDITION,),
            False,
            lambda p, a: _time_of(p.keep(FIRST, None, a[0])),
            "s",
        ),
        Reducer(
            "last_time",
            "when a condition holds for the last time",
            (CONDITION,),
            False,
            lambda p, a: _time_of(p.keep(LAST, None, a[0])),
            "s",
        ),
        Reducer(
            "time_when",
            "for how long a condition holds",
            (CONDITION,),
            False,
            lambda p, a: _time_of(p.keep(INTEGRAL, None, a[0])),
            "s",
        ),
        Reducer(
            "time_above",
            "for how long it is above a limit",
            ("number", "limit"),
            True,
            lambda p, a: _time_above(p, *a),
            "s",
        ),
        Reducer(
            "overshoot",
            "how far it goes beyond a target, seen from where it begins",
            ("number", "target"),
            True,
            lambda p, a: _overshoot(p, *a),
        ),
        Reducer(
            "count",
            "how often a condition becomes true",
            (CONDITION,),
            False,
            lambda p, a: p.keep(COUNT, None, a[0]),
            "1",
        ),
    )
}
