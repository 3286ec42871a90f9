"""What is wrong with limits and contacts, one sentence each."""

from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.limits import Limit
from lienumba.mechanics.elements.locks import lockable, whole
from lienumba.scenario.base.problems import Report, read
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.changes.named import no_coordinate, type_of
from lienumba.scenario.checks.joints import Tables, check_direction, check_two_bodies
from lienumba.words import listed


def check_limit(place: str, table: Keys, joints: Tables, report: Report) -> None:
    """Check one limit with all joints by name."""
    limit = read(Limit, table)
    if limit is None:
        return
    for fault in limit.faults():
        report.problems.append(fault.below(place))
    kind = type_of(place, limit.joint, joints, report)
    if kind is None:
        return
    having = [] if whole(kind) else [x.name for x in lockable(kind)]
    if not having:
        rule = f"is a {kind} joint, which has no coordinate to limit"
        other = [name for name, table in joints.items() if _limited(table)]
        report.add(f"{place}.joint", rule, f"joints that have one are {listed(other)}" if other else "", limit.joint)
    elif limit.coordinate is None and len(having) > 1:
        names = " or ".join(f'"{name}"' for name in having)
        report.miss(f"{place}.coordinate", f"give {names}", f"{limit.joint} is a {kind} joint, which has {len(having)}")
    elif limit.coordinate is not None and limit.coordinate not in having:
        no_coordinate(place, limit.joint, kind, limit.coordinate, having, report)


def _limited(joint: Keys) -> bool:
    kind = str(joint.get("type"))
    return kind in JOINTS and not whole(kind) and bool(lockable(kind))


def check_contact(place: str, table: Keys, bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one contact against the names of all bodies and joints."""
    kind = CONTACTS.get(str(table.get("type")))
    if kind is None:
        return
    check_two_bodies(place, table.get("bodies"), bodies, report)
    contact = read(kind, table)
    if contact is None:
        return
    if contact.name in joints:
        at, rule = f"{place}.name", f"is also the name of model.joints.{contact.name}"
        report.add(at, rule, "give another name", contact.name)
    for key in ("normal", "axis"):
        if key in kind.model_fields:
            check_direction(f"{place}.{key}", getattr(contact, key), report)
    for fault in contact.faults():
        report.problems.append(fault.below(place))
