"""Varied numbers that are formulas of others: which names they know, and in which order they follow."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lienumba.errors import Problem
from lienumba.keys.formulas import explained
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError
from lienumba.scenario.formulas.parameters import order
from lienumba.sweep.distributions.base import Distribution
from lienumba.sweep.distributions.external import Expression

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report
    from lienumba.scenario.formulas.parameters import Parameters


def ordered(
    vary: Mapping[str, Distribution], parameters: "Parameters", problems: list[Problem] | None = None
) -> dict[str, Formula]:
    """The formulas by their paths, each behind those that it needs; an ExpressionError for what is none. problems: a
    cycle is added."""
    names = _names(vary, parameters)
    formulas = {path: Formula(kind.expression, names) for path, kind in vary.items() if isinstance(kind, Expression)}
    needs = {path: _needs(formula, parameters) & formulas.keys() for path, formula in formulas.items()}
    behind = order(needs, "sweep.vary", [] if problems is None else problems, "a distribution")
    return {path: formulas[path] for path in behind}


def used(vary: Mapping[str, Distribution], parameters: "Parameters") -> set[str]:
    """The parameters that formulas use, by either of their names."""
    names = {name for formula in ordered(vary, parameters).values() for name in formula.used}
    return {name.removeprefix("parameters.") for name in names}


def _names(vary: Mapping[str, Distribution], parameters: "Parameters") -> frozenset[str]:
    """What a formula may name: every number that varies, by its path, and every parameter."""
    return frozenset(name for path, kind in vary.items() for name in kind.columns(path)) | parameters.values().keys()


def _needs(formula: Formula, parameters: "Parameters") -> set[str]:
    """The paths that a formula depends on, also through parameters."""
    return set(formula.used) | {f"parameters.{name}" for name in parameters.all_used(formula)}


def check_derived(vary: Mapping[str, Distribution], parameters: "Parameters", report: "Report") -> None:
    """Check the formulas, and that none depends on itself."""
    before, names = len(report.problems), _names(vary, parameters)
    for path, kind in vary.items():
        if isinstance(kind, Expression):
            try:
                Formula(kind.expression, names)
            except ExpressionError as error:
                at, value = f'sweep.vary."{path}".expression', kind.expression
                report.problems.append(explained(kind.expression, error).at(at, value))
    if len(report.problems) == before:
        ordered(vary, parameters, report.problems)
