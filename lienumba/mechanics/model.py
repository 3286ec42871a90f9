"""A mechanism as data: bodies, joints, gravity, and what is known of the initial state.

A *number* is a float, or an array of shape (runs,) where a sweep varies it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

GROUND = -1

Number = Any  # float | numpy.ndarray of shape (runs,) | Symbol | Jet: whatever the kernels compute with
Vec3 = tuple[Number, Number, Number]
Matrix3 = tuple[Number, ...]  # nine numbers, row major


@dataclass(frozen=True)
class Body:
    """A rigid body. `inertia` holds xx yy zz xy xz yz of the tensor, about the mass centre, body frame."""

    name: str
    mass: Number
    inertia: tuple[Number, ...]


@dataclass(frozen=True)
class Joint:
    """A joint between two bodies (indices, GROUND = -1); `points` are given in each body's own frame."""

    name: str
    type: str
    bodies: tuple[int, int]
    points: tuple[Vec3, Vec3]
    length: Number | None = None


@dataclass(frozen=True)
class Model:
    gravity: Vec3
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]


@dataclass(frozen=True)
class Pose:
    """The initial state of one body; None is solved for from the joints.

    position, velocity: mass centre, global frame; rotation: body to global, row major; angular_velocity: body frame.
    """

    position: Vec3 | None = None
    rotation: Matrix3 | None = None
    velocity: Vec3 | None = None
    angular_velocity: Vec3 | None = None


def map_numbers(model: Model, number: Callable[[Number, bool], Number]) -> Model:
    """The same model with number(value, structural) for each of its numbers, in a fixed order.

    structural: an exact 0, 1 or -1 at this place shapes the equations (a coordinate of a point, a product of
    inertia, a component of gravity), where a mass or a length is always a parameter.
    """

    def vector(v: Vec3) -> Vec3:
        return (number(v[0], True), number(v[1], True), number(v[2], True))

    gravity = vector(model.gravity)
    bodies = tuple(
        replace(
            body,
            mass=number(body.mass, False),
            inertia=tuple(number(x, i >= 3) for i, x in enumerate(body.inertia)),
        )
        for body in model.bodies
    )
    joints = tuple(
        replace(
            joint,
            points=(vector(joint.points[0]), vector(joint.points[1])),
            length=None if joint.length is None else number(joint.length, False),
        )
        for joint in model.joints
    )
    return Model(gravity, bodies, joints)
