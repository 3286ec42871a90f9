"""What is wrong with a quantity or an input: the names it refers to, and what its own name hides; one sentence each."""

import re

from lienumba.keys.types import NAME, NAME_RULE
from lienumba.mechanics.elements.events import LOCK
from lienumba.mechanics.elements.inputs import INPUTS_BY_FORM, input_form
from lienumba.mechanics.elements.inputs.forms import RecordedInput, TrackingInput
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.noise import NoiseType, Tabulated
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.elements.quantities.base import Refers
from lienumba.mechanics.elements.quantities.built_in import Momentum
from lienumba.mechanics.elements.quantities.switched import LockQuantity
from lienumba.mechanics.mechanism.tables import ERROR
from lienumba.mechanics.tolerances import SAME_TIME_RTOL
from lienumba.scenario.base.paths import INPUTS
from lienumba.scenario.base.problems import Report, check_name, names_of
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.bodies import check_rotation
from lienumba.scenario.checks.drivers import check_start
from lienumba.scenario.checks.integrator import Lists
from lienumba.scenario.checks.joints import Tables, find_coordinate
from lienumba.scenario.checks.output import check_variable, with_states
from lienumba.scenario.checks.tables import check_range
from lienumba.scenario.checks.times import check_samples
from lienumba.scenario.schema.tables import points_problem
from lienumba.words import listed

SINGULAR = {"bodies": "body", "joints": "joint", "drivers": "driver", "contacts": "contact", "limits": "limit"}
TIMED = ("value", "limit", "limits", "kp", "kd", "target", "rate", "feedforward")  # keys of inputs


def check_quantity(place: str, quantity: Keys, lists: Lists, report: Report) -> None:
    """Check one quantity against the names of everything."""
    _check_name(place, quantity["name"], lists, report)
    kind = QUANTITIES.get(str(quantity.get("type")))
    if kind is None:
        return
    for key, refers in kind.references().items():
        _check_references(f"{place}.{key}", quantity.get(key), names_of(lists[refers.to]), refers, report)
    checked = report.element(place, kind, quantity)
    if checked is None:
        return
    if isinstance(checked, LockQuantity):
        _check_lock(place, checked, lists, report)
    if kind.reads_coordinates and "joint" in quantity:
        _check_joint(place, str(quantity["joint"]), lists, report)
    for key in kind.rotations:
        check_rotation(f"{place}.{key}", getattr(checked, key), report)
    if isinstance(value := getattr(checked, "value", None), str):
        check_start(f"{place}.value", value, 1, report)
    if isinstance(checked, Momentum):
        _check_mass(place, checked, lists, report)


def check_noise(place: str, noise: Keys, lists: Lists, report: Report) -> None:
    """Check one noise: its name, and what its keys say together."""
    _check_name(place, noise["name"], lists, report)
    checked = report.element(place, NOISES.get(str(noise.get("type"))), noise)
    if not isinstance(checked, NoiseType) or checked.interval is None or report.times is None:
        return
    if check_samples(f"{place}.every", checked.interval, report) and isinstance(checked, Tabulated) and checked.samples:
        end, last = float(report.times[-1]), checked.interval * (checked.samples - 1)
        if end > last * (1.0 + SAME_TIME_RTOL):
            rule = f"ends at {last:g} s, and the run at {end:g} s"
            report.add(f"{place}.table", rule, "give longer courses, or end the run earlier")


def _check_name(place: str, name: object, lists: Lists, report: Report) -> None:
    check_variable(place, name, report)
    if name in with_states(lists):
        report.add(
            f"{place}.name",
            f"is also the name of model.forces.{name}, whose states are stored",
            "give another name",
            name,
        )


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


def _check_joint(place: str, name: str, lists: Lists, report: Report) -> None:
    """A joint needs a coordinate to be looked at."""
    joint = next((j for j in lists["joints"] if j["name"] == name), None)
    if joint is not None and not _has_coordinates(joint):
        having = names_of(filter(_has_coordinates, lists["joints"]))
        remedy = (
            f"joints that have one are {listed(having)}" if having else "look at a point or a rotation_error instead"
        )
        kind = joint.get("type")
        report.add(f"{place}.joint", f"a {kind} joint has no coordinate", remedy, name)


def _check_lock(place: str, quantity: LockQuantity, lists: Lists, report: Report) -> None:
    """A joint must be locked at some time."""
    joint = next((j for j in lists["joints"] if j["name"] == quantity.joint), None)
    locked = any(x.get("action") == LOCK.name and x.get("joint") == quantity.joint for x in lists["events"])
    if joint is not None and not locked and joint.get("locked") is not True:
        remedy = f'give model.joints.{quantity.joint} locked = true, or an event action = "lock"'
        report.add(f"{place}.joint", "is never locked", remedy, quantity.joint)


def _has_coordinates(joint: Keys) -> bool:
    kind = JOINTS.get(str(joint.get("type")))
    return kind is not None and bool(kind.freedoms())


def _check_mass(place: str, momentum: Momentum, lists: Lists, report: Report) -> None:
    """Bodies have a mass centre if one of them has a mass."""
    counted = [body for body in lists["bodies"] if momentum.bodies is None or body["name"] in momentum.bodies]
    if momentum.about == "mass_centre" and counted and not any(body.get("mass") for body in counted):
        report.add(f"{place}.about", "these bodies have no mass, and so no mass centre", "give a point", momentum.about)


def check_inputs(inputs: Keys, joints: Tables, report: Report) -> None:
    """Check every input, with all joints by name."""
    for name, value in inputs.items():
        place = f"{INPUTS}.{name}"
        if not re.fullmatch(NAME, name):
            report.add(place, "is no valid name", f"give {NAME_RULE}")
        elif isinstance(value, dict):
            _check_table(place, value, joints, report)
        elif isinstance(value, str):
            check_start(place, value, 1, report)


def _check_table(place: str, table: Keys, joints: Tables, report: Report) -> None:
    checked = report.element(place, INPUTS_BY_FORM.get(input_form(table) or ""), table)
    if checked is None:
        return
    for key in TIMED:
        if (value := getattr(checked, key, None)) is not None:
            follows = key == "target" and "kd" in table and "rate" not in table
            check_start(f"{place}.{key}", value, 2 if follows else 1, report)
    if isinstance(checked, TrackingInput):
        find_coordinate(place, "joint", checked.joint, "coordinate", checked.coordinate, joints, report)
    if isinstance(checked, RecordedInput):
        _check_recording(place, checked, table, report)


def _check_recording(place: str, recording: RecordedInput, table: Keys, report: Report) -> None:
    wrong = points_problem(table)
    if wrong is not None:
        report.problems.append(wrong.below(place))
        return
    if report.times is None:
        return
    recorded, delay = recording.table(), recording.delay
    first = 0.0 - delay if recording.outside == ERROR else max(-delay, 0.0)  # what a delay leaves in front is meant so
    check_range(recorded, first, float(report.times[-1]) - delay, place, "the run reads it", report)
