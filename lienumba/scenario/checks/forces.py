"""What is wrong with a force: the names it refers to and its numbers, one sentence each."""

from lienumba.keys.conversions import timed
from lienumba.keys.formulas import at_start, constant
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.forces.base import AlongJoint, BetweenPoints, OnBody
from lienumba.mechanics.elements.forces.numbers import Sign
from lienumba.mechanics.elements.forces.python import PythonForce
from lienumba.mechanics.elements.joints import coordinate_kinds
from lienumba.scenario.base.paths import INPUTS
from lienumba.scenario.base.problems import Report
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.drivers import check_driven_body, check_start, numbers_at
from lienumba.scenario.checks.joints import Tables, check_seen, check_two_bodies, find_coordinate
from lienumba.scenario.checks.times import check_samples
from lienumba.store.layout import is_taken


def check_force(place: str, force: Keys, bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one force against the names of all bodies, and all joints by name."""
    name = force.get("type")
    if not isinstance(name, str) or name not in FORCES:
        return
    kind = FORCES[name]
    if issubclass(kind, BetweenPoints):
        check_two_bodies(place, force.get("bodies"), bodies, report)
    elif issubclass(kind, OnBody):
        check_driven_body(place, force.get("body"), bodies, report)
    elif issubclass(kind, PythonForce):
        check_seen(place, force, bodies, joints, report)
    checked = report.element(place, kind, force)
    if checked is None:
        return
    if isinstance(checked, AlongJoint):
        _check_coordinate(place, name, checked, joints, report)
    elif isinstance(checked, PythonForce):
        _check_own(place, checked, report)
    for key, number in checked.numbers().items():
        value = getattr(checked, key)
        stored = checked.has_potential() and number.in_potential  # its rate does work
        follows = number.rate_with in checked.model_fields_set
        check_start(f"{place}.{key}", value, 2 if stored or follows else 1, report)
        for at, x in numbers_at(f"{place}.{key}", value):
            if number.sign is not None and x is not None:
                _check_sign(at, x, number.sign, report)
    effective = [key for key, number in checked.numbers().items() if number.effective]
    if effective and not checked.model_fields_set.intersection(effective):
        rule = f"has neither {' nor '.join(effective)}, so it does nothing"
        report.warn(place, rule, "give one of them, or remove the force")


def _check_coordinate(place: str, name: str, force: AlongJoint, joints: Tables, report: Report) -> None:
    found = find_coordinate(place, "joint", force.joint, "coordinate", force.coordinate, joints, report, force.kinds)
    if found is None or found[1] in force.kinds:
        return
    wanted, type_of_joint = force.kinds[0], joints[force.joint]["type"]
    a_wanted = f"{'an' if wanted[0] == 'a' else 'a'} {wanted}"
    if wanted in coordinate_kinds(type_of_joint):
        report.add(f"{place}.coordinate", f"a {name} acts on {a_wanted}", f'give "{wanted}"', found[1])
    else:
        rule = f"is a {type_of_joint} joint, which has no {wanted} for a {name} to act on"
        report.add(f"{place}.joint", rule, force.otherwise, force.joint)


def _check_own(place: str, force: PythonForce, report: Report) -> None:
    """A law of the user's own: its samples, its parameters, and the names of its states."""
    if isinstance(force.every, float | int):
        check_samples(f"{place}.every", float(force.every), report)
    if force.states and is_taken(force.name):
        rule = "its states are stored by this name, which the dataset has already"
        report.add(f"{place}.name", rule, "give another name", force.name)
    if force.states and force.name == INPUTS:
        report.add(
            f"{place}.name", "formulas would read its states by the name of the inputs", "give another name", INPUTS
        )
    for name, value in force.parameters.items():
        check_start(f"{place}.parameters.{name}", value, 1, report)


def _check_sign(at: str, x: float | str | None, sign: Sign, report: Report) -> None:
    number, fixed = at_start(timed(x))[0], constant(x) is not None
    if not sign.broken(number):
        return
    if not sign.warns:
        report.add(at, sign.rule if fixed else f"{sign.rule}, and is {number:.6g} at t = 0", sign.remedy, x)
    elif fixed:
        report.warn(at, sign.rule, sign.remedy, x)
