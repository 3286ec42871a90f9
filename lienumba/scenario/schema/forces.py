"""Drivers as data: one class per kind, with the keys that it has. Every number may be a formula of t."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from lienumba.keys.types import (
    AXES,
    NAME_RULE,
    OR_FORMULA,
    ZERO,
    Axes,
    CoordinateKind,
    Name,
    Section,
    Timed,
    Timed3,
    Vec3,
)


class _Named(Section):
    name: Name = Field(description=NAME_RULE)


class _OfJoint(_Named):
    joint: str = Field(description="the name of the joint")
    coordinate: CoordinateKind | None = Field(
        default=None,
        description='which coordinate of the joint: "angle" or "displacement" (or omit it where there is only one)',
    )


class _OfBody(_Named):
    body: str = Field(description="the name of the body")


class _OfPoint(_OfBody):
    point: Vec3 = Field(default=ZERO, description="the point in m, 3 numbers in the body's frame")


# ---------------------------------------------------------------- drivers
class JointDriver(_OfJoint):
    value: Timed | None = Field(default=None, description=f"the angle in rad or displacement in m {OR_FORMULA}")
    rate: Timed | None = Field(default=None, description=f"its rate in rad/s or m/s, instead of value {OR_FORMULA}")


class PointDriver(_OfPoint):
    motion: Literal["point"]
    value: Timed3 = Field(description=f"the position of the point in m, global frame: 3 numbers {OR_FORMULA}")


class OrientationDriver(_OfBody):
    motion: Literal["orientation"]
    value: Timed3 = Field(description=f"the rotation vector from body to global in rad: 3 numbers {OR_FORMULA}")


class AngularVelocityDriver(_OfBody):
    motion: Literal["angular_velocity"]
    frame: Axes = AXES
    value: Timed3 = Field(description=f"the angular velocity in rad/s: 3 numbers {OR_FORMULA}")


DRIVERS: dict[str, type[Section]] = {
    "joint": JointDriver, "point": PointDriver, "orientation": OrientationDriver,
    "angular_velocity": AngularVelocityDriver,
}  # fmt: skip


def driver_form(value: object) -> str | None:
    """Which of the four kinds of driver a table is; None if it is none of them."""
    if isinstance(value, Section):
        return next(form for form, section in DRIVERS.items() if isinstance(value, section))
    if not isinstance(value, dict):
        return None
    if "joint" in value and not ("body" in value and "motion" in value):
        return "joint"
    motion = value.get("motion")
    return motion if isinstance(motion, str) and motion in DRIVERS and motion != "joint" else None


Driver = Annotated[
    Annotated[JointDriver, Tag("joint")]
    | Annotated[PointDriver, Tag("point")]
    | Annotated[OrientationDriver, Tag("orientation")]
    | Annotated[AngularVelocityDriver, Tag("angular_velocity")],
    Discriminator(driver_form),
]
