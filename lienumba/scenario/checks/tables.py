"""What formulas do with tables: whether these are long enough, and whether steps can land on their points."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.mechanics.mechanism.tables import ERROR, Table
from lienumba.mechanics.tolerances import SAME_TIME_RTOL
from lienumba.numerics.expressions import Formula
from lienumba.scenario.base import paths
from lienumba.scenario.base.paths import Tokens
from lienumba.scenario.base.problems import Report
from lienumba.scenario.checks.drivers import check_function
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.words import show

CHOICES = 'outside = "hold" or 0'
UNSAID = (None, ERROR)  # with which a table must not be read outside of its points


def check_tables(parameters: Parameters, report: Report) -> None:
    """Check what reads tables at the times of the run, with the nominal parameters."""
    if report.times is None:
        return
    times, values = report.times, parameters.values()
    for tokens, formula, name, argument in _of_time(parameters):
        table, x = parameters.tables[name], _argument(parameters, argument, values, times)
        at = paths.written(tokens)
        reads = f"{at} = {show(formula.text)} reads it"
        check_range(table, float(x.min()), float(x.max()), f"tables.{name}", reads, report)
        if table.knots and not argument.is_line(parameters.quantities | parameters.tables.keys()):
            rule = f"steps cannot land on the points of {name}, because its argument is no straight line in t"
            lost = "so the order of the method may be lost there"
            report.warn(at, f"{rule}, {lost}", "use a cubic table, or small steps", formula.text)
    for tokens, formula in parameters.places.items():
        if tokens[0] == "drivers" and not parameters.follows(formula) and parameters.reads(formula):
            at = paths.written(tokens)
            prescribes_rate = tokens[2] == "rate"
            check_function(at, formula.text, parameters.number(formula, values), prescribes_rate, report)


def check_samples(parameters: Parameters, samples: Mapping[str, Any], labels: Sequence[int], end: float) -> None:
    """A ScenarioError if a table ends before a run asks for its last value."""
    values = parameters.values(samples)
    for tokens, formula, name, argument in _of_time(parameters):
        reached = np.atleast_1d(_argument(parameters, argument, values, end))
        table = parameters.tables[name]
        beyond = np.flatnonzero((table.outside in UNSAID) & (reached > table.last + _margin(table.last)))
        if len(beyond):
            at, run = f"{paths.written(tokens)} = {show(formula.text)}", labels[beyond[0]]
            rule = f"ends at {table.last:g}, but {at} reads it until {reached[beyond[0]]:.6g} in run {run}"
            remedy = f"add a point there, end the run earlier, give less spread, or {CHOICES}"
            raise ScenarioError.at(f"tables.{name}", rule, remedy)


def check_range(table: Table, first: float, last: float, at: str, reads: str, report: Report) -> None:
    """Whether a table may be read from the first to the last argument. reads: who reads it, in words."""
    if table.outside not in UNSAID:
        return
    if last > table.last + _margin(table.last):
        remedy = f"add a point there, end the run earlier, or give {CHOICES}"
        report.add(at, f"ends at {table.last:g}, but {reads} until {last:.6g}", remedy)
    if first < table.first - _margin(table.first):
        rule = f"begins at {table.first:g}, but {reads} from {first:.6g} on"
        if table.outside == ERROR:
            report.add(at, rule, f"add a point there, or give {CHOICES}")
        else:
            report.warn(at, f"{rule}, and has its first value there", f"give {CHOICES}")


def _margin(x: float) -> float:
    """Roundoff of an argument."""
    return SAME_TIME_RTOL * abs(x) + SAME_TIME_RTOL


def _of_time(parameters: Parameters) -> Iterator[tuple[Tokens, Formula, str, Formula]]:
    """The places where a table is read at a function of the time, with its name and argument."""
    for tokens, formula in parameters.places.items():
        for name, argument in formula.table_calls():
            if not parameters.follows(argument) and "t" in argument.used:
                yield tokens, formula, name, argument


def _argument(parameters: Parameters, argument: Formula, values: Mapping[str, Any], t: object) -> Any:
    with np.errstate(all="ignore"):
        return parameters.function(argument, values)(t)
