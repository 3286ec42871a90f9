"""What is wrong with a joint: the names it refers to, where it is placed, its directions, one sentence each."""

from collections.abc import Mapping, Sequence
from typing import Any

from lienumba.errors import missing
from lienumba.mechanics.elements.joints import JOINTS, Freedom, coordinate_kinds
from lienumba.mechanics.elements.joints.couplings import Coupling
from lienumba.scenario.base.problems import GROUND, Report, check_name
from lienumba.scenario.base.toml import Keys
from lienumba.words import listed, plural, show, suggestion

Tables = dict[str, dict[str, Any]]


def check_joint(place: str, joint: dict[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one joint against the names of all bodies, and all joints by name."""
    kind = joint.get("type")
    if kind == "python":
        others = {name: table for name, table in joints.items() if coordinate_kinds(table.get("type"))}
        check_seen(place, joint, bodies, others, report)
    elif "bodies" in joint:
        check_two_bodies(place, joint["bodies"], bodies, report)
    checked = report.element(place, JOINTS[kind], joint) if isinstance(kind, str) and kind in JOINTS else None
    if isinstance(checked, Coupling):
        _check_coupling(place, checked, joints, report)


def coordinates_of(joints: list[Keys]) -> dict[str, tuple[str, Freedom]]:
    """Those of the mechanism, by their names among all: the joint, and what the coordinate is."""
    found: dict[str, tuple[str, Freedom]] = {}
    for joint in joints:
        kind, name = JOINTS.get(str(joint.get("type"))), str(joint.get("name"))
        found |= {label: (name, x) for label, x in (kind.labelled(name) if kind is not None else {}).items()}
    return found


def check_coordinates(q: Mapping[str, Any], qd: Mapping[str, Any], joints: list[Keys], report: Report) -> None:
    """Check what is given for coordinates at the start: each by its name once, or all of a joint in a list."""
    known = coordinates_of(joints)
    having: dict[str, list[str]] = {}
    for label, (joint, _) in known.items():
        having.setdefault(joint, []).append(label)
    for key, given in (("q", q), ("qd", qd)):
        for name, x in given.items():
            own, at = having.get(name, []), f"start.{key}.{show(name) if '.' in name else name}"
            if isinstance(x, list) and len(own) != len(x) and own:
                what = plural(len(own), "coordinate", "coordinates")
                report.add(at, f"has {plural(len(x), 'entry', 'entries')}, but the joint has {what}", _each(own), x)
            elif isinstance(x, list) and name in known and not own:
                report.add(at, "is one coordinate", "give a number", x)
            elif not isinstance(x, list) and len(own) > 1:
                report.add(at, f"the joint has {len(own)} coordinates", _each(own), x)
            elif name not in known and not own:
                report.add(
                    at, "is not a coordinate of the mechanism", suggestion(name, list(dict.fromkeys([*known, *having])))
                )
            twice = [label for label in own if label != name and label in given]
            if twice:
                report.add(at, f"gives {show(twice[0])}, too, which stands beside it", "leave one of the two out")


def _each(labels: list[str]) -> str:
    if len(labels) == 1:
        return "give a number"
    return f"give a list of {len(labels)} numbers, or one for each of {listed(labels)}"


def check_two_bodies(place: str, ends: Any, bodies: list[str], report: Report) -> None:
    """Check that two different bodies, or one and the ground, are named."""
    if not isinstance(ends, list):
        return
    for index, name in enumerate(ends):
        check_name(f"{place}.bodies[{index}]", name, [*bodies, GROUND], "a body", report)
    if len(ends) == 2 and isinstance(ends[0], str) and ends[0] == ends[1]:
        report.add(f"{place}.bodies", f"joins {show(ends[0])} to itself", "name two different bodies", ends)


def check_seen(place: str, law: Mapping[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """Check what a law of the user's own is given."""
    for key, known, what in (("bodies", [*bodies, GROUND], "a body"), ("joints", list(joints), "a joint")):
        named = law.get(key)
        for i, name in enumerate(named if isinstance(named, list) else []):
            check_name(f"{place}.{key}[{i}]", name, known, what, report)
    if not law.get("bodies") and not law.get("joints"):
        report.add(place, "sees nothing", "give bodies or joints, as the function takes them")


def _check_coupling(place: str, joint: Coupling, joints: Tables, report: Report) -> None:
    known = []
    for i, name in enumerate(joint.joints):
        kind = None if joint.coordinates is None else joint.coordinates[i]
        known.append(find_coordinate(place, f"joints[{i}]", name, f"coordinates[{i}]", kind, joints, report))
    if None not in known and known[0] == known[1]:
        report.add(f"{place}.joints", "couples a coordinate to itself", "name two different coordinates", joint.joints)


def find_coordinate(
    place: str,
    key: str,
    name: str,
    kind_key: str,
    kind: str | None,
    joints: Tables,
    report: Report,
    among: Sequence[str] = (),
) -> tuple[str, str] | None:
    """The joint's name and the kind of its coordinate; None, and a problem, if there is none such. among: the kinds
    that suit, if not all do."""
    at = f"{place}.{key}"
    if name not in joints:
        having = [joint for joint, table in joints.items() if coordinate_kinds(table.get("type"))]
        report.add(at, "is not a joint of the model", suggestion(name, having), name)
        return None
    type_of_joint = joints[name].get("type")
    if not isinstance(type_of_joint, str) or type_of_joint not in JOINTS:
        return None
    kinds = coordinate_kinds(type_of_joint)
    if not kinds:
        types = ", ".join(kind for kind, own in JOINTS.items() if own.coordinate_kinds)
        rule = f"is a {type_of_joint} joint, which has no coordinate"
        report.add(at, rule, f"joints with an angle or a displacement are {types}", name)
        return None
    its = f"{name} is a {type_of_joint} joint, which has"
    if kind is None and len(suiting := [x for x in kinds if x in among]) == 1:
        return name, suiting[0]
    if kind is None and len(kinds) > 1:
        names = " or ".join(f'"{own}"' for own in kinds)
        report.problems.append(missing(f"{place}.{kind_key}", f"give {names}", f"{its} {len(kinds)}"))
        return None
    if kind is not None and kind not in kinds:
        report.add(f"{place}.{kind_key}", f"{its} no {kind}", f'give "{kinds[0]}"', kind)
        return None
    return name, kind or kinds[0]
