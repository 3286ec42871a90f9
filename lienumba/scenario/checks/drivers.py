"""What is wrong with a driver: the names it refers to and its numbers, one sentence each."""

from typing import Any

from lienumba.keys.formulas import (
    derivatives,
    jump,
    not_finite_at_start,
    not_finite_later,
)
from lienumba.mechanics.elements.drivers import DRIVERS, POSITION, JointDriver, driver_form
from lienumba.scenario.base.problems import GROUND, Report, check_name, read
from lienumba.scenario.checks.joints import Tables, find_coordinate
from lienumba.words import is_number


def check_driver(place: str, driver: dict[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one driver against the names of all bodies, and all joints by name."""
    form = driver_form(driver)
    if form is None:
        return
    kind = DRIVERS[form]
    if "body" in kind.model_fields:
        check_driven_body(place, driver.get("body"), bodies, report)
    checked = report.element(place, kind, driver)
    if checked is None:
        return
    for key, level in checked.prescribed().items():
        value = getattr(checked, key)
        check_start(f"{place}.{key}", value, 3 if level == POSITION else 2, report)
        check_jumps(f"{place}.{key}", value, level != POSITION, report)
    if isinstance(checked, JointDriver):
        find_coordinate(place, "joint", checked.joint, "coordinate", checked.coordinate, joints, report)


def check_start(at: str, value: Any, orders: int, report: Report) -> None:
    """Check that a number that varies in time, or a list of them, has so many finite derivatives when it begins."""
    for where, x in numbers_at(at, value):
        if isinstance(x, str) and is_number(x):  # such as nan; the schema tells it
            continue
        wrong = not_finite_at_start(x, orders)
        if wrong is None and isinstance(x, str) and report.times is not None:
            wrong = not_finite_later(x, orders, report.times)
        if wrong is not None:
            report.problems.append(wrong.at(where, x))


def check_jumps(at: str, value: Any, prescribes_rate: bool, report: Report) -> None:
    """What is prescribed may not jump; if its rate does, that is an impact."""
    for where, x in numbers_at(at, value):
        if isinstance(x, str):
            check_function(where, x, x, prescribes_rate, report)


def check_function(at: str, text: str, function: Any, prescribes_rate: bool, report: Report) -> None:
    """Check one function of the time, or the text of its formula, for jumps."""
    if report.times is None:
        return
    a, b, c = derivatives(function, report.times)
    found = None if prescribes_rate else jump(a, b, report.times)
    if found is not None:
        rule = f"jumps by {found[1]:.3g} at t = {found[0]:.6g}, and nothing can move at once"
        remedy = f"write a smooth transition, such as 0.5*(1 + tanh((t - {found[0]:.3g})/0.02))"
        report.add(at, rule, remedy, text)
        return
    found = jump(a, b, report.times) if prescribes_rate else jump(b, c, report.times)
    if found is not None:
        rule = f"the speed that it prescribes jumps by {found[1]:.3g} at t = {found[0]:.6g}"
        counts = "an impact whose work nobody counts"
        report.warn(at, f"{rule}, {counts}", "smooth it with tanh, or expect an energy_residual", text)


def check_driven_once(drivers: list[dict[str, Any]], joints: Tables, report: Report) -> None:
    """No coordinate, point or rotation may have two drivers."""
    seen: dict[tuple[str, ...], str] = {}
    for driver in drivers:
        form = driver_form(driver)
        checked = read(DRIVERS[form], driver) if form is not None else None
        if checked is None:
            continue
        found = None
        if isinstance(checked, JointDriver):
            found = find_coordinate("", "", checked.joint, "", checked.coordinate, joints, Report())
            if found is None:
                continue
        key, what = checked.driven(found)
        if key in seen:
            rule = f"drives {what}, which {seen[key]} drives already"
            report.add(f"model.drivers.{checked.name}", rule, "remove one of the two")
        seen[key] = checked.name


def check_driven_body(place: str, name: Any, bodies: list[str], report: Report) -> None:
    """Check that a body is named that can move."""
    if name == GROUND:
        report.add(f"{place}.body", "the ground does not move", "name a body", GROUND)
    else:
        check_name(f"{place}.body", name, bodies, "a body", report)


def numbers_at(at: str, value: Any) -> list[tuple[str, Any]]:
    """A number, or those of a list, each with its path."""
    return [(f"{at}[{i}]", x) for i, x in enumerate(value)] if isinstance(value, list) else [(at, value)]
