"""What the parts of a scenario say about one another: all problems are found, one sentence each.

The checks of rarer parts are imported where a scenario has these.
"""

import re
from collections import Counter

from lienumba.keys.types import NAME, Section
from lienumba.scenario.base import paths
from lienumba.scenario.base.paths import INPUTS, JUDGING, LISTS, REQUIREMENTS
from lienumba.scenario.base.problems import GROUND, Report, names_of, placed, read, tables
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.checks.bodies import check_bases, check_body, check_shapes
from lienumba.scenario.checks.integrator import Lists, check_integrator, check_method, check_projection
from lienumba.scenario.checks.joints import check_coordinates, check_joint
from lienumba.scenario.checks.output import check_names, check_output, check_requirements, check_stop
from lienumba.scenario.checks.times import check_times, looked_at
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.output import Output
from lienumba.scenario.schema.scenario import (
    Body,
    Gravity,
    Integrator,
    Projection,
    ScenarioData,
    Sensitivities,
    Standing,
    StartSection,
)
from lienumba.scenario.schema.sections import section_of
from lienumba.scenario.schema.sweep import Stop
from lienumba.words import listed


def check_scenario(raw: Keys, data: ScenarioData | None, parameters: Parameters) -> Report:
    """Check a scenario's keys against each other; what is wrong in itself is passed over (see `messages`). data: the
    scenario, None where something is; raw: as it is written."""
    report, sections = Report(), raw if data is None else dict(data)
    model = raw.get("model")
    model = model if isinstance(model, dict) else {}
    lists = {kind: tables(model.get(kind)) for kind in LISTS}
    for kind, items in lists.items():
        _check_names(kind, items, report)
    integrator = read(Integrator, sections.get("integrator"))
    if integrator is not None:
        report.times = looked_at(integrator)
        check_method(integrator, lists, report)
    projection = report.element("projection", Projection, sections.get("projection", {}))
    if projection is not None:
        check_projection(projection, integrator, lists, report)
    named = all(_named(items) for kind, items in lists.items() if kind not in JUDGING) and bool(lists["bodies"])
    if named:
        _check_model(lists, table_in(model, INPUTS), parameters, report)
        start = report.element("start", StartSection, model["start"]) if "start" in model else None
        if start is not None:
            check_coordinates(start.q, start.qd, lists["joints"], report)
    if parameters.places:
        from lienumba.scenario.checks.tables import check_tables

        check_tables(parameters, report)
    gravity = read(Gravity, _alone(Gravity, model) if data is None else data.model)
    standing = read(Standing, _alone(Standing, model) if data is None else data.model)
    if gravity is not None and any(isinstance(x, str) for x in gravity.gravity):
        from lienumba.scenario.checks.drivers import check_start

        check_start("model.gravity", gravity.gravity, 1, report)
    bodies = lists["bodies"] if data is None else data.model.bodies
    for (place, _), body in zip(placed("bodies", lists["bodies"]), bodies, strict=True):
        checked = read(Body, body)
        if checked is not None:
            check_body(place, checked, None if integrator is None else integrator.coordinates, report)
            check_shapes(f"{place}.shapes", checked.shapes, report)
    if standing is not None:
        check_shapes("model.ground_shapes", standing.ground_shapes, report)
    if integrator is not None:
        output = read(Output, sections.get("output", {}))
        if check_integrator(integrator, report):
            check_times(integrator, output, report)
        if output is not None:
            check_output(output, lists, parameters, report)
    sweep = raw.get("sweep")
    check_names(lists, report)
    check_requirements(lists[REQUIREMENTS], table_in(raw, "sweep"), parameters, report)
    if isinstance(sweep, dict) and named:
        from lienumba.scenario.checks.sweep import check_sweep

        check_sweep(sweep, _numbers_of(model, lists), parameters, report)
        stop, runs = report.element("sweep.stop", Stop, sweep.get("stop")), sweep.get("runs", 1)
        if stop is not None and isinstance(runs, int):
            check_stop(stop, runs, report)
    asked = report.element("sensitivities", Sensitivities, raw.get("sensitivities"))
    if asked is not None and named:
        from lienumba.scenario.checks.sensitivities import check_sensitivities

        check_sensitivities(asked, raw, _numbers_of(model, lists), parameters, integrator, report)
    study = raw.get("study")
    if isinstance(study, dict) and named:
        from lienumba.scenario.checks.study import check_study

        if isinstance(sweep, dict) and "stop" in sweep:
            report.add("sweep.stop", "a study needs all runs at every point", "leave it out")
        if lists[REQUIREMENTS]:
            report.add(REQUIREMENTS, "a study compares settings and judges no runs", "leave them out")
        check_study(study, raw.get("output"), model, names_of(lists["bodies"]), parameters, report)
    return report


def _alone(section: type[Section], table: Keys) -> Keys:
    """The keys of a section out of a table that has those of others."""
    return {key: x for key, x in table.items() if key in section.model_fields}


def _check_model(lists: Lists, inputs: Keys, parameters: Parameters, report: Report) -> None:
    """What refers to names."""
    bodies = names_of(lists["bodies"])
    joints = {str(joint["name"]): joint for joint in lists["joints"]}
    check_bases(lists["bodies"], bodies, report)
    for place, joint in placed("joints", lists["joints"]):
        check_joint(place, joint, bodies, joints, report)
    if lists["drivers"]:
        from lienumba.scenario.checks.drivers import check_driven_once, check_driver

        for place, driver in placed("drivers", lists["drivers"]):
            check_driver(place, driver, bodies, joints, report)
        check_driven_once(lists["drivers"], joints, report)
    if lists["forces"]:
        from lienumba.scenario.checks.forces import check_force

        for place, force in placed("forces", lists["forces"]):
            check_force(place, force, bodies, joints, report)
    switched = any("locked" in joint or "active" in joint for joint in lists["joints"])
    changing = lists["limits"] or lists["contacts"] or lists["events"] or switched
    if changing:
        from lienumba.scenario.checks.changes import check_contact, check_events, check_limit

        for place, limit in placed("limits", lists["limits"]):
            check_limit(place, limit, joints, report)
        for place, contact in placed("contacts", lists["contacts"]):
            check_contact(place, contact, bodies, joints, report)
    if lists["quantities"] or lists["noise"] or inputs:
        from lienumba.scenario.checks.quantities import check_inputs, check_noise, check_quantity

        for place, quantity in placed("quantities", lists["quantities"]):
            check_quantity(place, quantity, lists, report)
        for place, noise in placed("noise", lists["noise"]):
            check_noise(place, noise, lists, report)
        check_inputs(inputs, joints, report)
    if changing:
        check_events(lists, parameters, report)


def _named(items: list[Keys]) -> bool:
    """Whether each has a name of its own by which it can be known."""
    names = [item.get("name") for item in items]
    return len(set(map(str, names))) == len(names) and all(
        isinstance(name, str) and re.fullmatch(NAME, name) and name != GROUND for name in names
    )


def _numbers_of(model: Keys, lists: Lists) -> Keys:
    """What may vary: the model with the default of gravity and without unknown keys."""
    numbers: Keys = {"gravity": model.get("gravity", [0.0, 0.0, -9.81])}
    start = model.get("start")
    if isinstance(start, dict):
        numbers["start"] = {key: x for key, x in start.items() if key in ("q", "qd", "rotation")}
    numbers |= {key: model[key] for key in Standing.model_fields if key in model}
    for kind, items in ((kind, items) for kind, items in lists.items() if kind not in JUDGING):
        numbers[kind] = [_known_keys(kind, item) for item in items]
    numbers[INPUTS] = table_in(model, INPUTS)
    return numbers


def _known_keys(kind: str, item: Keys) -> Keys:
    section = section_of(kind, item)
    known = {"name", "type"} if section is None else {"name", "type", *section.model_fields}
    return {key: value for key, value in item.items() if key in known}


def _check_names(kind: str, items: list[Keys], report: Report) -> None:
    for index, item in enumerate(items):
        if item.get("name") == GROUND:
            report.add(
                f"{paths.written((kind, index))}.name", "is reserved for the fixed world", "give another name", GROUND
            )
    counts = Counter(item["name"] for item in items if isinstance(item.get("name"), str))
    for name, number in counts.items():
        if number > 1:
            places = [paths.written((kind, index)) for index, item in enumerate(items) if item.get("name") == name]
            report.add(
                f"{places[-1]}.name", f"is also the name of {listed(places[:-1])}", "give each its own name", name
            )
