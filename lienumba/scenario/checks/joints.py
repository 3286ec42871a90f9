"""What is wrong with a joint: the names it refers to, where it is placed, its directions, one sentence each."""

from typing import Any

from lienumba.mechanics.elements.joints import COORDINATES, JOINT_TYPES
from lienumba.scenario.base.code import PYTHON
from lienumba.scenario.base.problems import GROUND, Report, check_name, norm, read
from lienumba.scenario.schema.joints import JOINTS
from lienumba.words import show, suggestion

PARALLEL = 1e-6  # sine of the angle below which two directions count as parallel

Tables = dict[str, dict[str, Any]]


def check_joint(place: str, joint: dict[str, Any], bodies: list[str], joints: Tables, report: Report) -> None:
    """Check one joint against the names of all bodies, and all joints by name."""
    kind = joint.get("type")
    if "bodies" in joint:
        check_two_bodies(place, joint["bodies"], bodies, report)
    checked: Any = read(JOINTS.get(kind) if isinstance(kind, str) else None, joint)
    if checked is None:
        return
    if kind in ("gear", "coupler"):
        _check_coupling(place, checked, joints, report)
    if kind in ("gear", "coupler", PYTHON):
        return
    _check_points(place, checked, report)
    _check_axes(place, checked, report)
    if getattr(checked, "pitch", None) == 0.0:
        report.problems.append(f"{place}.pitch = 0.0: must not be 0; for a joint that only turns use a revolute joint")


def check_two_bodies(place: str, ends: Any, bodies: list[str], report: Report) -> None:
    """Check that two different bodies, or one and the ground, are named."""
    if not isinstance(ends, list):
        return
    for index, name in enumerate(ends):
        check_name(f"{place}.bodies[{index}]", name, [*bodies, GROUND], "a body", report)
    if len(ends) == 2 and isinstance(ends[0], str) and ends[0] == ends[1]:
        report.problems.append(
            f"{place}.bodies = {show(ends)}: joins {show(ends[0])} to itself; name two different bodies"
        )


def check_direction(at: str, v: list[float], report: Report) -> bool:
    """Whether a vector has a direction; else a problem."""
    if 1e-100 < norm(v) < 1e100:
        return True
    report.problems.append(f"{at} = {show(v)}: has no direction; give 3 numbers that are not all 0")
    return False


def _check_points(place: str, joint: Any, report: Report) -> None:
    at = getattr(joint, "at", None)
    if not JOINT_TYPES.get(joint.type, JOINT_TYPES["cylindrical"]).points:
        return
    if joint.points is not None and at is not None:
        report.problems.append(
            f"{place}.at = {show(at)}: the joint has points already; give either points (in the bodies' own frames) "
            "or at (in the global frame at the start)"
        )
    if joint.points is None and at is None:
        other = "" if joint.type == "distance" else ", or at = [x, y, z] in the global frame at the start"
        report.problems.append(
            f"{place}.points is missing; give two points in m, each with 3 numbers in the frame of its own body{other}"
        )


def _check_axes(place: str, joint: Any, report: Report) -> None:
    if not hasattr(joint, "axes"):
        return
    axes, axis, references = joint.axes, joint.axis, getattr(joint, "references", None)
    if axes is not None and axis is not None:
        report.problems.append(
            f"{place}.axis = {show(axis)}: the joint has axes already; give either axes (in the bodies' own frames) "
            "or axis (in the global frame at the start)"
        )
    if axes is None and axis is None and joint.type != "fixed":
        own, common = "two directions, each with 3 numbers in the frame of its own body", "[x, y, z]"
        if joint.type.startswith("point_"):
            own = "the direction in the frame of the first body, as [[x, y, z]]"
        elif joint.type in ("universal", "perpendicular_axes"):
            common = "[[x, y, z], [x, y, z]]"
        report.problems.append(
            f"{place}.axes is missing; give {own}, or axis = {common} in the global frame at the start"
        )
    pair = axis if isinstance(axis, list) and axis and isinstance(axis[0], list) else None
    directed = [check_direction(f"{place}.axes[{i}]", v, report) for i, v in enumerate(axes or [])]
    if pair is not None:
        both = [check_direction(f"{place}.axis[{i}]", v, report) for i, v in enumerate(pair)]
        if all(both) and sine(*pair) < PARALLEL:
            report.problems.append(
                f"{place}.axis = {show(pair)}: the two directions are parallel and must be perpendicular; "
                "give the direction in each of the two bodies"
            )
    elif axis is not None:
        check_direction(f"{place}.axis", axis, report)
    for i, reference in enumerate(references or []):
        at = f"{place}.references[{i}]"
        if (
            check_direction(at, reference, report)
            and axes is not None
            and directed[i]
            and sine(reference, axes[i]) < PARALLEL
        ):
            report.problems.append(
                f"{at} = {show(reference)}: is parallel to the axis {show(axes[i])}; give a direction across it"
            )


def sine(a: list[float], b: list[float]) -> float:
    """Of the angle between two vectors."""
    p, q = ([x / norm(v) for x in v] for v in (a, b))
    return norm([p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]])


def _check_coupling(place: str, joint: Any, joints: Tables, report: Report) -> None:
    if joint.ratio == 0.0:
        report.problems.append(f"{place}.ratio = 0.0: must not be 0; give second = ratio * first + offset")
    known = []
    for i, name in enumerate(joint.joints):
        kind = None if joint.coordinates is None else joint.coordinates[i]
        known.append(find_coordinate(place, f"joints[{i}]", name, f"coordinates[{i}]", kind, joints, report))
    if None not in known and known[0] == known[1]:
        report.problems.append(
            f"{place}.joints = {show(joint.joints)}: couples a coordinate to itself; name two different coordinates"
        )


def find_coordinate(
    place: str, key: str, name: str, kind_key: str, kind: str | None, joints: Tables, report: Report
) -> tuple[str, str] | None:
    """The joint's name and the kind of its coordinate; None, and a problem, if there is none such."""
    at = f"{place}.{key} = {show(name)}"
    if name not in joints:
        having = [joint for joint, table in joints.items() if COORDINATES.get(str(table.get("type")))]
        report.problems.append(f"{at}: is not a joint of the model; {suggestion(name, having)}")
        return None
    type_of_joint = joints[name].get("type")
    if not isinstance(type_of_joint, str) or type_of_joint not in JOINTS:
        return None
    kinds = COORDINATES.get(type_of_joint, ())
    if not kinds:
        types = ", ".join(kind for kind, own in COORDINATES.items() if own)
        report.problems.append(
            f"{at}: is a {type_of_joint} joint, which has no coordinate; joints with an angle or a displacement are "
            f"{types}"
        )
        return None
    if kind is None and len(kinds) > 1:
        names = " or ".join(f'"{own}"' for own in kinds)
        report.problems.append(
            f"{place}.{kind_key} is missing: {name} is a {type_of_joint} joint, which has {len(kinds)}; give {names}"
        )
        return None
    if kind is not None and kind not in kinds:
        report.problems.append(
            f'{place}.{kind_key} = "{kind}": {name} is a {type_of_joint} joint, which has no {kind}; give "{kinds[0]}"'
        )
        return None
    return name, kind or kinds[0]
