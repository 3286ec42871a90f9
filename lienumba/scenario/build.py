"""From a resolved scenario and its samples to the model and the initial state.

A number is a float, or an array (runs,) where the sweep varies it; every conversion here works on both.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lienumba.groups import so3
from lienumba.mechanics.model import GROUND, Body, Joint, Matrix3, Model, Pose, Vec3
from lienumba.operations import cos, sin, sqrt
from lienumba.scenario import paths
from lienumba.scenario.checks import tensor_of
from lienumba.scenario.resolve import Scenario

if TYPE_CHECKING:
    import numpy as np

Number = Any


def build(scenario: Scenario, samples: Mapping[str, "np.ndarray"]) -> tuple[Model, tuple[Pose, ...]]:
    """The model and the initial state of each body; `samples` maps canonical paths to arrays (runs,)."""
    import numpy as np

    with np.errstate(divide="ignore", invalid="ignore"):  # `unphysical` finds the NaN of such runs
        return _build(scenario, samples)


def _build(scenario: Scenario, samples: Mapping[str, "np.ndarray"]) -> tuple[Model, tuple[Pose, ...]]:
    data = scenario.data.model.model_dump()
    for path, values in samples.items():
        paths.put(data, paths.parse(path), values)
    index = {body["name"]: number for number, body in enumerate(data["bodies"])} | {"ground": GROUND}
    bodies = tuple(Body(body["name"], body["mass"], inertia_of(body["inertia"])) for body in data["bodies"])
    joints = tuple(
        Joint(
            name=joint["name"],
            type=joint["type"],
            bodies=(index[joint["bodies"][0]], index[joint["bodies"][1]]),
            points=(_vec3(joint["points"][0]), _vec3(joint["points"][1])),
            length=joint["length"],
        )
        for joint in data["joints"]
    )
    poses = tuple(
        Pose(
            position=_optional(body["position"]),
            rotation=None if body["rotation"] is None else rotation_of(body["rotation"]),
            velocity=_optional(body["velocity"]),
            angular_velocity=_optional(body["angular_velocity"]),
        )
        for body in data["bodies"]
    )
    return Model(_vec3(data["gravity"]), bodies, joints), poses


def unphysical(model: Model, poses: Sequence[Pose], runs: int) -> "np.ndarray":
    """Which of the runs drew a mass, inertia, rod length or rotation that no body has: booleans (runs,).

    The nominal values are checked with the scenario; a sample may still lie outside, in the tail of a normal
    distribution.
    """
    import numpy as np

    bad = np.zeros(runs, dtype=bool)
    for body in model.bodies:
        xx, yy, zz, xy, xz, yz = body.inertia
        minors = (
            xx,
            xx * yy - xy * xy,
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz),
        )
        for number in (body.mass, *minors):
            bad |= ~(np.asarray(number) > 0.0)
    for joint in model.joints:
        if joint.length is not None:
            bad |= ~(np.asarray(joint.length) > 0.0)
    for pose in poses:
        for number in pose.rotation or ():
            bad |= ~np.isfinite(number)  # a quaternion or an axis of length 0
    return bad


def inertia_of(inertia: list[Any]) -> tuple[Number, ...]:
    """The elements xx yy zz xy xz yz of an inertia in any of its three forms."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = tensor_of(inertia)
    return xx, yy, zz, _mean(xy, yx), _mean(xz, zx), _mean(yz, zy)


def _mean(a: Number, b: Number) -> Number:
    """Of two nearly equal numbers; of one and the same, that number itself."""
    return a if a is b else 0.5 * (a + b)


def rotation_of(rotation: Any) -> Matrix3:
    """The matrix, row major, of a rotation in any of its five forms."""
    if isinstance(rotation, list):
        if isinstance(rotation[0], list):
            return _orthonormal(rotation)
        w, x, y, z = rotation
        return so3.from_quaternion((w, x, y, z))
    if "axis" in rotation:
        x, y, z = rotation["axis"]
        length = sqrt(x * x + y * y + z * z)
        return so3.exp(so3.scale(rotation["angle"] / length, (x, y, z)))
    if "rotation_vector" in rotation:
        return so3.exp(_vec3(rotation["rotation_vector"]))
    matrix = so3.IDENTITY
    for axis, angle in zip(rotation["euler"], rotation["angles"], strict=True):
        matrix = so3.multiply(matrix, elementary("XYZ".index(axis), angle))
    return matrix


def elementary(axis: int, angle: Number) -> Matrix3:
    """The rotation about a coordinate axis (0, 1, 2) by an angle in rad."""
    c, s = cos(angle), sin(angle)
    if axis == 0:
        return (1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
    if axis == 1:
        return (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
    return (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def _orthonormal(rows: list[list[float]]) -> Matrix3:
    """The rotation nearest to a matrix that is orthogonal within 1e-6 (two steps R <- R (3 I - R^T R)/2).

    Unlike a singular value decomposition, exact zeros that the structure of R implies stay exact.
    """
    matrix = tuple(element for row in rows for element in row)
    for _ in range(2):
        gram = so3.multiply(so3.transpose(matrix), matrix)
        correction = tuple(1.5 * one - 0.5 * element for one, element in zip(so3.IDENTITY, gram, strict=True))
        matrix = so3.multiply(matrix, correction)
    return matrix


def _vec3(values: list[Any]) -> Vec3:
    return values[0], values[1], values[2]


def _optional(values: list[Any] | None) -> Vec3 | None:
    return None if values is None else _vec3(values)
