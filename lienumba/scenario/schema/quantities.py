"""Named quantities, and events that read them, as data: one class per type, with the keys that it has."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag

from lienumba.keys.formulas import condition
from lienumba.keys.types import NAME_RULE, OR_FORMULA, Name, Rotation, Section, Timed, Vec3

AXES = 'the axes along which it is given: "global", "body" for those of the body itself, or the name of a body'


class _Named(Section):
    name: Name = Field(description=NAME_RULE)


class _Seen(_Named):
    body: str = Field(description="the name of the body")
    relative_to: str = Field(default="ground", description='the name of the body from which it is seen, or "ground"')


class PointQuantity(_Seen):
    type: Literal["point"]
    point: Vec3 = Field(default=[0.0, 0.0, 0.0], description="the point in m, 3 numbers in the body's frame")
    derivative: Literal[0, 1, 2] = Field(default=0, description="0 (position), 1 (velocity) or 2 (acceleration)")
    frame: str | None = Field(default=None, description=f"{AXES} (or omit it: those of relative_to)")


class JointQuantity(_Named):
    type: Literal["joint"]
    joint: str = Field(description="the name of the joint")


class RotationError(_Seen):
    type: Literal["rotation_error"]
    target: Rotation = Field(
        default=[1.0, 0.0, 0.0, 0.0],
        description="the rotation to be reached, in the frame of relative_to: a quaternion [w, x, y, z], a 3x3 matrix, "
        '{axis, angle}, {euler = "ZYX", angles} or {rotation_vector}, in rad',
    )


class AngularVelocity(_Seen):
    type: Literal["angular_velocity"]
    frame: str = Field(default="body", description=AXES)


class Reaction(_Named):
    type: Literal["reaction"]
    joint: str = Field(description="the name of the joint")
    frame: Literal["first", "second", "global"] = Field(
        default="global", description='the axes: "first" or "second" for those of the joint\'s bodies, or "global"'
    )


class DriverEffort(_Named):
    type: Literal["driver_effort"]
    driver: str = Field(description="the name of the driver")


About = Annotated[
    Annotated[Literal["mass_centre"], Tag("name")] | Annotated[Vec3, Tag("point")],
    Discriminator(lambda value: "name" if isinstance(value, str) else "point"),
]


class Momentum(_Named):
    type: Literal["momentum"]
    bodies: Annotated[list[str], Field(min_length=1)] | None = Field(
        default=None, description="the names of the bodies that count (or omit it: all)"
    )
    about: About = Field(
        default=[0.0, 0.0, 0.0],
        description='the point in m, global frame, about which moments are taken, or "mass_centre"',
    )


class Expression(_Named):
    type: Literal["expression"]
    value: Timed = Field(description=f"a number {OR_FORMULA}, of other quantities and of parameters")
    units: str = Field(default="1", description='the units of the value as a text, such as "N m"')


class Event(_Named):
    when: Annotated[str, AfterValidator(condition)] = Field(
        description='a condition of quantities, parameters and t, such as "pointing.angle > 20*deg"'
    )
    action: Literal["record", "stop"] = Field(
        default="record", description='"record" (its time and how often) or "stop" (the run ends there, as a success)'
    )


QUANTITIES: dict[str, type[Section]] = {
    "point": PointQuantity, "joint": JointQuantity, "rotation_error": RotationError,
    "angular_velocity": AngularVelocity, "reaction": Reaction, "driver_effort": DriverEffort, "momentum": Momentum,
    "expression": Expression,
}  # fmt: skip
AnyQuantity = Annotated[
    PointQuantity | JointQuantity | RotationError | AngularVelocity | Reaction | DriverEffort | Momentum | Expression,
    Field(discriminator="type"),
]
