"""What formulas do with tables: whether these are long enough, and the times on which steps have to land."""

from collections.abc import Iterator, Mapping
from math import floor
from typing import TYPE_CHECKING, Any

from lienumba.compiler.jets import Jet, lift
from lienumba.expressions import Formula
from lienumba.mechanics.model import Model
from lienumba.scenario import paths
from lienumba.scenario.law_checks import check_function
from lienumba.scenario.parameters import Parameters, Tokens
from lienumba.scenario.words import show

if TYPE_CHECKING:
    import numpy as np

    from lienumba.scenario.report import Report

LINEAR = 1e-9  # a function of time that bends less than this fraction of itself is a straight line


def check_tables(parameters: Parameters, report: "Report") -> None:
    """Check what reads tables at the times of the run, with the nominal parameters."""
    if report.times is None:
        return
    times, values = report.times, parameters.values()
    for tokens, formula, name, argument in _of_time(parameters):
        table, x = parameters.tables[name], _argument(parameters, argument, values, times)
        at = f"model.{paths.text_of(list(tokens))} = {show(formula.text)}"
        if x.max() > table.last * (1.0 + LINEAR) + LINEAR:
            report.problems.append(
                f"tables.{name}: ends at {table.last:g}, but {at} reads it until {x.max():.6g}; add a point there, or "
                "end the run earlier"
            )
        if table.knots and _line(parameters, argument, values, float(times[-1])) is None:
            report.warnings.append(
                f"{at}: steps cannot land on the points of {name}, because its argument is no straight line in t, "
                "so the order of the method may be lost there; use a cubic table, or small steps"
            )
    for tokens, formula in parameters.places.items():
        if tokens[0] == "drivers" and not formula.used & parameters.quantities and parameters.reads(formula):
            at = f"model.{paths.text_of(list(tokens))}"
            prescribes_rate = tokens[2] == "rate"
            check_function(at, formula.text, parameters.number(formula, values), prescribes_rate, report)


def landings(parameters: Parameters, samples: Mapping[str, Any], end: float) -> "list[np.ndarray]":
    """The times of the points of tables, where the steps of a run to this end have to land: (n,) or (runs, n) each."""
    import numpy as np

    found = []
    values = parameters.values(samples)
    for _, _, name, argument in _of_time(parameters):
        line = _line(parameters, argument, values, end)
        if line is not None and parameters.tables[name].knots:
            a, b = (np.asarray(x, float)[..., None] for x in line)
            with np.errstate(all="ignore"):
                times = np.atleast_1d((np.array(parameters.tables[name].knots) - a) / b)
            found.append(times[0] if times.ndim == 2 and len(times) == 1 else times)
    return found


def samplings(model: Model, end: float) -> "list[np.ndarray]":
    """The times at which laws are sampled in a run to this end, but for the start: (n,) each."""
    import numpy as np

    intervals = {force.code.every for force in model.forces if force.code is not None and force.code.every is not None}
    return [np.arange(1, floor(end / every * (1.0 + LINEAR)) + 1) * every for every in sorted(intervals)]


def _of_time(parameters: Parameters) -> Iterator[tuple[Tokens, Formula, str, Formula]]:
    """The places where a table is read at a function of the time, with its name and argument."""
    for tokens, formula in parameters.places.items():
        for name, argument in formula.table_calls():
            if not argument.used & parameters.quantities and "t" in argument.used:
                yield tokens, formula, name, argument


def _argument(parameters: Parameters, argument: Formula, values: Mapping[str, Any], t: Any) -> Any:
    import numpy as np

    with np.errstate(all="ignore"):
        return parameters.function(argument, values)(t)


def _line(parameters: Parameters, argument: Formula, values: Mapping[str, Any], end: float) -> Any:
    """a and b of an argument a + b t, which may differ from run to run; None if it is no straight line."""
    import numpy as np

    x = lift(_argument(parameters, argument, values, Jet(0.0, 1.0)))
    for t in np.linspace(0.0, end, 17)[1:].tolist():
        later = _argument(parameters, argument, values, t)
        if not np.all(np.abs(x.a + x.b * t - later) <= LINEAR * (np.abs(x.a) + np.abs(x.b * t))):
            return None
    return x.a, x.b
