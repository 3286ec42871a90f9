"""What residuals of joints are composed of: points that meet, directions that are parallel, coordinates.

A residual takes the joint and the motions of its two bodies and returns its rows: lengths in metres, or sines of
angles where the rows concern directions. Velocity and acceleration equations are derived from it
(`lienumba.mechanics.mechanism.kinematics`).
Frames: x, y, z of each side, z the axis; d is the vector from the first body's point to the second's.
"""

from math import pi

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Motion, View
from lienumba.mechanics.mechanism.model import Coordinate, Joint, Model, Number, Vec3
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Vector
from lienumba.numerics.operations import atan2
from lienumba.numerics.vector_math import round_to_integer

X, Y, Z = range(3)


def separation(joint: Joint, a: Motion, b: Motion) -> Vec3:
    """The vector from the point on the second body to the point on the first, global frame (-d)."""
    assert joint.points is not None
    p, q = joint.points
    return so3.subtract(a.point(p), b.point(q))


def direction(joint: Joint, side: int, body: Motion, axis: int) -> Vec3:
    """x, y or z of the joint's frame on one side, global frame."""
    assert joint.frames is not None
    return so3.rotate(body.R, joint.frames[side][axis])


def projected(joint: Joint, a: Motion, v: Vec3, *axes: int) -> Vector:
    """Components of a global vector along axes of the first side."""
    return tuple(so3.dot(direction(joint, 0, a, axis), v) for axis in axes)


def across(joint: Joint, a: Motion, b: Motion) -> Vector:
    """The second point lies on the first axis."""
    return projected(joint, a, so3.scale(-1.0, separation(joint, a, b)), X, Y)


def along(joint: Joint, a: Motion, b: Motion) -> Number:
    """z.d: the displacement."""
    displacement: Number = projected(joint, a, so3.scale(-1.0, separation(joint, a, b)), Z)[0]
    return displacement


def parallel(joint: Joint, a: Motion, b: Motion) -> Vector:
    """The axes are parallel."""
    return projected(joint, a, direction(joint, 1, b, Z), X, Y)


def perpendicular(joint: Joint, a: Motion, b: Motion) -> Vector:
    """The axes are perpendicular."""
    return projected(joint, a, direction(joint, 1, b, Z), Z)


def aligned(joint: Joint, a: Motion, b: Motion) -> Vector:
    """The angle is zero."""
    return projected(joint, a, direction(joint, 1, b, X), Y)


def angle(joint: Joint, view: View, near: Number) -> Number:
    """The rotation (rad) of the second body relative to the first about the axis, counted over turns near a value."""
    a, b = (view[i] for i in joint.bodies)
    x = direction(joint, 1, b, X)
    cosine, sine = projected(joint, a, x, X, Y)
    principal = atan2(sine, cosine)
    turns = round_to_integer((near - lift(principal).a) * (0.5 / pi))
    return principal + (2.0 * pi) * turns


def coordinate(model: Model, which: Coordinate, view: View) -> Number:
    """The angle (rad) or displacement (m) of a joint."""
    joint = model.joints[which.joint]
    if which.kind == "angle":
        return angle(joint, view, view.angles.get(which.joint, 0.0))
    a, b = (view[i] for i in joint.bodies)
    return along(joint, a, b)
