"""Keys that several types of joints have, with what follows from having them."""

from typing import Annotated, Any, ClassVar

from pydantic import Field

from lienumba.keys.facts import Unit
from lienumba.keys.types import BodyPair, Number, Two, Vec3
from lienumba.mechanics.elements.joints.base import JointType
from lienumba.mechanics.elements.names import Names

PAIR = "two directions, each with 3 numbers in the frame of its own body"
OneOrTwo = Annotated[list[Vec3], Field(min_length=1, max_length=2)]


class Between(JointType):
    """A joint of two bodies."""

    bodies: BodyPair = Field(description='the names of the two bodies it joins; the fixed world is "ground"')

    def ends(self, names: Names) -> tuple[int, ...]:
        return tuple(names.bodies[name] for name in self.bodies)

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        return {**super().example_keys(), "bodies": ["first", "second"]}


class AtPoints(Between):
    has_points = True

    points: Annotated[Two | None, Unit("m")] = Field(
        default=None, description="two points in m, each with 3 numbers in the frame of its own body"
    )

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        return {**super().example_keys(), "points": [[0.0, 0.0, -0.3], [-0.1, 0.2, 0.4]]}


class Placed(AtPoints):
    at: Annotated[Vec3 | None, Unit("m")] = Field(
        default=None, description="the common point in m in the global frame at the start, instead of points"
    )


class WithAxes(JointType):
    """axes_form, axis_form: what to give for `axes`, and in the global frame for `axis`."""

    sides = 2
    axes_form: ClassVar[str] = PAIR
    axis_form: ClassVar[str] = "[x, y, z]"
    example_axes: ClassVar[list[list[float]]] = [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        return {**super().example_keys(), "axes": cls.example_axes}


class OneAxis(WithAxes):
    """The axes of both bodies stay parallel."""

    stays_parallel = True

    axes: Two | None = Field(default=None, description=PAIR)
    axis: Vec3 | None = Field(
        default=None, description="the common direction in the global frame at the start, instead of axes: 3 numbers"
    )


class FirstAxis(WithAxes):
    """Only the first body has an axis."""

    sides = 1
    axes_form = "the direction in the frame of the first body, as [[x, y, z]]"
    example_axes = [[0.0, 1.0, 0.0]]  # noqa: RUF012

    axes: OneOrTwo | None = Field(
        default=None, description="the direction in the frame of the first body, as a list of lists: [[x, y, z]]"
    )
    axis: Vec3 | None = Field(
        default=None, description="the direction in the global frame at the start, instead of axes: 3 numbers"
    )


class TwoAxes(WithAxes):
    """The axes of the two bodies cross at a right angle."""

    axis_form = "[[x, y, z], [x, y, z]]"
    example_axes = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]  # noqa: RUF012

    axes: Two | None = Field(default=None, description=PAIR)
    axis: Two | None = Field(
        default=None,
        description="two directions in the global frame at the start, instead of axes: the one of each body",
    )

    @classmethod
    def unmet(cls, turning: bool) -> tuple[str, str]:
        return ("its axes are not perpendicular", "axes") if turning else super().unmet(turning)


class References(JointType):
    references: Two | None = Field(
        default=None,
        description="two directions, each in the frame of its own body, between which the angle counts "
        "(or omit them: the angle is 0 at the start)",
    )


class Angle(References):
    angle: Annotated[Number | None, Unit("rad")] = Field(default=None, description="the angle at the start in rad")
    rate: Annotated[Number | None, Unit("rad s-1")] = Field(
        default=None, description="the rate of the angle at the start in rad/s"
    )


class Displacement(JointType):
    displacement: Annotated[Number | None, Unit("m")] = Field(
        default=None, description="the displacement at the start in m"
    )
    speed: Annotated[Number | None, Unit("m s-1")] = Field(
        default=None, description="the rate of the displacement at the start in m/s"
    )
