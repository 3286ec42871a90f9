"""What is wrong with measures, requirements and the section [sweep.stop]: names, limits, and when there are runs
enough; one sentence each."""

from lienumba.scenario.base.paths import MEASURES, REQUIREMENTS
from lienumba.scenario.base.problems import Report, placed, read
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.quantities import Lists, check_variable
from lienumba.scenario.formulas.measures import is_formula
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.requirements import LIMITS, Requirement
from lienumba.scenario.schema.stop import Stop
from lienumba.sweep.samplers import SAMPLERS
from lienumba.words import suggestion


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


def check_stop(stop: Stop, sweep: Keys, runs: int, requirements: list[Keys], report: Report) -> None:
    """Check when a sweep of so many runs ends."""
    sampler = SAMPLERS.get(str(sweep.get("sampler")))
    if stop.requirement is not None and sampler is not None and sampler.row:
        rule = f'decides by independent runs, but those of the sampler "{sampler.name}" share their samples'
        report.add("sweep.stop.requirement", rule, 'use the sampler "random"', stop.requirement)
    _check_weights(sweep, sampler is not None and sampler.weighted, requirements, report)
    if stop.variable is None and stop.requirement is None:
        report.miss("sweep.stop.variable", "give it with width, or give requirement")
    if stop.requirement is not None:
        _check_decided(stop, stop.requirement, [str(x.get("name")) for x in requirements], report)
    elif stop.variable is not None:
        _check_statistic(stop, report)
    if stop.every > runs:
        report.add(
            "sweep.stop.every", f"is never reached by sweep.runs = {runs}", "give fewer, or more runs", stop.every
        )


def _check_weights(sweep: Keys, weighted: bool, requirements: list[Keys], report: Report) -> None:
    """Runs with weights are asked on the way only where these have a bound; weighted: by the sampler."""
    table = sweep.get("table")
    if isinstance(table, dict) and table.get("weights") is not None:
        rule = "needs weights that are known never to exceed a number, and those of a table are not"
        report.add("sweep.stop", rule, "take it out, or the column weight out of the table")
    for place, requirement in placed(REQUIREMENTS, requirements) if weighted else ():
        if requirement.get("failed") == "ignore":
            rule = "has no bounds at every run where runs have weights, and [sweep.stop] asks for them"
            report.add(f"{place}.failed", rule, 'give failed = "count", or take sweep.stop out', "ignore")


def _check_decided(stop: Stop, name: str, known: list[str], report: Report) -> None:
    """A sweep that ends where a requirement is decided, which has its own numbers."""
    if name not in known:
        remedy = suggestion(name, known) if known else "write it as [[requirements]]"
        report.add("sweep.stop.requirement", "is no requirement of the scenario", remedy, name)
    for key in ("variable", "width", "probability"):
        if getattr(stop, key) is not None:
            rule = "has no meaning where a requirement decides"
            report.add(f"sweep.stop.{key}", rule, "leave it out, or leave requirement out", getattr(stop, key))
    for key in ("statistic", "confidence"):
        if getattr(stop, key) != Stop.model_fields[key].default:  # a scenario that is written out has the defaults
            rule = "has no meaning where a requirement decides, which has its own"
            report.add(f"sweep.stop.{key}", rule, "leave it out", getattr(stop, key))


def _check_statistic(stop: Stop, report: Report) -> None:
    """A sweep that ends where the interval of a mean or quantile is narrow enough."""
    if stop.width is None:
        report.miss("sweep.stop.width", f"give {Stop.model_fields['width'].description}")
    if stop.statistic == "quantile" and stop.probability is None:
        report.miss("sweep.stop.probability", "give that of the quantile, such as 0.95")
    if stop.statistic == "mean" and stop.probability is not None:
        report.add(
            "sweep.stop.probability",
            "has no meaning for a mean",
            'leave it out, or give statistic = "quantile"',
            stop.probability,
        )
