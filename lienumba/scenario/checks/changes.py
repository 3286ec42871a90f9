"""What is wrong with what changes a mechanism: limits, contacts, what events do; one sentence each."""

import ast

from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.events import ENGAGE, LOCK, RELEASE, UNLOCK, Event
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.limits import Limit
from lienumba.mechanics.elements.locks import lockable, whole
from lienumba.scenario.base.problems import Report, check_name, names_of, placed, read
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.integrator import OPPOSITE, Lists
from lienumba.scenario.checks.joints import Tables, check_two_bodies
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.words import listed, printable, show, suggestion

AGAINST = {*OPPOSITE.items(), (RELEASE.name, LOCK.name)}


def check_limit(place: str, table: Keys, joints: Tables, report: Report) -> None:
    """Check one limit with all joints by name."""
    limit = report.element(place, Limit, table)
    if limit is None:
        return
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
    contact = report.element(place, kind, table)
    if contact is not None and contact.name in joints:
        at, rule = f"{place}.name", f"is also the name of model.joints.{contact.name}"
        report.add(at, rule, "give another name", contact.name)


def check_events(lists: Lists, parameters: Parameters, report: Report) -> None:
    """Check what every event does: whether it can ever be done, and whether others contradict it."""
    joints: Tables = {str(joint["name"]): joint for joint in lists["joints"]}
    found = [(place, event) for place, table in placed("events", lists["events"]) if (event := read(Event, table))]
    acting, known = [event for _, event in found], [*parameters.numbers, *parameters.formulas]
    for place, event in found:
        faults = [fault.below(place) for fault in event.faults()]
        report.problems += faults
        if faults:
            continue
        for name in event.parameters or ():
            if name not in known:
                remedy = suggestion(name, known) if known else "write it into [parameters]"
                report.add(f"{place}.parameters.{name}", "is not a parameter", remedy)
        if event.joint is not None:
            _check_joint(place, event, acting, joints, lists, report)
    _check_against(found, parameters, report)
    _check_waiting(acting, lists, report)
    for place, joint in placed("joints", lists["joints"]):
        kind = str(joint.get("type"))
        if joint.get("locked") is True and kind in JOINTS and not lockable(kind):
            report.add(
                f"{place}.locked", f"is of a {kind} joint, which has no coordinate to lock", "leave it out", True
            )


def _check_joint(place: str, event: Event, acting: list[Event], joints: Tables, lists: Lists, report: Report) -> None:
    """An event that locks, unlocks, releases or engages a joint."""
    assert event.joint is not None
    kind = type_of(place, event.joint, joints, report)
    if kind is None:
        return
    if event.action in (LOCK.name, UNLOCK.name):
        _check_coordinate(place, event, kind, report)
    at, name = f"{place}.joint", event.joint
    waits = joints[name].get("active") is False
    others = {x.action for x in acting if x.joint == name}
    if event.action == RELEASE.name and waits and ENGAGE.name not in others:
        rule = "is not active at the start, and no event engages it"
        report.add(at, rule, 'leave the event out, or give another one action = "engage"', name)
    if event.action == ENGAGE.name and not waits and RELEASE.name not in others:
        rule = "is active from the start, and no event releases it"
        report.add(at, rule, f"give model.joints.{name} active = false", name)
    if event.action == UNLOCK.name and joints[name].get("locked") is not True and not _locked(event, acting):
        rule = "is never locked"
        report.add(at, rule, f'give model.joints.{name} locked = true, or another event action = "lock"', name)
    if event.action in (LOCK.name, RELEASE.name):
        _check_driven(at, event, lists["drivers"], report)


def _check_coordinate(place: str, event: Event, kind: str, report: Report) -> None:
    having, name = [x.name for x in lockable(kind)], event.joint
    if not having:
        free = [other for other in JOINTS if lockable(other)]
        rule = f"is a {kind} joint, which has no coordinate to lock"
        report.add(f"{place}.joint", rule, f"joints that have one are {', '.join(free)}", name)
    elif event.coordinate is None:
        return
    elif whole(kind):
        rule = f"{name} is a {kind} joint, which is locked as a whole"
        report.add(f"{place}.coordinate", rule, "leave it out", event.coordinate)
    elif event.coordinate not in having:
        no_coordinate(place, str(name), kind, event.coordinate, having, report)


def _locked(event: Event, acting: list[Event]) -> bool:
    """Whether some event locks what one unlocks."""
    every = {None, event.coordinate}
    return any(
        x.action == LOCK.name and x.joint == event.joint and (event.coordinate is None or x.coordinate in every)
        for x in acting
    )


def _check_driven(at: str, event: Event, drivers: list[Keys], report: Report) -> None:
    """What a driver moves can be neither locked nor let go."""
    for driver in drivers:
        same = event.coordinate in (None, driver.get("coordinate")) or driver.get("coordinate") is None
        if driver.get("joint") == event.joint and (same or event.action == RELEASE.name):
            what = "a lock contradicts that" if event.action == LOCK.name else "which would move its bodies still"
            rule = f"model.drivers.{driver.get('name')} prescribes how it moves, {what}"
            report.add(at, rule, "remove one of the two, or let a force drive it", event.joint)


def _check_against(found: list[tuple[str, Event]], parameters: Parameters, report: Report) -> None:
    """Events that are true at the same times and do opposite things."""
    for place, event in found:
        when = _written(event, parameters)
        for other_place, other in found:
            same = event.joint == other.joint and event.delay == other.delay
            same = same and _meaning(when) == _meaning(_written(other, parameters))
            if not same or (event.action, other.action) not in AGAINST:
                continue
            if event.coordinate in (None, other.coordinate) or other.coordinate is None:
                rule = f"happens whenever {other_place} does, which has action = {show(other.action)} of the same joint"
                report.add(f"{place}.when", rule, "give one of the two another condition", when)


def _written(event: Event, parameters: Parameters) -> str:
    """The condition of an event, as the file has it."""
    formula = parameters.places.get(("events", event.name, "when"))
    return event.when if formula is None else formula.text


class _Lesser(ast.NodeTransformer):
    """Every comparison as "<": a > b is b < a, and with or without equality it becomes true at the same time."""

    def visit_Compare(self, node: ast.Compare) -> ast.Compare:
        if len(node.ops) > 1:
            return node
        left, right = node.left, node.comparators[0]
        if isinstance(node.ops[0], ast.Gt | ast.GtE):
            left, right = right, left
        return ast.Compare(left, [ast.Lt()], [right])


def _meaning(when: str) -> str:
    """A condition whatever its spaces, how its numbers are written, and from which side it compares."""
    return ast.dump(_Lesser().visit(ast.parse(when.strip(), mode="eval")))


def _check_waiting(acting: list[Event], lists: Lists, report: Report) -> None:
    """Joints that are not there at the start."""
    for place, joint in placed("joints", lists["joints"]):
        if joint.get("active") is not False:
            continue
        if not any(x.action == ENGAGE.name and x.joint == joint["name"] for x in acting):
            report.warn(f"{place}.active", "no event engages it", 'give one action = "engage"', False)
        kind = JOINTS.get(str(joint.get("type")))
        freedoms, together = (kind.freedoms(), kind.together or ()) if kind is not None else ((), ())
        for key in (*(y for x in freedoms for y in (x.name, x.rate)), *together, "locked"):
            if key in joint:
                rule, remedy = "is of the start, where the joint is not active", "leave it out"
                report.add(f"{place}.{key}", rule, remedy, joint[key])
        for driver in lists["drivers"]:
            if driver.get("joint") == joint["name"]:
                rule = "is not active at the start, and nothing says what its driver does until then"
                report.add(f"model.drivers.{driver.get('name')}.joint", rule, "drive it by a force", joint["name"])


def type_of(place: str, name: str, joints: Tables, report: Report) -> str | None:
    """The type of a joint by its name; None, and a problem, where there is none."""
    check_name(f"{place}.joint", name, names_of(joints.values()), "a joint", report)
    kind = joints.get(name, {}).get("type")
    return kind if isinstance(kind, str) and kind in JOINTS else None


def no_coordinate(place: str, name: str, kind: str, given: str, having: list[str], report: Report) -> None:
    remedy = suggestion(given, having) if len(having) > 1 else f'give "{having[0]}", or leave it out'
    report.add(f"{place}.coordinate", f"{name} is a {kind} joint, which has no {printable(given)}", remedy, given)
