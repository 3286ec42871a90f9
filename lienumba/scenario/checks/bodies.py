"""What is wrong with a body's inertia, rotation, base or shapes, one sentence each."""

from math import pi
from typing import Any

import numpy as np

from lienumba.integrators.methods.charts import JOINT
from lienumba.keys.conversions import norm, tensor_of, undirected
from lienumba.keys.types import AxisAngle, Euler, Inertia, RotationVector
from lienumba.scenario.base.problems import GROUND, Report
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.scenario import Body
from lienumba.scenario.schema.shapes import Shape
from lienumba.words import suggestion

ORTHOGONAL = 1e-6  # how far R R^T of a given rotation matrix may lie from the unit matrix
SMALLEST = 1e-80  # of the largest element of an inertia, whose cube must be a number
SYMMETRIC = 1e-9  # how far a given inertia matrix may be from symmetric, relative to its largest element


def check_body(place: str, body: Body, coordinates: str | None, report: Report) -> None:
    """Check one body by itself; coordinates: of the integrator, if they are known."""
    if body.mass == 0.0:
        _check_massless(place, body, coordinates, report)
    elif body.inertia is None:
        report.miss(f"{place}.inertia", f"give {Body.model_fields['inertia'].description}")
    else:
        _check_inertia(place, body.inertia, report)
    check_rotation(f"{place}.rotation", body.rotation, report)
    if body.guess is not None:
        check_rotation(f"{place}.guess.rotation", body.guess.rotation, report)
        for key in body.guess.model_fields_set & body.model_fields_set:
            rule = f"the body has a {key} already, which is held"
            report.add(f"{place}.guess.{key}", rule, "leave one of the two out")


def check_bases(bodies: list[Keys], names: list[str], report: Report) -> None:
    """Check what bodies are relative to; `names` of all bodies."""
    bases = {str(body["name"]): body.get("relative_to", GROUND) for body in bodies}
    circles: set[str] = set()
    for name, base in bases.items():
        at, value = f"model.bodies.{name}.relative_to", base
        if not isinstance(base, str):
            continue
        if base not in (*names, GROUND):
            others = [other for other in names if other != name]
            report.add(at, "is not a body of the model", suggestion(base, [*others, GROUND]), value)
            continue
        seen = [name]
        while isinstance(base, str) and base not in (GROUND, *seen) and base in bases:
            seen.append(base)
            base = bases[base]
        if base == name and name not in circles:
            circles.update(seen)
            rule = f"goes around in a circle, {' -> '.join([*seen, name])}"
            report.add(at, rule, "give one of these bodies relative to the ground", value)


def _check_massless(place: str, body: Body, coordinates: str | None, report: Report) -> None:
    if coordinates not in (None, JOINT):
        rule = f'must be above 0 with integrator.coordinates = "{coordinates}"'
        report.add(f"{place}.mass", rule, f'give the mass in kg, or coordinates = "{JOINT}"', body.mass)
    elif body.inertia is not None and np.abs(tensor_of(body.inertia)).max() > 0.0:
        report.add(f"{place}.inertia", "belongs to no mass, which is 0", "leave it out, or give a mass", body.inertia)


def _check_inertia(place: str, value: Inertia, report: Report) -> None:
    tensor, at = np.array(tensor_of(value)), f"{place}.inertia"
    skew = np.abs(tensor - tensor.T)
    if skew.max() > SYMMETRIC * np.abs(tensor).max():
        row, column = sorted(int(i) for i in np.unravel_index(int(skew.argmax()), (3, 3)))
        upper, lower = float(tensor[row, column]), float(tensor[column, row])
        rule = f"is not symmetric, [{row}][{column}] is {upper!r} and [{column}][{row}] is {lower!r}"
        report.add(at, rule, "make them equal, or give the 6 elements xx yy zz xy xz yz", value)
        return
    if np.abs(tensor).max() < SMALLEST:
        report.add(at, f"must be above {SMALLEST:g}", "give it in kg m^2", value)
        return
    moments = np.linalg.eigvalsh(tensor)
    principal = ", ".join(f"{moment:.6g}" for moment in moments)
    if not moments[0] > 1e-14 * np.abs(moments).max():
        rule = f"is not positive definite, its principal moments are {principal} and must all be above 0"
        report.add(at, rule, "check the signs, and the order xx yy zz xy xz yz of 6 elements", value)
    elif moments[2] > (moments[0] + moments[1]) * (1 + 1e-9):
        rule = f"no rigid body has the principal moments {principal}, the largest exceeds the sum of the other two"
        report.warn(at, f"{rule} (triangle inequality)", "check that they are about the mass centre", value)


def check_rotation(at: str, rotation: object, report: Report) -> None:
    """Check a rotation in any of its five forms."""
    if isinstance(rotation, AxisAngle):
        report.problems += undirected(f"{at}.axis", rotation.axis)
        _check_angles(f"{at}.angle", [rotation.angle], report)
    elif isinstance(rotation, Euler):
        _check_angles(f"{at}.angles", rotation.angles, report)
    elif isinstance(rotation, RotationVector):
        _check_angles(f"{at}.rotation_vector", rotation.rotation_vector, report)
    elif isinstance(rotation, list) and isinstance(rotation[0], list):
        _check_matrix(at, rotation, report)
    elif isinstance(rotation, list):
        _check_quaternion(at, rotation, report)


def _check_angles(at: str, angles: list[float], report: Report) -> None:
    if any(abs(angle) > 2 * pi * (1 + 1e-12) for angle in angles):
        value = angles[0] if len(angles) == 1 else angles
        report.warn(at, "more than a full turn", "angles are in rad, not degrees", value)


def _check_quaternion(at: str, quaternion: list[Any], report: Report) -> None:
    length = norm(quaternion)
    if not 1e-100 < length < 1e100:
        remedy = "give [w, x, y, z] of length 1, such as [1, 0, 0, 0] for no rotation"
        report.add(at, f"is a quaternion of length {length:g}", remedy, quaternion)
    elif abs(length - 1.0) > ORTHOGONAL:
        report.warn(at, f"has length {length:.6g}, is scaled to length 1", value=quaternion)


def _check_matrix(at: str, rows: list[list[float]], report: Report) -> None:
    matrix = np.array(rows)
    error = float(np.abs(matrix @ matrix.T - np.eye(3)).max())
    if error > ORTHOGONAL:
        rule = f"is not orthogonal, R R^T differs from the unit matrix by {error:.2g} and may by {ORTHOGONAL:g}"
        report.add(at, rule, "give more digits, a quaternion, {axis, angle} or {euler, angles}", rows)
    elif np.linalg.det(matrix) < 0:
        remedy = "make its determinant +1, for instance by changing the sign of one axis"
        report.add(at, "is a reflection (determinant -1), not a rotation", remedy, rows)


def check_shapes(place: str, shapes: list[Shape] | None, report: Report) -> None:
    """Check the shapes of a body, or of the ground."""
    for n, shape in enumerate(shapes or ()):
        at = f"{place}[{n}]"
        check_rotation(f"{at}.rotation", shape.rotation, report)
        report.problems += [fault.below(at) for fault in shape.faults()]
