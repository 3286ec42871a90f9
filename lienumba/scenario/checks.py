"""What the parts of a scenario say about one another: all problems are found, one sentence each."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from lienumba.scenario.messages import show, suggestion, unique_name
from lienumba.scenario.schema import NAME, AxisAngle, Body, Euler, Integrator, Joint, Output, RotationVector
from lienumba.scenario.sweep_checks import check_sweep
from lienumba.scenario.time_checks import check_times

ORTHOGONAL = 1e-6  # how far R R^T of a given rotation matrix may lie from the unit matrix
SYMMETRIC = 1e-9  # how far a given inertia matrix may be from symmetric, relative to its largest element
GROUND = "ground"

S = TypeVar("S", bound=BaseModel)


@dataclass
class Report:
    """What the checks found: problems stop the scenario, warnings do not."""

    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def check(raw: dict[str, Any]) -> Report:
    """Check a scenario's keys against each other; what is wrong in itself is passed over (see `messages`)."""
    report = Report()
    model = raw.get("model")
    model = model if isinstance(model, dict) else {}
    bodies, joints = _tables(model.get("bodies")), _tables(model.get("joints"))
    names = [body["name"] for body in bodies if isinstance(body.get("name"), str)]
    named = len(names) == len(bodies) > 0 and not any(_wrong_name(name) for name in names)
    _check_names("bodies", bodies, report)
    _check_names("joints", joints, report)
    for place, body in _placed("bodies", bodies):
        checked = _read(Body, body)
        if checked is not None:
            _check_inertia(place, checked, report)
            _check_rotation(place, checked, report)
    for place, joint in _placed("joints", joints):
        _check_joined(place, joint.get("bodies"), names if named else None, report)
        checked_joint = _read(Joint, joint)
        if checked_joint is not None:
            _check_length(place, checked_joint, report)
    integrator = _read(Integrator, raw.get("integrator"))
    if integrator is not None:
        check_times(integrator, _read(Output, raw.get("output", {})), report)
    sweep = raw.get("sweep")
    if isinstance(sweep, dict) and named:
        check_sweep(sweep, _numbers_of(model, bodies, joints), report)
    return report


def _tables(items: Any) -> list[dict[str, Any]]:
    return [item if isinstance(item, dict) else {} for item in items] if isinstance(items, list) else []


def _numbers_of(model: dict[str, Any], bodies: list[dict[str, Any]], joints: list[dict[str, Any]]) -> dict[str, Any]:
    """What may vary: the model with the default of gravity and without unknown keys."""
    return {
        "gravity": model.get("gravity", [0.0, 0.0, -9.81]),
        "bodies": [{key: body[key] for key in body if key in Body.model_fields} for body in bodies],
        "joints": [{key: joint[key] for key in joint if key in Joint.model_fields} for joint in joints],
    }


def _placed(kind: str, items: list[dict[str, Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
    for index, item in enumerate(items):
        name = unique_name(items, index)
        yield (f"model.{kind}.{name}" if name else f"model.{kind}[{index}]"), item


def _read(section: type[S], raw: Any) -> S | None:
    try:
        return section.model_validate(raw)
    except ValidationError:
        return None


def _wrong_name(name: str) -> bool:
    return re.fullmatch(NAME, name) is None


def _check_names(kind: str, items: list[dict[str, Any]], report: Report) -> None:
    for index, item in enumerate(items):
        if item.get("name") == GROUND:
            report.problems.append(
                f'model.{kind}[{index}].name = "{GROUND}": is reserved for the fixed world; give another name'
            )
    counts = Counter(item["name"] for item in items if isinstance(item.get("name"), str))
    for name, number in counts.items():
        if number > 1:
            places = [f"model.{kind}[{index}]" for index, item in enumerate(items) if item.get("name") == name]
            report.problems.append(
                f'{places[-1]}.name = "{name}": is also the name of {" and ".join(places[:-1])}; give each its own name'
            )


def _check_joined(place: str, bodies: Any, names: list[str] | None, report: Report) -> None:
    """Check the two bodies of a joint; names None: some bodies have no name by which they could be known."""
    if not isinstance(bodies, list):
        return
    for index, name in enumerate(bodies):
        if names is not None and isinstance(name, str) and name not in (*names, GROUND):
            report.problems.append(
                f'{place}.bodies[{index}] = "{name}": is not a body of the model; {suggestion(name, [*names, GROUND])}'
            )
    if len(bodies) == 2 and bodies[0] == bodies[1]:
        report.problems.append(
            f"{place}.bodies = {show(bodies)}: joins {show(bodies[0])} to itself; name two different bodies"
        )


def _check_length(place: str, joint: Joint, report: Report) -> None:
    if joint.type != "distance" and joint.length is not None:
        report.problems.append(
            f"{place}.length = {joint.length!r}: has no meaning for a {joint.type} joint; "
            'leave it out, or set type = "distance"'
        )


def _check_inertia(place: str, body: Body, report: Report) -> None:
    import numpy as np

    tensor = np.array(tensor_of(body.inertia))
    at = f"{place}.inertia = {show(body.inertia)}"
    skew = np.abs(tensor - tensor.T)
    if skew.max() > SYMMETRIC * np.abs(tensor).max():
        row, column = sorted(int(i) for i in np.unravel_index(int(skew.argmax()), (3, 3)))
        upper, lower = float(tensor[row, column]), float(tensor[column, row])
        report.problems.append(
            f"{at}: is not symmetric, [{row}][{column}] is {upper!r} and [{column}][{row}] is {lower!r}; "
            "make them equal, or give the 6 elements xx yy zz xy xz yz"
        )
        return
    moments = np.linalg.eigvalsh(tensor)
    principal = ", ".join(f"{moment:.6g}" for moment in moments)
    if not moments[0] > 1e-14 * np.abs(moments).max():
        report.problems.append(
            f"{at}: is not positive definite, its principal moments are {principal} and must all be above 0; "
            "check the signs, and the order xx yy zz xy xz yz of 6 elements"
        )
    elif moments[2] > (moments[0] + moments[1]) * (1 + 1e-9):
        report.warnings.append(
            f"{at}: no rigid body has the principal moments {principal}, the largest exceeds the sum of the "
            "other two (triangle inequality); check that they are about the mass centre"
        )


def tensor_of(inertia: list[Any]) -> list[list[Any]]:
    """The 3x3 matrix of an inertia in any of its three forms."""
    if isinstance(inertia[0], list):
        return inertia
    xx, yy, zz, xy, xz, yz = inertia if len(inertia) == 6 else [*inertia, 0.0, 0.0, 0.0]
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def _check_rotation(place: str, body: Body, report: Report) -> None:
    rotation = body.rotation
    at = f"{place}.rotation"
    if isinstance(rotation, AxisAngle):
        if not 1e-100 < _length(rotation.axis) < 1e100:
            report.problems.append(
                f"{at}.axis = {show(rotation.axis)}: has no direction; give 3 numbers that are not all 0"
            )
        _check_angles(f"{at}.angle", [rotation.angle], report)
    elif isinstance(rotation, Euler):
        _check_angles(f"{at}.angles", rotation.angles, report)
    elif isinstance(rotation, RotationVector):
        _check_angles(f"{at}.rotation_vector", rotation.rotation_vector, report)
    elif isinstance(rotation, list) and isinstance(rotation[0], list):
        _check_matrix(at, rotation, report)
    elif isinstance(rotation, list):
        _check_quaternion(at, rotation, report)


def _length(values: list[Any]) -> float:
    scale = max(abs(value) for value in values)
    return float(scale * sum((value / scale) ** 2 for value in values) ** 0.5) if scale else 0.0


def _check_angles(at: str, angles: list[float], report: Report) -> None:
    if any(abs(angle) > 2 * pi * (1 + 1e-12) for angle in angles):
        value = angles[0] if len(angles) == 1 else angles
        report.warnings.append(f"{at} = {show(value)}: more than a full turn; angles are in rad, not degrees")


def _check_quaternion(at: str, quaternion: list[Any], report: Report) -> None:
    length = _length(quaternion)
    if not 1e-100 < length < 1e100:
        report.problems.append(
            f"{at} = {show(quaternion)}: is a quaternion of length {length:g}; give [w, x, y, z] of "
            "length 1, such as [1, 0, 0, 0] for no rotation"
        )
    elif abs(length - 1.0) > ORTHOGONAL:
        report.warnings.append(f"{at} = {show(quaternion)}: has length {length:.6g}, is scaled to length 1")


def _check_matrix(at: str, rows: list[list[float]], report: Report) -> None:
    import numpy as np

    matrix = np.array(rows)
    error = float(np.abs(matrix @ matrix.T - np.eye(3)).max())
    if error > ORTHOGONAL:
        report.problems.append(
            f"{at} = {show(rows)}: is not orthogonal, R R^T differs from the unit matrix by {error:.2g} "
            f"and may by {ORTHOGONAL:g}; give more digits, a quaternion, {{axis, angle}} or {{euler, angles}}"
        )
    elif np.linalg.det(matrix) < 0:
        report.problems.append(
            f"{at} = {show(rows)}: is a reflection (determinant -1), not a rotation; "
            "make its determinant +1, for instance by changing the sign of one axis"
        )
