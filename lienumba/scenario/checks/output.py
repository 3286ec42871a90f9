"""What is wrong with the section [output]: names of what is to be stored, and runs; one sentence each."""

from collections import Counter

from lienumba.errors import ScenarioError
from lienumba.mechanics.elements.quantities import INPUTS, is_input
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.scenario.base.arguments import parse_ranges
from lienumba.scenario.base.problems import Report
from lienumba.scenario.checks.joints import coordinates_of
from lienumba.scenario.checks.quantities import Lists, with_states
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.output import Output
from lienumba.words import show, suggestion

ASK = "give joint_coordinates = true"


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
        report.add(
            "output.full_runs",
            'has no meaning in the mode "full", which stores the course of all runs',
            'give mode = "summary", or leave it out',
            output.full_runs,
        )
    try:
        parse_ranges(output.full_runs, f"output.full_runs = {show(output.full_runs)}")
    except ScenarioError as error:
        report.problems += error.problems
