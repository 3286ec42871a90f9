"""What is wrong with a quantity: the names it refers to, and what its own name hides; one sentence each."""

from lienumba.mechanics.elements.joints import coordinate_kinds
from lienumba.mechanics.elements.quantities import QUANTITIES
from lienumba.mechanics.elements.quantities.base import Refers
from lienumba.scenario.base.problems import Report, check_name, names_of, read
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.bodies import check_rotation
from lienumba.store.layout import COORDINATES as DIMENSIONS
from lienumba.store.layout import VARIABLES
from lienumba.words import listed

SINGULAR = {"bodies": "body", "joints": "joint", "drivers": "driver"}

Lists = dict[str, list[Keys]]


def check_quantity(place: str, quantity: Keys, lists: Lists, report: Report) -> None:
    """Check one quantity against the names of everything."""
    name = quantity["name"]
    if name in VARIABLES or name in DIMENSIONS:
        report.add(f"{place}.name", "the dataset has a variable of this name already", "give another name", name)
    if name in with_states(lists):
        report.add(
            f"{place}.name",
            f"is also the name of model.forces.{name}, whose states are stored",
            "give another name",
            name,
        )
    kind = QUANTITIES.get(str(quantity.get("type")))
    if kind is None:
        return
    for key, refers in kind.references().items():
        _check_references(f"{place}.{key}", quantity.get(key), names_of(lists[refers.to]), refers, report)
    checked = read(kind, quantity)
    if checked is None:
        return
    if kind.reads_coordinates:
        _check_joint(place, str(quantity["joint"]), lists, report)
    for key in kind.rotations:
        check_rotation(f"{place}.{key}", getattr(checked, key), report)
    for fault in checked.faults():
        report.problems.append(fault.below(place))


def _check_references(at: str, value: object, named: list[str], refers: Refers, report: Report) -> None:
    """A name, or a list of different ones."""
    what = f"a {SINGULAR[refers.to]}"
    if not isinstance(value, list):
        check_name(at, value, [*named, *refers.others], what, report)
        return
    for i, name in enumerate(value):
        check_name(f"{at}[{i}]", name, [*named, *refers.others], what, report)
        if name in value[:i]:
            report.add(f"{at}[{i}]", "is named twice", "name it once", name)


def with_states(lists: Lists) -> list[str]:
    """The forces whose states are stored by their names."""
    return [str(f.get("name")) for f in lists["forces"] if f.get("states") and f.get("name") not in VARIABLES]


def _check_joint(place: str, name: str, lists: Lists, report: Report) -> None:
    """A joint needs a coordinate to be looked at."""
    joint = next((j for j in lists["joints"] if j["name"] == name), None)
    if joint is not None and not coordinate_kinds(joint.get("type")):
        having = names_of(j for j in lists["joints"] if coordinate_kinds(j.get("type")))
        remedy = (
            f"joints that have one are {listed(having)}" if having else "look at a point or a rotation_error instead"
        )
        kind = joint.get("type")
        report.add(f"{place}.joint", f"a {kind} joint has no angle or displacement", remedy, name)
