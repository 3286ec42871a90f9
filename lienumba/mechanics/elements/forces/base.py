"""What force types have in common. A type is one class: its keys, the coordinates that it acts along and, of these, a
potential, an effort, or both.

Coordinates are plain functions of a View (`lienumba.mechanics.mechanism.kinematics`): lengths in metres, angles in
radians; or, on the velocity level, quasi-velocities. The effort along a coordinate (N or N m) is -dV/dc plus what
`effort` gives; both signs are such that effort * rate is the power on the bodies. Derivatives are taken in
`lienumba.mechanics.system.applied_forces`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from lienumba.groups import so3
from lienumba.keys.conversions import timed, vec3
from lienumba.keys.facts import facts
from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import COORDINATE_KINDS, NAME_RULE, ZERO, BodyPair, CoordinateKind, Name, Section, Two, Vec3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.forces.numbers import ForceNumber
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import evaluate
from lienumba.mechanics.mechanism.kinematics import Motion, View, moving
from lienumba.mechanics.mechanism.model import Force, Model
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero, sqrt

Keys = Mapping[str, Any]
SQUARE_FLOOR = 1e-200  # m^2, below the square of every length that matters: zero divided by it is zero


@dataclass(frozen=True)
class Given:
    """given[name]: a number of the force, or its components; view: its bodies, and those that it reads, now."""

    model: Model
    force: Force
    view: View

    def __getitem__(self, name: str) -> Any:
        x = self.force.numbers.get(name)
        if x is None:
            x = law_of(self.force).default(name)
        if isinstance(x, tuple):
            return tuple(evaluate(self.model, y, self.view) for y in x)
        return evaluate(self.model, x, self.view)

    def rate(self, name: str) -> Number:
        """The time derivative of a number."""
        rate: Number = lift(replace(self, view=moving(self.view))[name]).b
        return rate

    @property
    def rest(self) -> Vector:
        """What the start has decided."""
        assert self.force.rest is not None
        return self.force.rest


# ---------------------------------------------------------------- what every type has
class ForceLaw(Section):
    """A force, as a scenario describes it.

    example: values of its own keys, with which it acts, for tests; velocity_level: whether its coordinates are
    quasi-velocities; infinite: what is wrong, and the remedy, where it is not finite at the start.
    """

    example: ClassVar[Keys] = {}
    velocity_level: ClassVar[bool] = False
    infinite: ClassVar[tuple[str, str]] = (
        "must be finite at the start",
        "look for numbers that are far too large or too small",
    )

    name: Name = Field(description=NAME_RULE)
    if TYPE_CHECKING:
        type: str

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        """What the force acts along."""
        raise NotImplementedError

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        """The potential energy in J, of the coordinates; a type without it leaves it out."""
        raise NotImplementedError

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        """N or N m along each coordinate beside the conservative ones, -dV/dc; a type without it leaves it out."""
        raise NotImplementedError

    @classmethod
    def has_potential(cls) -> bool:
        """Whether it stores energy."""
        return cls.potential is not ForceLaw.potential

    @classmethod
    def has_effort(cls) -> bool:
        """Whether it does more than a potential."""
        return cls.effort is not ForceLaw.effort

    @classmethod
    def numbers(cls) -> Mapping[str, ForceNumber]:
        """What its numbers are, by their keys."""
        return facts(cls, ForceNumber)

    @classmethod
    def default(cls, key: str) -> Any:
        """The number at a key that is left out."""
        if key not in cls.numbers():
            raise TypeError(f"{cls.__name__}.{key} is not declared as a number; write {key}: Timed = number(...)")
        default = cls.model_fields[key].default
        return tuple(default) if isinstance(default, list) else default

    @classmethod
    def reads_angle(cls, force: Force) -> bool:
        """Whether it depends on the angle of its joint over all turns, and not only on its rate."""
        counting = [key for key, number in cls.numbers().items() if number.counts_turns]
        return any(not is_zero(force.numbers.get(key, cls.default(key))) for key in counting)

    @classmethod
    def at_start(cls, force: Force, view: View) -> Vector | None:
        """What the start decides of it, where it is not given."""
        return None

    def to_model(self, names: Names) -> Force:
        """The force of the model."""
        raise NotImplementedError

    def _force(self, bodies: tuple[int, ...], **more: Any) -> Force:
        given = {key: x for key in self.numbers() if (x := getattr(self, key)) is not None}
        numbers = {key: tuple(map(timed, x)) if isinstance(x, list) else timed(x) for key, x in given.items()}
        return Force(self.name, self.type, bodies, numbers=numbers, **more)


FORCES: Registry[type[ForceLaw]] = Registry("force", literal("type"))
BESIDE: dict[str, type[ForceLaw]] = {}  # of what is a force of the model, and none of the scenario


def law_of(force: Force) -> type[ForceLaw]:
    """The class of a force of the model."""
    return BESIDE.get(force.type) or FORCES[force.type]


# ---------------------------------------------------------------- where they act
class OnBody(ForceLaw):
    body: str = Field(description="the name of the body")

    def to_model(self, names: Names) -> Force:
        return self._force((names.bodies[self.body],), frame=getattr(self, "frame", "global"))


class OnPoint(OnBody):
    """Along the global position of a point."""

    point: Vec3 = Field(default=ZERO, description="the point in m, 3 numbers in the body's frame")

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        position: Vector = view[given.force.bodies[-1]].point(given.force.points[0])
        return position

    def to_model(self, names: Names) -> Force:
        return replace(super().to_model(names), points=(vec3(self.point),))


class BetweenPoints(ForceLaw):
    """Along the distance of two points; where they coincide it has no direction, and nothing acts."""

    bodies: BodyPair = Field(description='the names of the two bodies; the fixed world is "ground"')
    points: Two = Field(description="two points in m, each with 3 numbers in the frame of its own body")

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        return (length(apart(given.force, view)[2]),)

    def to_model(self, names: Names) -> Force:
        return self._force(tuple(names.bodies[name] for name in self.bodies), points=tuple(map(vec3, self.points)))


class AlongJoint(ForceLaw):
    """Along a coordinate of a joint, of one of `kinds`; otherwise: what to use for another one."""

    kinds: ClassVar[tuple[str, ...]] = COORDINATE_KINDS
    otherwise: ClassVar[str] = "name another joint"

    joint: str = Field(description="the name of the joint")
    coordinate: CoordinateKind | None = Field(
        default=None,
        description='which coordinate of the joint: "angle" or "displacement" (or omit it where there is only one)',
    )

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        assert given.force.coordinate is not None
        return (joints.coordinate(given.model, given.force.coordinate, view),)

    def to_model(self, names: Names) -> Force:
        return self._force(names.ends(self.joint), coordinate=names.coordinate(self.joint, self.coordinate, self.kinds))


def apart(force: Force, view: View) -> tuple[Motion, Motion, so3.Vec3]:
    """Both bodies, and the vector from the first point to the second, global frame."""
    a, b = (view[i] for i in force.bodies)
    p, q = force.points
    return a, b, so3.subtract(b.point(q), a.point(p))


def length(v: so3.Vec3, least: Number = 0.0) -> Any:
    """|v|, and to first order its change: along the direction that v has now. Zero has no direction; least: m, what it
    is there, at most the root of SQUARE_FLOOR, so that what is proportional to it has its slope."""
    d: Any = tuple(lift(x).a for x in v)
    inverse = 1.0 / sqrt(so3.dot(d, d) + SQUARE_FLOOR)
    return so3.dot(so3.scale(inverse, d), v) + (least * least) * inverse


def quadratic(stiffness: Number, x: Number) -> Number:
    """k x^2 / 2."""
    return (0.5 * stiffness) * (x * x)
