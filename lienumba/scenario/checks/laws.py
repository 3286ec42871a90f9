"""What is wrong with a driver or a force: the names it refers to and its numbers, one sentence each."""

import re
from keyword import iskeyword
from typing import Any

from lienumba.keys.conversions import timed
from lienumba.keys.formulas import (
    at_start,
    constant,
    derivatives,
    jump,
    not_finite_at_start,
    not_finite_later,
)
from lienumba.keys.types import NAME, NAME_RULE
from lienumba.mechanics.elements.forces import FORCE_TYPES
from lienumba.mechanics.elements.joints import COORDINATES
from lienumba.scenario.base.code import PYTHON
from lienumba.scenario.base.problems import GROUND, Report, check_name, read
from lienumba.scenario.checks.joints import Tables, check_two_bodies, find_coordinate
from lienumba.scenario.schema.forces import DRIVERS, FORCES, driver_form
from lienumba.store.layout import VARIABLES
from lienumba.words import show

DISSIPATIVE = (
    "stiffness", "damping", "rotational_stiffness", "rotational_damping", "viscous", "coulomb", "linear", "quadratic",
    "mu",
)  # fmt: skip
# Without any of these, a force does nothing.
EFFECTIVE = {
    "spring_damper": ("stiffness", "damping"),
    "torsion_spring": ("stiffness", "damping"),
    "bushing": ("stiffness", "damping", "rotational_stiffness", "rotational_damping"),
    "friction": ("viscous", "coulomb"),
    "drag": ("linear", "quadratic"),
}
NOT_NEGATIVE = ("limit", "free_length")


def check_driver(place: str, driver: dict[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one driver against the names of all bodies, and all joints by name."""
    form = driver_form(driver)
    if form is None:
        return
    if form != "joint":
        _check_body(place, driver.get("body"), bodies, report)
    checked: Any = read(DRIVERS[form], driver)
    if checked is None:
        return
    check_start(f"{place}.value", checked.value, 2 if form == "angular_velocity" else 3, report)
    check_jumps(f"{place}.value", checked.value, form == "angular_velocity", report)
    if form != "joint":
        return
    check_start(f"{place}.rate", checked.rate, 2, report)
    check_jumps(f"{place}.rate", checked.rate, True, report)
    find_coordinate(place, "joint", checked.joint, "coordinate", checked.coordinate, joints, report)
    if (checked.value is None) == (checked.rate is None):
        which = "has neither value nor rate" if checked.value is None else "has both value and rate"
        report.problems.append(
            f"{place}: {which}; give either value (the coordinate itself) or rate (its speed) as a number or a "
            'formula of t, such as "0.3*sin(2*t)"'
        )


def check_start(at: str, value: Any, orders: int, report: Report) -> None:
    """Check that a number that varies in time, or a list of them, has so many finite derivatives when it begins."""
    for where, x in _numbers(at, value):
        problem = not_finite_at_start(x, orders)
        if problem is None and isinstance(x, str) and report.times is not None:
            problem = not_finite_later(x, orders, report.times)
        if problem is not None:
            report.problems.append(f"{where} = {show(x)}: {problem}")


def check_jumps(at: str, value: Any, prescribes_rate: bool, report: Report) -> None:
    """What is prescribed may not jump; if its rate does, that is an impact."""
    for where, x in _numbers(at, value):
        if isinstance(x, str):
            check_function(where, x, x, prescribes_rate, report)


def check_function(at: str, text: str, function: Any, prescribes_rate: bool, report: Report) -> None:
    """Check one function of the time, or the text of its formula, for jumps."""
    if report.times is None:
        return
    a, b, c = derivatives(function, report.times)
    found = None if prescribes_rate else jump(a, b, report.times)
    if found is not None:
        report.problems.append(
            f"{at} = {show(text)}: jumps by {found[1]:.3g} at t = {found[0]:.6g}, and nothing can move at once; "
            f"write a smooth transition, such as 0.5*(1 + tanh((t - {found[0]:.3g})/0.02))"
        )
        return
    found = jump(a, b, report.times) if prescribes_rate else jump(b, c, report.times)
    if found is not None:
        report.warnings.append(
            f"{at} = {show(text)}: the speed that it prescribes jumps by {found[1]:.3g} at t = {found[0]:.6g}, an "
            "impact whose work nobody counts; smooth it with tanh, or expect an energy_residual"
        )


def check_driven_once(drivers: list[dict[str, Any]], joints: Tables, report: Report) -> None:
    """No coordinate, point or rotation may have two drivers."""
    seen: dict[tuple[str, ...], str] = {}
    key: tuple[str, ...]
    for driver in drivers:
        form = driver_form(driver)
        checked: Any = read(DRIVERS[form], driver) if form is not None else None
        if checked is None:
            continue
        if form == "joint":
            found = find_coordinate("", "", checked.joint, "", checked.coordinate, joints, Report())
            if found is None:
                continue
            key, what = found, f"the {found[1]} of {found[0]}"
        elif form == "point":
            key, what = (
                ("point", checked.body, str(checked.point)),
                f"the point {show(checked.point)} of {checked.body}",
            )
        else:
            key, what = ("rotation", checked.body), f"the rotation of {checked.body}"
        if key in seen:
            report.problems.append(
                f"model.drivers.{checked.name}: drives {what}, which {seen[key]} drives already; remove one of the two"
            )
        seen[key] = checked.name


def check_force(place: str, force: dict[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one force against the names of all bodies, and all joints by name."""
    name = force.get("type")
    if not isinstance(name, str) or name not in FORCES:
        return
    if name == PYTHON:
        _check_own(place, force, bodies, joints, report)
        return
    kind = FORCE_TYPES[name]
    if kind.ends == "bodies":
        check_two_bodies(place, force.get("bodies"), bodies, report)
    elif kind.ends == "body":
        _check_body(place, force.get("body"), bodies, report)
    checked: Any = read(FORCES[name], force)
    if checked is None:
        return
    if kind.ends == "joint":
        found = find_coordinate(place, "joint", checked.joint, "coordinate", checked.coordinate, joints, report)
        if found is not None and found[1] not in kind.coordinate_kinds:
            type_of_joint = joints[checked.joint]["type"]
            if "angle" in COORDINATES[type_of_joint]:
                report.problems.append(f'{place}.coordinate = "{found[1]}": a {name} acts on an angle; give "angle"')
            else:
                report.problems.append(
                    f"{place}.joint = {show(checked.joint)}: is a {type_of_joint} joint, which has no angle for a "
                    f"{name} to act on; use an actuator (stiffness, damping, target), or a spring_damper"
                )
    for key in kind.numbers:
        stored = kind.potential is not None and not key.endswith("damping")  # its rate does work
        follows = key == "target" and "damping" in checked.model_fields_set
        check_start(f"{place}.{key}", getattr(checked, key), 2 if stored or follows else 1, report)
        _check_number(place, key, getattr(checked, key), report)
    _check_together(place, checked, report)


def _check_own(place: str, force: dict[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """A law of the user's own: the names it refers to and its numbers."""
    for key, known, what in (("bodies", [*bodies, GROUND], "a body"), ("joints", list(joints), "a joint")):
        for i, name in enumerate(force[key] if isinstance(force.get(key), list) else []):
            check_name(f"{place}.{key}[{i}]", name, known, what, report)
    checked: Any = read(FORCES[PYTHON], force)
    if checked is None:
        return
    if not checked.bodies and not checked.joints:
        report.problems.append(f"{place}: sees nothing; give bodies or joints, as the function takes them")
    if checked.returns == "potential" and (checked.states or checked.every is not None):
        report.problems.append(
            f"{place}: a potential energy has neither states nor samples; leave states and every out"
        )
    if checked.states and checked.name in VARIABLES:
        report.problems.append(
            f"{place}.name = {show(checked.name)}: its states are stored by this name, which the dataset has already; "
            "give another name"
        )
    for name in checked.states:
        if not re.fullmatch(NAME, name) or iskeyword(name):
            report.problems.append(f"{place}.states: {show(name)} is no valid name; give {NAME_RULE}")
    for name, value in checked.parameters.items():
        check_start(f"{place}.parameters.{name}", value, 1, report)


def _check_body(place: str, name: Any, bodies: list[str], report: Report) -> None:
    if name == GROUND:
        report.problems.append(f'{place}.body = "{GROUND}": the ground does not move; name a body')
    else:
        check_name(f"{place}.body", name, bodies, "a body", report)


def _numbers(at: str, value: Any) -> list[tuple[str, Any]]:
    """A number, or those of a list, each with its path."""
    return [(f"{at}[{i}]", x) for i, x in enumerate(value)] if isinstance(value, list) else [(at, value)]


def _check_number(place: str, key: str, value: Any, report: Report) -> None:
    for at, given in _numbers(f"{place}.{key}", value):
        if given is None:
            continue
        number, fixed = at_start(timed(given))[0], constant(given) is not None
        when = "" if fixed else f", and is {number:.6g} at t = 0"
        if key in DISSIPATIVE and fixed and number < 0.0:
            report.warnings.append(
                f"{at} = {show(given)}: is negative, so it pushes away or feeds energy in; check its sign"
            )
        if key in NOT_NEGATIVE and number < 0.0:
            report.problems.append(f"{at} = {show(given)}: must be at least 0{when}; give its size without a sign")
        if key == "velocity" and number <= 0.0:
            report.problems.append(
                f"{at} = {show(given)}: must be above 0{when}; give the speed at which sliding sets in"
            )


def _check_together(place: str, force: Any, report: Report) -> None:
    if force.type == "end_stop":
        lower, upper = constant(force.lower), constant(force.upper)
        if force.lower is None and force.upper is None:
            report.problems.append(f"{place}: has no stop; give lower, upper or both")
        elif lower is not None and upper is not None and not lower < upper:
            remedy = "exchange the two" if lower > upper else "move them apart"
            report.problems.append(
                f"{place}.lower = {show(force.lower)}: must be below upper = {show(force.upper)}; {remedy}"
            )
    effective = EFFECTIVE.get(force.type, ())
    if effective and not force.model_fields_set.intersection(effective):
        report.warnings.append(
            f"{place}: has neither {' nor '.join(effective)}, so it does nothing; give one of them, or remove the force"
        )
    if force.type == "actuator":
        given = force.model_fields_set
        if not given & {"value", "stiffness", "damping", "target"}:
            report.problems.append(
                f"{place}: has neither value nor stiffness nor damping, so it does nothing; give value, or stiffness, "
                "damping and target"
            )
        if "target" in given and not given & {"stiffness", "damping"}:
            report.problems.append(
                f"{place}.target = {show(force.target)}: has no effect without stiffness or damping; give them"
            )
