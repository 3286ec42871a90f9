"""What residuals of joints are composed of: points that meet, directions that are parallel, coordinates.

A residual takes the joint and the motions of its two bodies and returns its rows: lengths in metres, or sines of
angles where the rows concern directions. Velocity and acceleration equations are derived from it
(`lienumba.mechanics.mechanism.kinematics`).
Frames: x, y, z of each side, z the axis; d is the vector from the first body's point to the second's.
"""

from math import pi

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Motion
from lienumba.mechanics.mechanism.model import Joint, Number, Vec3
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


def principal(joint: Joint, a: Motion, b: Motion) -> Number:
    """The rotation (rad) of the second body relative to the first about the axis, up to whole turns."""
    cosine, sine = projected(joint, a, direction(joint, 1, b, X), X, Y)
    return atan2(sine, cosine)


def counted(principal: Number, near: Number) -> Number:
    """An angle (rad) with as many turns as bring it near a value."""
    turns = round_to_integer((near - lift(principal).a) * (0.5 / pi))
    return principal + (2.0 * pi) * turns


def about_first_pin(joint: Joint, a: Motion, b: Motion) -> Number:
    """The angle (rad) about the first of two crossed axes, from x to the second axis."""
    cosine, sine = projected(joint, a, direction(joint, 1, b, Z), X, Y)
    return atan2(sine, cosine) - joint.numbers.get("first_zero", 0.0)


def about_second_pin(joint: Joint, a: Motion, b: Motion) -> Number:
    """The angle (rad) about the second of two crossed axes, from the first axis to x."""
    z = direction(joint, 0, a, Z)
    cosine, sine = (so3.dot(direction(joint, 1, b, axis), z) for axis in (X, Y))
    return atan2(-sine, cosine) - joint.numbers.get("second_zero", 0.0)


def along_x(joint: Joint, a: Motion, b: Motion) -> Number:
    """x.d: how far the second point is along x of the first side."""
    x: Number = across(joint, a, b)[0]
    return x


def along_y(joint: Joint, a: Motion, b: Motion) -> Number:
    """y.d, likewise."""
    y: Number = across(joint, a, b)[1]
    return y


def rotation_vector(a: Motion, b: Motion) -> Vec3:
    """That of the second body against the first (rad): the same along the axes of both, at most half a turn."""
    return so3.log(so3.multiply(so3.transpose(a.R), b.R))


def turning(a: Motion, b: Motion) -> Vec3:
    """The rotation vector from where the bodies are, which turns as they do: its rate is the relative angular velocity
    along the axes of the second."""
    E = so3.multiply(so3.transpose(a.R), b.R)
    now: Vector = tuple(lift(x).a for x in E)
    return so3.vee(so3.multiply(so3.transpose(now), E))


def rate_of_turning(joint: Joint, a: Motion, b: Motion) -> Number:
    """The rate (rad/s) of the angle, from what each body turns about its own axis: linear in w, with constant
    coefficients. (The axes may point against each other.)"""
    assert joint.frames is not None
    first, second = (so3.dot(joint.frames[side][Z], body.w) for side, body in enumerate((a, b)))
    return joint.way * second - first
