"""What is wrong with what runs shall tell: the sections [output] and [sweep.stop], measures, requirements."""

from collections import Counter

from lienumba.errors import ScenarioError
from lienumba.mechanics.elements.quantities import INPUTS, is_input
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.scenario.base.arguments import parse_ranges
from lienumba.scenario.base.paths import MEASURES, REQUIREMENTS
from lienumba.scenario.base.problems import Report, placed
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.integrator import Lists
from lienumba.scenario.checks.joints import coordinates_of
from lienumba.scenario.formulas.measures import is_formula
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.output import Output
from lienumba.scenario.schema.requirements import LIMITS, Requirement
from lienumba.scenario.schema.sweep import Stop
from lienumba.words import show, suggestion

ASK = "give joint_coordinates = true"
LISTED = "docs/write_a_scenario.md lists those that are reserved"


def check_output(output: Output, lists: Lists, parameters: Parameters, report: Report) -> None:
    """Check that what is to be stored exists: variables, quantities and their components, and laws with states."""
    own = [*JOINT_COORDINATES] if output.joint_coordinates else []
    seen = [str(item.get("name")) for kind in ("quantities", "noise") for item in lists[kind]]
    known = [*OUTPUT_VARIABLES, *own, *seen, *with_states(lists)]
    inputs = sorted(filter(is_input, parameters.quantities))
    known += [INPUTS, *inputs] if inputs else []
    lists_of_names = {"variables": output.variables, "also": output.also}
    for key, i, name in ((key, i, name) for key, names in lists_of_names.items() for i, name in enumerate(names)):
        if name in JOINT_COORDINATES and name not in known:
            report.add(f"output.{key}[{i}]", "is stored only where it is asked for", ASK, name)
        elif name not in known:
            report.add(f"output.{key}[{i}]", "is not known", suggestion(name, known), name)
    along = coordinates_of(lists["joints"])
    parts = [*known, *sorted(parameters.quantities - {*known}), *(f"{name}.{x}" for name in own for x in along)]
    for name in own:
        if any(item.get("name") == name for item in (*lists["quantities"], *lists["noise"], *lists["forces"])):
            rule = f"stores {name}, but a quantity or force has this name already"
            report.add("output.joint_coordinates", rule, "give that another name")
    for name, statistics in output.summary.items():
        if name.partition(".")[0] in JOINT_COORDINATES and not output.joint_coordinates and name not in parts:
            report.add(f"output.summary.{show(name)}", "is computed only where it is asked for", ASK)
        elif name not in parts:
            report.add(f"output.summary.{show(name)}", "is not known", suggestion(name, parts))
        for statistic, number in Counter(statistics).items():
            if number > 1:
                report.add(f"output.summary.{show(name)}", f'names "{statistic}" {number} times', "name it once")
    measures = [str(item.get("name")) for item in lists["measures"]]
    for i, name in enumerate(output.show or ()):
        if name not in (*known, *measures):
            report.add(f"output.show[{i}]", "is not known", suggestion(name, [*known, *measures]), name)
    for i, name in enumerate(output.at_events):
        if name not in parts:
            report.add(f"output.at_events[{i}]", "is not known", suggestion(name, parts), name)
        elif not lists["events"]:
            report.add(f"output.at_events[{i}]", "has no event where it could be", "add one, or leave it out", name)
        elif output.at_events.index(name) < i:
            report.add(f"output.at_events[{i}]", "is named before", "name it once", name)
    for name in output.precision if isinstance(output.precision, dict) else ():
        if name not in known:
            report.add(f"output.precision.{show(name)}", "is not known", suggestion(name, known))
        elif name in OUTPUT_VARIABLES and OUTPUT_VARIABLES[name].count:
            report.add(f"output.precision.{show(name)}", "counts, and is stored in whole numbers", "leave it out")
    if output.full_runs is None:
        return
    if output.mode == "full":
        rule = 'has no meaning in the mode "full", which stores the course of all runs'
        report.add("output.full_runs", rule, 'give mode = "summary", or leave it out', output.full_runs)
    try:
        parse_ranges(output.full_runs, f"output.full_runs = {show(output.full_runs)}")
    except ScenarioError as error:
        report.problems += error.problems


def with_states(lists: Lists) -> list[str]:
    """The forces whose states are stored by their names."""
    having = [str(force.get("name")) for force in lists["forces"] if force.get("states")]
    return [name for name in having if not _is_taken(name)]


def check_variable(place: str, name: object, report: Report) -> None:
    """The dataset has one variable of a name."""
    if _is_taken(name):
        rule, remedy = "the dataset has a variable of this name already", f"give another name; {LISTED}"
        report.add(f"{place}.name", rule, remedy, name)


def _is_taken(name: object) -> bool:
    from lienumba.store.layout import is_taken  # few scenarios name what the dataset holds

    return is_taken(name)


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
        requirement = report.element(place, Requirement, table)
        if requirement is None:
            continue
        for tokens, formula in parameters.places.items():
            if tokens[:2] == (REQUIREMENTS, requirement.name) and tokens[2] in LIMITS:
                follows = sorted(parameters.all_used(formula) & varied)
                if follows:
                    rule = f"depends on parameters.{follows[0]}, which the sweep varies, but is the same in all runs"
                    report.add(f"{place}.{tokens[2]}", rule, "put it into the value, which may differ", formula.text)


def check_stop(stop: Stop, runs: int, report: Report) -> None:
    """Check when a sweep of so many runs ends."""
    if stop.every > runs:
        report.add(
            "sweep.stop.every", f"is never reached by sweep.runs = {runs}", "give fewer, or more runs", stop.every
        )
