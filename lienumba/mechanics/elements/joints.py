"""Joints as residuals. A joint is one function that vanishes where the joint holds; nothing else is written down.

A residual takes the joint and the motions of its two bodies and returns its rows: lengths in metres, or sines of
angles where the rows concern directions. Velocity and acceleration equations are derived from it
(`lienumba.mechanics.mechanism.kinematics`).
Frames: x, y, z of each side, z the axis; d is the vector from the first body's point to the second's.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Motion, View
from lienumba.mechanics.mechanism.model import Coordinate, Joint, Model
from lienumba.numerics.jets import lift
from lienumba.numerics.operations import atan2
from lienumba.numerics.vector_math import round_to_integer

X, Y, Z = range(3)

Rows = tuple[Any, ...]


@dataclass(frozen=True)
class JointType:
    """rows: one letter each, "m" for a length, "r" for an angle; coordinates: of "angle", "displacement";
    axes: how many of its bodies have one; points: whether it has any; looser: the type without the rows that fix what
    only the start decides."""

    rows: str
    residual: Callable[[Joint, Motion, Motion], Rows]
    coordinates: tuple[str, ...] = ()
    axes: int = 2
    points: bool = True
    looser: str | None = None

    @property
    def parallel(self) -> bool:
        """Whether the axes of both bodies stay parallel: all types of two axes but those of crossed ones."""
        return self.axes == 2 and self.rows.count("r") >= 2


def separation(joint: Joint, a: Motion, b: Motion) -> Any:
    """The vector from the point on the second body to the point on the first, global frame (-d)."""
    assert joint.points is not None
    p, q = joint.points
    return so3.subtract(a.point(p), b.point(q))


def direction(joint: Joint, side: int, body: Motion, axis: int) -> Any:
    """x, y or z of the joint's frame on one side, global frame."""
    assert joint.frames is not None
    return so3.rotate(body.R, joint.frames[side][axis])


def _projected(joint: Joint, a: Motion, v: Any, *axes: int) -> Rows:
    """Components of a global vector along axes of the first side."""
    return tuple(so3.dot(direction(joint, 0, a, axis), v) for axis in axes)


def _across(joint: Joint, a: Motion, b: Motion) -> Rows:
    """The second point lies on the first axis."""
    return _projected(joint, a, so3.scale(-1.0, separation(joint, a, b)), X, Y)


def _along(joint: Joint, a: Motion, b: Motion) -> Any:
    """z.d: the displacement."""
    return _projected(joint, a, so3.scale(-1.0, separation(joint, a, b)), Z)[0]


def _parallel(joint: Joint, a: Motion, b: Motion) -> Rows:
    """The axes are parallel."""
    return _projected(joint, a, direction(joint, 1, b, Z), X, Y)


def _perpendicular(joint: Joint, a: Motion, b: Motion) -> Rows:
    return _projected(joint, a, direction(joint, 1, b, Z), Z)


def _aligned(joint: Joint, a: Motion, b: Motion) -> Rows:
    """The angle is zero."""
    return _projected(joint, a, direction(joint, 1, b, X), Y)


def distance(joint: Joint, a: Motion, b: Motion) -> Rows:
    """The two points keep their distance L: (d.d/L - L)/2, which is |d| - L to first order."""
    d = separation(joint, a, b)
    return (0.5 * (so3.dot(d, d) / joint.length - joint.length),)


JOINT_TYPES: dict[str, JointType] = {
    "spherical": JointType("mmm", separation, axes=0),
    "revolute": JointType("mmmrr", lambda *j: separation(*j) + _parallel(*j), ("angle",)),
    "universal": JointType("mmmr", lambda *j: separation(*j) + _perpendicular(*j)),
    "cylindrical": JointType("mmrr", lambda *j: _across(*j) + _parallel(*j), ("angle", "displacement")),
    "prismatic": JointType(
        "mmrrr", lambda *j: _across(*j) + _parallel(*j) + _aligned(*j), ("displacement",), looser="cylindrical"
    ),
    "fixed": JointType("mmmrrr", lambda *j: separation(*j) + _parallel(*j) + _aligned(*j), looser="spherical"),
    "planar": JointType("mrr", lambda *j: (_along(*j), *_parallel(*j))),
    "point_on_line": JointType("mm", _across, ("displacement",), axes=1),
    "point_in_plane": JointType("m", lambda *j: (_along(*j),), axes=1),
    "distance": JointType("m", distance, axes=0),
    "parallel_axes": JointType("rr", _parallel, points=False),
    "perpendicular_axes": JointType("r", _perpendicular, points=False),
}

# Joints whose last row ties coordinates: second = ratio * first + offset. The screw's are its own two.
COUPLED = {"gear", "coupler", "screw"}
COORDINATES = {name: kind.coordinates for name, kind in JOINT_TYPES.items()} | {"screw": ("angle", "displacement")}


def angle(joint: Joint, view: View, near: Any) -> Any:
    """The rotation (rad) of the second body relative to the first about the axis, counted over turns near a value."""
    a, b = (view[i] for i in joint.bodies)
    x = direction(joint, 1, b, X)
    cosine, sine = _projected(joint, a, x, X, Y)
    principal = atan2(sine, cosine)
    turns = round_to_integer((near - lift(principal).a) * (0.5 / pi))
    return principal + (2.0 * pi) * turns


def coordinate(model: Model, which: Coordinate, view: View) -> Any:
    """The angle (rad) or displacement (m) of a joint."""
    joint = model.joints[which.joint]
    if which.kind == "angle":
        return angle(joint, view, view.angles.get(which.joint, 0.0))
    a, b = (view[i] for i in joint.bodies)
    return _along(joint, a, b)


def row_kinds(model: Model, joint: Joint) -> str:
    """One letter for each row: "m" for a length, "r" for an angle."""
    if joint.type == "screw":
        return JOINT_TYPES["cylindrical"].rows + "m"
    if joint.type in COUPLED:
        assert joint.coordinates is not None
        return "r" if joint.coordinates[1].kind == "angle" else "m"
    return JOINT_TYPES[joint.type].rows


def residual(model: Model, index: int, view: View) -> Rows:
    """The rows of joint number `index`."""
    joint = model.joints[index]
    rows: Rows = ()
    if joint.type == "screw":
        rows = JOINT_TYPES["cylindrical"].residual(joint, *(view[i] for i in joint.bodies))
    elif joint.type not in COUPLED:
        return JOINT_TYPES[joint.type].residual(joint, *(view[i] for i in joint.bodies))
    first, second, ratio = _coupling(joint, index)
    tie = coordinate(model, second, view) - ratio * coordinate(model, first, view) - joint.offset
    return (*rows, tie)


def _coupling(joint: Joint, index: int) -> tuple[Coordinate, Coordinate, Any]:
    if joint.type == "screw":
        assert joint.pitch is not None
        return Coordinate(index, "angle"), Coordinate(index, "displacement"), joint.pitch * (0.5 / pi)
    assert joint.coordinates is not None
    return *joint.coordinates, joint.ratio


def counted_angles(model: Model) -> set[int]:
    """The joints whose angle a screw, a gear or a coupler counts."""
    counted = set()
    for index, joint in enumerate(model.joints):
        if joint.type in COUPLED:
            first, second, _ = _coupling(joint, index)
            counted |= {c.joint for c in (first, second) if c.kind == "angle"}
    return counted
