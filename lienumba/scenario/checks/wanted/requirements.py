"""Check measures, requirements and the section [sweep.stop]."""

from lienumba.scenario.base.paths import MEASURES, REQUIREMENTS
from lienumba.scenario.base.problems import Report, placed, read
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.quantities import Lists, check_variable
from lienumba.scenario.formulas.measures import is_formula
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.requirements import LIMITS, Requirement
from lienumba.scenario.schema.stop import Stop


def check_names(lists: Lists, report: Report) -> None:
    """Check the names of the variables that measures are, and requirements whose values are formulas."""
    measures, requirements = placed(MEASURES, lists[MEASURES]), placed(REQUIREMENTS, lists[REQUIREMENTS])
    for place, table in (*measures, *((at, x) for at, x in requirements if is_formula(str(x.get("value"))))):
        check_variable(place, table.get("name"), report)


def check_requirements(requirements: list[Keys], sweep: Keys, parameters: Parameters, report: Report) -> None:
    """Check the limits of every requirement, which are the same in all runs."""
    vary = sweep.get("vary")
    varied = {str(path).removeprefix("parameters.") for path in vary} if isinstance(vary, dict) else set()
    for place, table in placed(REQUIREMENTS, requirements):
        requirement = read(Requirement, table)
        if requirement is None:
            continue
        report.problems += [fault.below(place) for fault in requirement.faults()]
        for tokens, formula in parameters.places.items():
            if tokens[:2] == (REQUIREMENTS, requirement.name) and tokens[2] in LIMITS:
                follows = sorted(parameters.all_used(formula) & varied)
                if follows:
                    rule = f"depends on parameters.{follows[0]}, which the sweep varies, but is the same in all runs"
                    report.add(f"{place}.{tokens[2]}", rule, "put it into the value, which may differ", formula.text)


def check_stop(stop: Stop, runs: int, report: Report) -> None:
    """Check when a sweep of so many runs ends."""
    if stop.statistic == "quantile" and stop.probability is None:
        report.miss("sweep.stop.probability", "give that of the quantile, such as 0.95")
    if stop.statistic == "mean" and stop.probability is not None:
        report.add(
            "sweep.stop.probability",
            "has no meaning for a mean",
            'leave it out, or give statistic = "quantile"',
            stop.probability,
        )
    if stop.every > runs:
        report.add(
            "sweep.stop.every", f"is never reached by sweep.runs = {runs}", "give fewer, or more runs", stop.every
        )
