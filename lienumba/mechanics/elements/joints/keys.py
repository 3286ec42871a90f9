"""Keys that several types of joints have, with what follows from having them."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar

from pydantic import Field

from lienumba.errors import Problem, missing
from lienumba.keys.conversions import has_direction, has_rows, norm, undirected
from lienumba.keys.facts import Unit
from lienumba.keys.types import BodyPair, NotNegative, Number, Two, Vec3
from lienumba.mechanics.elements.joints.base import JointType
from lienumba.mechanics.elements.names import Names
from lienumba.words import show

PARALLEL = 1e-6  # sine of the angle below which two directions count as parallel
OWN_POINTS = "give two points in m, each with 3 numbers in the frame of its own body"
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

    def faults(self) -> Iterator[Problem]:
        if self.points is None and not isinstance(self, Placed):
            yield missing("points", OWN_POINTS)
        yield from super().faults()


class Placed(AtPoints):
    at: Annotated[Vec3 | None, Unit("m")] = Field(
        default=None, description="the common point in m in the global frame at the start, instead of points"
    )

    def faults(self) -> Iterator[Problem]:
        if self.points is None and self.at is None:
            yield missing("points", f"{OWN_POINTS}, or at = [x, y, z] in the global frame at the start")
        elif self.points is not None and self.at is not None:
            remedy = "give either points (in the bodies' own frames) or at (in the global frame at the start)"
            yield Problem("at", "the joint has points already", remedy, self.at)
        yield from super().faults()


class WithAxes(JointType):
    """axes_form, axis_form: what to give for `axes`, and in the global frame for `axis`."""

    sides = 2
    axes_form: ClassVar[str] = PAIR
    axis_form: ClassVar[str] = "[x, y, z]"
    example_axes: ClassVar[list[list[float]]] = [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        return {**super().example_keys(), "axes": cls.example_axes}

    def faults(self) -> Iterator[Problem]:
        """Directions are given once, and are directions; those that count angles lie across the axes."""
        yield from super().faults()
        given = dict(self)
        axes, axis = given["axes"], given["axis"]
        if axes is not None and axis is not None:
            remedy = "give either axes (in the bodies' own frames) or axis (in the global frame at the start)"
            yield Problem("axis", "the joint has axes already", remedy, axis)
        if axes is None and axis is None and self.needs_axes:
            yield missing("axes", f"give {self.axes_form}, or axis = {self.axis_form} in the global frame at the start")
        for key in ("axes", "axis", "references"):
            value: Any = given.get(key)
            for at, v in [(f"{key}[{i}]", v) for i, v in enumerate(value)] if has_rows(value) else [(key, value)]:
                yield from undirected(at, v)
        if has_rows(axis) and all(map(has_direction, axis)) and sine(*axis) < PARALLEL:
            remedy = "give the direction in each of the two bodies"
            yield Problem("axis", "the two directions are parallel and must be perpendicular", remedy, axis)
        for i, (along, across) in enumerate(zip(axes or (), given.get("references") or (), strict=False)):
            if has_direction(along) and has_direction(across) and sine(along, across) < PARALLEL:
                rule = f"is parallel to the axis {show(along)}"
                yield Problem(f"references[{i}]", rule, "give a direction across it", across)


def sine(a: Sequence[float], b: Sequence[float]) -> float:
    """Of the angle between two vectors."""
    p, q = ([x / norm(v) for x in v] for v in (a, b))
    return norm([p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]])


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


class PinAngles(References):
    first_angle: Annotated[Number | None, Unit("rad")] = Field(
        default=None,
        description="the angle about the pin of the first body at the start in rad, 0 where the first reference lies "
        "along the other pin",
    )
    first_rate: Annotated[Number | None, Unit("rad s-1")] = Field(
        default=None, description="its rate at the start in rad/s"
    )
    second_angle: Annotated[Number | None, Unit("rad")] = Field(
        default=None,
        description="the angle about the pin of the second body at the start in rad, 0 where the second reference lies "
        "along the other pin",
    )
    second_rate: Annotated[Number | None, Unit("rad s-1")] = Field(
        default=None, description="its rate at the start in rad/s"
    )


class InPlane(Angle):
    x: Annotated[Number | None, Unit("m")] = Field(
        default=None, description="the displacement along the first body's reference at the start in m"
    )
    x_rate: Annotated[Number | None, Unit("m s-1")] = Field(default=None, description="its rate at the start in m/s")
    y: Annotated[Number | None, Unit("m")] = Field(
        default=None, description="the displacement across the first body's reference at the start in m"
    )
    y_rate: Annotated[Number | None, Unit("m s-1")] = Field(default=None, description="its rate at the start in m/s")


class Rotating(JointType):
    rotation_vector: Annotated[Vec3 | None, Unit("rad")] = Field(
        default=None, description="the rotation vector of the second body against the first at the start in rad"
    )
    angular_velocity: Annotated[Vec3 | None, Unit("rad s-1")] = Field(
        default=None,
        description="the angular velocity of the second body against the first at the start in rad/s, along the axes "
        "of the second",
    )


class TurningRotor(JointType):
    """A rotor turns as fast as the joint."""

    rotor = "angle"

    armature: Annotated[NotNegative | None, Unit("kg m2")] = Field(
        default=None,
        description="the inertia in kg m^2 of a rotor that turns with the angle, gear squared, at least 0 "
        "(or omit it: none)",
    )


class SlidingRotor(JointType):
    """A rotor turns in proportion to the displacement."""

    rotor = "displacement"

    armature: Annotated[NotNegative | None, Unit("kg")] = Field(
        default=None,
        description="the inertia in kg of a rotor that turns with the displacement, gear squared, at least 0 "
        "(or omit it: none)",
    )
