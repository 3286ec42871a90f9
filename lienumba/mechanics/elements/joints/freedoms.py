"""The coordinates of joints: the numbers that say where the second body is against the first, and how fast they change.

Each is a plain function of the joint and the motions of its two bodies. Angles are known up to whole turns, and are
counted (`parts.counted`) by who asks for them.
"""

from collections.abc import Callable
from dataclasses import dataclass

from lienumba.mechanics.elements.joints import parts
from lienumba.mechanics.mechanism.kinematics import Motion
from lienumba.mechanics.mechanism.model import Joint, Number

Value = Callable[[Joint, Motion, Motion], Number]


@dataclass(frozen=True)
class Freedom:
    """name, rate: what it and its rate are called; a name has one unit in all joints. value: of it, in rad or m;
    turning: whether it is an angle; counts: whether it counts over all turns; quasi: something with the same rate,
    where that is not the derivative of the value; quarter: whether the move behind it is a quarter of a turn ahead."""

    name: str
    rate: str
    value: Value
    turning: bool = True
    counts: bool = True
    quasi: Value | None = None
    quarter: bool = False

    @property
    def unit(self) -> str:
        return "rad" if self.turning else "m"

    @property
    def rate_unit(self) -> str:
        return f"{self.unit} s-1"

    @property
    def letter(self) -> str:
        """As rows of residuals have it."""
        return "r" if self.turning else "m"


def _turned(axis: int) -> tuple[Value, Value]:
    """A component of the rotation vector, and of what turns as fast as the second body against the first."""

    def value(joint: Joint, a: Motion, b: Motion) -> Number:
        x: Number = parts.rotation_vector(a, b)[axis]
        return x

    def quasi(joint: Joint, a: Motion, b: Motion) -> Number:
        x: Number = parts.turning(a, b)[axis]
        return x

    return value, quasi


ANGLE = Freedom("angle", "rate", parts.principal)
DISPLACEMENT = Freedom("displacement", "speed", parts.along, turning=False, counts=False)
BY_KIND = {x.name: x for x in (ANGLE, DISPLACEMENT)}  # along which laws may act
PINS = (
    Freedom("first_angle", "first_rate", parts.about_first_pin),
    Freedom("second_angle", "second_rate", parts.about_second_pin, quarter=True),
)
ZEROS = ("first_zero", "second_zero")  # numbers of the joint that has them
IN_PLANE = (
    Freedom("x", "x_rate", parts.along_x, turning=False, counts=False),
    Freedom("y", "y_rate", parts.along_y, turning=False, counts=False),
    ANGLE,
)
VECTOR = ("rotation_vector", "angular_velocity")  # what three together are called
TURNS = tuple(
    Freedom(name, f"{name}_rate", value, counts=False, quasi=quasi)
    for name, (value, quasi) in zip(("rx", "ry", "rz"), map(_turned, range(3)), strict=True)
)
