"""Joints as data: one class per type, with the keys that it has."""

from typing import Annotated, Literal

from pydantic import Field

from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import NAME_RULE, Name, Number, Positive, Section, Vec3

Two = Annotated[list[Vec3], Field(min_length=2, max_length=2)]
OneOrTwo = Annotated[list[Vec3], Field(min_length=1, max_length=2)]
BodyPair = Annotated[list[str], Field(min_length=2, max_length=2)]
CoordinateKind = Literal["angle", "displacement"]


class Between(Section):
    """A joint of two bodies."""

    name: Name = Field(description=NAME_RULE)
    bodies: BodyPair = Field(description='the names of the two bodies it joins; the fixed world is "ground"')


class AtPoints(Between):
    points: Two | None = Field(
        default=None, description="two points in m, each with 3 numbers in the frame of its own body"
    )


class Placed(AtPoints):
    at: Vec3 | None = Field(
        default=None, description="the common point in m in the global frame at the start, instead of points"
    )


class OneAxis(Section):
    axes: Two | None = Field(
        default=None, description="two directions, each with 3 numbers in the frame of its own body"
    )
    axis: Vec3 | None = Field(
        default=None, description="the common direction in the global frame at the start, instead of axes: 3 numbers"
    )


class FirstAxis(Section):
    axes: OneOrTwo | None = Field(
        default=None, description="the direction in the frame of the first body, as a list of lists: [[x, y, z]]"
    )
    axis: Vec3 | None = Field(
        default=None, description="the direction in the global frame at the start, instead of axes: 3 numbers"
    )


class TwoAxes(Section):
    axes: Two | None = Field(
        default=None, description="two directions, each with 3 numbers in the frame of its own body"
    )
    axis: Two | None = Field(
        default=None,
        description="two directions in the global frame at the start, instead of axes: the one of each body",
    )


class References(Section):
    references: Two | None = Field(
        default=None,
        description="two directions, each in the frame of its own body, between which the angle counts "
        "(or omit them: the angle is 0 at the start)",
    )


class Angle(References):
    angle: Number | None = Field(default=None, description="the angle at the start in rad")
    rate: Number | None = Field(default=None, description="the rate of the angle at the start in rad/s")


class Displacement(Section):
    displacement: Number | None = Field(default=None, description="the displacement at the start in m")
    speed: Number | None = Field(default=None, description="the rate of the displacement at the start in m/s")


class Spherical(Placed):
    type: Literal["spherical"]


class Revolute(Placed, OneAxis, Angle):
    type: Literal["revolute"]


class Universal(Placed, TwoAxes):
    type: Literal["universal"]


class Cylindrical(Placed, OneAxis, Angle, Displacement):
    type: Literal["cylindrical"]


class Prismatic(Placed, OneAxis, References, Displacement):
    type: Literal["prismatic"]


class Fixed(Placed, OneAxis, References):
    type: Literal["fixed"]


class Planar(Placed, OneAxis):
    type: Literal["planar"]


class PointOnLine(Placed, FirstAxis, Displacement):
    type: Literal["point_on_line"]


class PointInPlane(Placed, FirstAxis):
    type: Literal["point_in_plane"]


class Distance(AtPoints):
    type: Literal["distance"]
    length: Positive | None = Field(
        default=None, description="the distance of the two points in m, above 0 (or omit it: as at the start)"
    )


class ParallelAxes(Between, OneAxis):
    type: Literal["parallel_axes"]


class PerpendicularAxes(Between, TwoAxes):
    type: Literal["perpendicular_axes"]


class Screw(Placed, OneAxis, Angle, Displacement):
    type: Literal["screw"]
    pitch: Number = Field(description="the displacement in m per turn, not 0; negative for a left-hand thread")


class _Coupling(Section):
    """second = ratio * first + offset, of two coordinates of other joints."""

    name: Name = Field(description=NAME_RULE)
    joints: BodyPair = Field(description="the names of the two joints whose coordinates it couples")
    coordinates: Annotated[list[CoordinateKind], Field(min_length=2, max_length=2)] | None = Field(
        default=None,
        description='which coordinate of each of the two joints: "angle" or "displacement" '
        "(or omit them where a joint has only one)",
    )
    ratio: Number = Field(description="the ratio, not 0: second = ratio * first + offset")
    offset: Number | None = Field(default=None, description="the offset in rad or m (or omit it: as at the start)")


class Gear(_Coupling):
    type: Literal["gear"]


class Coupler(_Coupling):
    type: Literal["coupler"]


class PythonJoint(Section):
    type: Literal["python"]
    name: Name = Field(description=NAME_RULE)
    function: str = Field(description='the file and the function in it: "cam.py:contact"')
    bodies: Annotated[list[str], Field(min_length=1)] = Field(
        description='the names of the bodies that it gets, in order, or "ground"'
    )
    parameters: dict[str, Number] = Field(default={}, description="numbers that it gets by name: { radius = 0.1 }")
    level: Literal["position", "velocity"] = Field(
        default="position", description='what it restricts: "position", or "velocity" (a rolling disc)'
    )
    rows: list[Literal["m", "rad"]] | None = Field(
        default=None, description='the unit of each equation, "m" or "rad" (or omit it: m)'
    )


JOINTS: Registry[type[Section]] = Registry("joint", literal("type"))
for joint in (
    Spherical, Revolute, Universal, Cylindrical, Prismatic, Fixed, Planar, PointOnLine, PointInPlane, Distance,
    ParallelAxes, PerpendicularAxes, Screw, Gear, Coupler, PythonJoint,
):  # fmt: skip
    JOINTS.add(joint)
