"""The types of joints between two bodies."""

from dataclasses import replace
from math import hypot
from typing import Annotated, Literal

from pydantic import Field

from lienumba.groups import so3
from lienumba.keys.types import Positive
from lienumba.mechanics.elements.joints import parts
from lienumba.mechanics.elements.joints.base import JOINTS, NOTHING, ROD, Own
from lienumba.mechanics.elements.joints.freedoms import IN_PLANE, PINS, TURNS, VECTOR, ZEROS
from lienumba.mechanics.elements.joints.keys import (
    Angle,
    AtPoints,
    Between,
    Displacement,
    FirstAxis,
    InPlane,
    OneAxis,
    PinAngles,
    Placed,
    References,
    Rotating,
    SlidingRotor,
    TurningRotor,
    TwoAxes,
)
from lienumba.mechanics.elements.joints.parts import X, Z
from lienumba.mechanics.mechanism.kinematics import Motion, View
from lienumba.mechanics.mechanism.model import Coordinate, Joint, Model, Number, Start
from lienumba.mechanics.mechanism.moves import Ball, Slide, Turn
from lienumba.numerics.number import Vector
from lienumba.numerics.operations import sqrt


@JOINTS.add
class Spherical(Placed, Rotating):
    words, leaves = "a common point", "all rotations about a common point"
    row_kinds = "mmm"
    vector = 3
    moves = (Ball(),)
    others, together = TURNS, VECTOR

    type: Literal["spherical"]

    residual = staticmethod(parts.separation)


@JOINTS.add
class Revolute(Placed, OneAxis, Angle, TurningRotor):
    words, leaves = "a hinge", "the angle about a common axis"
    row_kinds = "mmmrr"
    vector = 3
    moves = (Turn(),)
    coordinate_kinds = ("angle",)

    type: Literal["revolute"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (*parts.separation(joint, a, b), *parts.parallel(joint, a, b))


@JOINTS.add
class Universal(Placed, TwoAxes, PinAngles):
    words = "two crossed pins"
    leaves = "two angles; axes: the pin fixed in each body, perpendicular to each other"
    row_kinds = "mmmr"
    vector = 3
    moves = (Turn(), Turn(cycled=True))
    others = PINS

    type: Literal["universal"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (*parts.separation(joint, a, b), *parts.perpendicular(joint, a, b))

    def numbers(self) -> dict[str, Number]:
        zero = None if self.references is None else 0.0
        return dict.fromkeys(ZEROS, zero)

    @classmethod
    def open_rows(cls, model: Model, start: Start, index: int) -> int:
        return 0

    @classmethod
    def at_start(cls, model: Model, index: int, view: View) -> dict[str, Number]:
        joint = replace(model.joints[index], numbers={})
        ends = tuple(view[i] for i in joint.bodies)
        given = [view.angles.get(Coordinate(index, x.name), 0.0) for x in PINS]
        return {name: x.value(joint, *ends) - y for name, x, y in zip(ZEROS, PINS, given, strict=True)}


@JOINTS.add
class Cylindrical(Placed, OneAxis, Angle, Displacement):
    words, leaves = "turns and slides", "angle and displacement along a common axis"
    row_kinds = "mmrr"
    moves = (Slide(), Turn())
    coordinate_kinds = ("angle", "displacement")

    type: Literal["cylindrical"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (*parts.across(joint, a, b), *parts.parallel(joint, a, b))


@JOINTS.add
class Prismatic(Placed, OneAxis, References, Displacement, SlidingRotor):
    words, leaves = "slides", "the displacement"
    row_kinds = "mmrrr"
    moves = (Slide(),)
    coordinate_kinds = ("displacement",)
    same_way = (X,)

    type: Literal["prismatic"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (*parts.across(joint, a, b), *parts.parallel(joint, a, b), *parts.aligned(joint, a, b))

    @classmethod
    def open_rows(cls, model: Model, start: Start, index: int) -> int:
        return 1 if start.joints[index].references is None else 0


@JOINTS.add
class Fixed(Placed, OneAxis, References):
    words, leaves = "welded", "nothing"
    row_kinds = "mmmrrr"
    vector = 3
    moves = ()
    needs_axes = False
    same_way = (X, Z)

    type: Literal["fixed"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (*parts.separation(joint, a, b), *parts.parallel(joint, a, b), *parts.aligned(joint, a, b))

    @classmethod
    def open_rows(cls, model: Model, start: Start, index: int) -> int:
        says = start.joints[index]
        if says.references is not None:
            return 0
        return 3 if says.axes is None and says.axis is None else 1

    @classmethod
    def drawn(cls) -> str:
        return NOTHING


@JOINTS.add
class Planar(Placed, OneAxis, InPlane):
    words, leaves = "plane on plane", "motion in a plane; axes: its normal"
    row_kinds = "mrr"
    moves = (Slide(cycled=True), Slide(cycled=True), Turn(cycled=True))
    others = IN_PLANE

    type: Literal["planar"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (parts.along(joint, a, b), *parts.parallel(joint, a, b))


@JOINTS.add
class PointOnLine(Placed, FirstAxis, Displacement):
    words = "a point stays on a line"
    leaves = "a point of the second body stays on a line of the first (point and axis of the first)"
    row_kinds = "mm"
    coordinate_kinds = ("displacement",)

    type: Literal["point_on_line"]

    residual = staticmethod(parts.across)


@JOINTS.add
class PointInPlane(Placed, FirstAxis):
    words, leaves = "a point stays in a plane", "the same with a plane; axes: its normal"
    row_kinds = "m"

    type: Literal["point_in_plane"]

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        return (parts.along(joint, a, b),)


@JOINTS.add
class Distance(AtPoints):
    words, leaves = "a massless rod", "a massless rod between two points"
    row_kinds = "m"

    type: Literal["distance"]
    length: Annotated[Positive | None, Own("m", 0.5, "no rod has")] = Field(
        default=None, description="the distance of the two points in m, above 0 (or omit it: as at the start)"
    )

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        """The two points keep their distance L: (d.d/L - L)/2, which is |d| - L to first order."""
        d, length = parts.separation(joint, a, b), joint.numbers["length"]
        return (0.5 * (so3.dot(d, d) / length - length),)

    @classmethod
    def at_start(cls, model: Model, index: int, view: View) -> dict[str, Number]:
        joint = model.joints[index]
        d = parts.separation(joint, *(view[i] for i in joint.bodies))
        return {"length": sqrt(so3.dot(d, d))}

    @classmethod
    def meaningless(cls, joint: Joint) -> tuple[str, str] | None:
        if joint.numbers["length"] > 0.0:
            return None
        rule = "its two points coincide at the start, so its length is 0 and it must be above 0"
        return rule, "move a point or a body, or use a spherical joint"

    @classmethod
    def missed(cls, joint: Joint, view: View, size: float, turning: bool) -> float:
        return abs(hypot(*parts.separation(joint, *(view[i] for i in joint.bodies))) - float(joint.numbers["length"]))

    @classmethod
    def unmet(cls, turning: bool) -> tuple[str, str]:
        return "its points are not at its length", "length"

    @classmethod
    def drawn(cls) -> str:
        return ROD


@JOINTS.add
class ParallelAxes(Between, OneAxis):
    words, leaves = "directions stay parallel", "directions stay parallel; no points"
    row_kinds = "rr"

    type: Literal["parallel_axes"]

    residual = staticmethod(parts.parallel)


@JOINTS.add
class PerpendicularAxes(Between, TwoAxes):
    words, leaves = "or perpendicular", "directions stay perpendicular; no points"
    row_kinds = "r"

    type: Literal["perpendicular_axes"]

    residual = staticmethod(parts.perpendicular)
