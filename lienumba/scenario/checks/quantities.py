"""What is wrong with a quantity: the names it refers to, and what its own name hides; one sentence each."""

from typing import Any

from lienumba.mechanics.elements.joints import coordinate_kinds
from lienumba.scenario.base.problems import GROUND, Report, check_name, read
from lienumba.scenario.checks.bodies import check_rotation
from lienumba.scenario.schema.quantities import QUANTITIES
from lienumba.store.layout import COORDINATES as DIMENSIONS
from lienumba.store.layout import VARIABLES
from lienumba.words import listed, show

Lists = dict[str, list[dict[str, Any]]]


def check_quantity(place: str, quantity: dict[str, Any], lists: Lists, report: Report) -> None:
    """Check one quantity against the names of everything."""
    name = quantity["name"]
    if name in VARIABLES or name in DIMENSIONS:
        report.problems.append(
            f"{place}.name = {show(name)}: the dataset has a variable of this name already; give another name"
        )
    if name in with_states(lists):
        report.problems.append(
            f"{place}.name = {show(name)}: is also the name of model.forces.{name}, whose states are stored; "
            "give another name"
        )
    bodies = [body["name"] for body in lists["bodies"]]
    of_bodies = [("body", bodies), ("relative_to", [*bodies, GROUND])]
    if quantity.get("type") == "reaction":
        of_bodies = []
    elif quantity.get("frame") is not None:
        of_bodies.append(("frame", [*bodies, "global", "body"]))
    for key, known in of_bodies:
        check_name(f"{place}.{key}", quantity.get(key), known, "a body", report)
    for i, body in enumerate(quantity["bodies"] if isinstance(quantity.get("bodies"), list) else []):
        check_name(f"{place}.bodies[{i}]", body, bodies, "a body", report)
        if body in quantity["bodies"][:i]:
            report.problems.append(f"{place}.bodies[{i}] = {show(body)}: is named twice; name it once")
    for kind in ("joint", "driver"):
        known = [item["name"] for item in lists[f"{kind}s"]]
        check_name(f"{place}.{kind}", quantity.get(kind), known, f"a {kind}", report)
    checked: Any = read(QUANTITIES.get(str(quantity.get("type"))), quantity)
    if checked is None:
        return
    if checked.type == "joint":
        _check_joint(place, checked.joint, lists, report)
    if checked.type == "rotation_error":
        check_rotation(f"{place}.target", checked.target, report)
    if (
        checked.type in ("point", "rotation_error", "angular_velocity")
        and checked.relative_to == checked.body != GROUND
    ):
        report.problems.append(
            f"{place}.relative_to = {show(checked.body)}: is the body itself; name another one, or leave it out"
        )


def with_states(lists: Lists) -> list[str]:
    """The forces whose states are stored by their names."""
    return [str(f.get("name")) for f in lists["forces"] if f.get("states") and f.get("name") not in VARIABLES]


def _check_joint(place: str, name: str, lists: Lists, report: Report) -> None:
    """A joint needs a coordinate to be looked at."""
    joint = next((j for j in lists["joints"] if j["name"] == name), None)
    if joint is not None and not coordinate_kinds(joint.get("type")):
        having = [j["name"] for j in lists["joints"] if coordinate_kinds(j.get("type"))]
        remedy = (
            f"joints that have one are {listed(having)}" if having else "look at a point or a rotation_error instead"
        )
        kind = joint.get("type")
        report.problems.append(f"{place}.joint = {show(name)}: a {kind} joint has no angle or displacement; {remedy}")
