"""Drivers: one class for each form, with its keys and its mathematics. `DRIVERS` knows them by name.

Where there is no `motion` to name it, a form is known by its keys: a driver of a joint has the key `joint`.
"""

from collections.abc import Iterator
from math import hypot
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from lienumba.errors import Problem
from lienumba.groups import so3
from lienumba.keys.conversions import timed, timed3, vec3
from lienumba.keys.facts import Unit, facts
from lienumba.keys.registry import Registry, literal
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
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import GROUND, Coordinate, Driver, Model, at_time, reads_state
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Matrix, Vector
from lienumba.words import show

POSITION, RATE, VELOCITY = "position", "rate", "velocity"  # the levels on which constraints hold


class DriverType(Section):
    """A form of drivers, and one driver as a scenario has it."""

    form: ClassVar[str]
    noun: ClassVar[str]  # what messages call it
    motions: ClassVar[tuple[str, ...]]  # of the model's drivers that it makes
    ties: ClassVar[bool] = True  # whether it could do without other constraints of its bodies

    name: Name = Field(description=NAME_RULE)

    # ---------------------------------------------------------------- mathematics
    @classmethod
    def residual(cls, model: Model, driver: Driver, wanted: Vector, view: View) -> Vector:
        """What vanishes where the motion is as prescribed; wanted: what is prescribed at this time."""
        raise NotImplementedError

    @classmethod
    def level(cls, driver: Driver) -> str:
        """The level on which it holds."""
        raise NotImplementedError

    @classmethod
    def kinds(cls, driver: Driver) -> str:
        """One letter for each row: "m" for a length, "r" for an angle."""
        raise NotImplementedError

    @classmethod
    def acts_on(cls, model: Model, driver: Driver, read: tuple[int, ...]) -> tuple[int, ...]:
        """Those on which it acts, and those that what it prescribes reads."""
        raise NotImplementedError

    @classmethod
    def effort_in_body(cls, driver: Driver) -> bool:
        """Whether its effort is along the axes of the body."""
        return False

    @classmethod
    def turned(cls, driver: Driver, R: Matrix) -> float:
        """The angle (rad) by which its body, at this rotation, misses at the start what only rotations can."""
        return 0.0

    # ---------------------------------------------------------------- from a scenario to a model
    @classmethod
    def fits(cls, table: dict[str, Any]) -> bool:
        """Whether a table is a driver of this form."""
        return table.get("motion") == cls.form

    @classmethod
    def sketch(cls, name: str, table: dict[str, Any], kinds: tuple[str, ...]) -> Driver:
        """As much of a driver as tells what its effort is; kinds: the coordinates of its joint."""
        raise NotImplementedError

    def to_model(self, names: Names) -> Driver:
        """The driver as kernels see it."""
        raise NotImplementedError

    def prescribed(self) -> dict[str, str]:
        """The keys that hold what it prescribes, with the level of each."""
        raise NotImplementedError

    def driven(self, coordinate: tuple[str, str] | None) -> tuple[tuple[str, ...], str]:
        """What may have one driver only: by what it is known, and in words; coordinate: joint and kind."""
        raise NotImplementedError

    def rotation_at_start(self) -> tuple[str, Matrix] | None:
        """A body and its rotation, where it prescribes one that follows from the time alone."""
        return None

    @classmethod
    def unit(cls, key: str, kind: str | None) -> str:
        """The unit of the numbers of a key; kind: of the coordinate that it drives."""
        return facts(cls, Unit)[key].symbol


DRIVERS: Registry[type[DriverType]] = Registry("driver", lambda kind: kind.form)


def type_of(driver: Driver) -> type[DriverType]:
    """The form of a driver of the model."""
    return next(kind for kind in DRIVERS.values() if driver.motion in kind.motions)


def driver_form(value: Any) -> str | None:
    """Which form of driver a table is; None if it is none of them."""
    if isinstance(value, DriverType):
        return value.form
    if not isinstance(value, dict):
        return None
    return next((form for form, kind in DRIVERS.items() if kind.fits(value)), None)


@DRIVERS.add
class JointDriver(DriverType):
    form, noun = "joint", "the driver of a joint"
    motions = ("value", "rate")
    ties = False

    joint: str = Field(description="the name of the joint")
    coordinate: CoordinateKind | None = Field(
        default=None,
        description='which coordinate of the joint: "angle" or "displacement" (or omit it where there is only one)',
    )
    value: Timed | None = Field(default=None, description=f"the angle in rad or displacement in m {OR_FORMULA}")
    rate: Timed | None = Field(default=None, description=f"its rate in rad/s or m/s, instead of value {OR_FORMULA}")

    @classmethod
    def residual(cls, model: Model, driver: Driver, wanted: Vector, view: View) -> Vector:
        """The coordinate, less its value; or less the integral of its rate, whose own value nobody needs."""
        assert driver.coordinate is not None
        if cls.level(driver) == POSITION:
            return (joints.coordinate(model, driver.coordinate, view) - wanted[0],)
        rate, t = lift(wanted[0]), lift(view.t)
        return (joints.in_motion(model, driver.coordinate, view) - Jet(0.0, rate.a * t.b, rate.b),)

    @classmethod
    def level(cls, driver: Driver) -> str:
        return RATE if driver.motion == "rate" else POSITION

    @classmethod
    def kinds(cls, driver: Driver) -> str:
        assert driver.coordinate is not None
        return joints.named(driver.coordinate.kind).letter

    @classmethod
    def acts_on(cls, model: Model, driver: Driver, read: tuple[int, ...]) -> tuple[int, ...]:
        assert driver.coordinate is not None
        return tuple(dict.fromkeys((*read, *model.joints[driver.coordinate.joint].bodies)))

    @classmethod
    def fits(cls, table: dict[str, Any]) -> bool:
        return "joint" in table and not ("body" in table and "motion" in table)

    def faults(self) -> Iterator[Problem]:
        if (self.value is None) == (self.rate is None):
            yield Problem(
                "",
                "has neither value nor rate" if self.value is None else "has both value and rate",
                "give either value (the coordinate itself) or rate (its speed) as a number or a formula of t, such as "
                '"0.3*sin(2*t)"',
            )

    @classmethod
    def sketch(cls, name: str, table: dict[str, Any], kinds: tuple[str, ...]) -> Driver:
        kind = table.get("coordinate") or (kinds[0] if kinds else "angle")
        return Driver(name, "value", (), (0.0,), Coordinate(0, str(kind)))

    def to_model(self, names: Names) -> Driver:
        motion, value = ("rate", self.rate) if self.value is None else ("value", self.value)
        which = names.coordinate(self.joint, self.coordinate)
        return Driver(self.name, motion, names.ends(self.joint), (timed(value),), which)

    def prescribed(self) -> dict[str, str]:
        return {"value": POSITION, "rate": RATE}

    def driven(self, coordinate: tuple[str, str] | None) -> tuple[tuple[str, ...], str]:
        assert coordinate is not None
        return coordinate, f"the {coordinate[1]} of {coordinate[0]}"

    @classmethod
    def unit(cls, key: str, kind: str | None) -> str:
        driven = joints.named(str(kind))
        return driven.rate_unit if key == "rate" else driven.unit


class BodyDriver(DriverType):
    """Three numbers of one body, which its `motion` names."""

    own_level: ClassVar[str] = POSITION
    letter: ClassVar[str] = "r"

    body: str = Field(description="the name of the body")

    @classmethod
    def __pydantic_init_subclass__(cls, **keys: Any) -> None:
        if "motion" in cls.model_fields:
            cls.form = literal("motion")(cls)
            cls.noun = f"the motion {cls.form}"
            cls.motions = (cls.form,)

    @classmethod
    def level(cls, driver: Driver) -> str:
        return cls.own_level

    @classmethod
    def kinds(cls, driver: Driver) -> str:
        return 3 * cls.letter

    @classmethod
    def acts_on(cls, model: Model, driver: Driver, read: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(dict.fromkeys((GROUND, *read, driver.bodies[-1])))

    @classmethod
    def sketch(cls, name: str, table: dict[str, Any], kinds: tuple[str, ...]) -> Driver:
        return Driver(name, cls.form, (0,), (0.0,), frame=str(table.get("frame", "global")))

    def to_model(self, names: Names) -> Driver:
        given = dict(self)
        return Driver(
            self.name,
            self.form,
            (names.bodies[self.body],),
            timed3(given["value"]),
            point=vec3(given["point"]) if "point" in given else None,
            frame=given.get("frame", "global"),
        )

    def prescribed(self) -> dict[str, str]:
        return {"value": self.own_level}

    def driven(self, coordinate: tuple[str, str] | None) -> tuple[tuple[str, ...], str]:
        return ("rotation", self.body), f"the rotation of {self.body}"


@DRIVERS.add
class PointDriver(BodyDriver):
    letter = "m"

    point: Annotated[Vec3, Unit("m")] = Field(default=ZERO, description="the point in m, 3 numbers in the body's frame")
    motion: Literal["point"]
    value: Annotated[Timed3, Unit("m")] = Field(
        description=f"the position of the point in m, global frame: 3 numbers {OR_FORMULA}"
    )

    @classmethod
    def residual(cls, model: Model, driver: Driver, wanted: Vector, view: View) -> Vector:
        """The point is where the prescription has it."""
        x, y, z = wanted
        assert driver.point is not None
        return so3.subtract(view[driver.bodies[-1]].point(driver.point), (x, y, z))

    def driven(self, coordinate: tuple[str, str] | None) -> tuple[tuple[str, ...], str]:
        return ("point", self.body, str(self.point)), f"the point {show(self.point)} of {self.body}"


@DRIVERS.add
class OrientationDriver(BodyDriver):
    ties = False

    motion: Literal["orientation"]
    value: Annotated[Timed3, Unit("rad")] = Field(
        description=f"the rotation vector from body to global in rad: 3 numbers {OR_FORMULA}"
    )

    @classmethod
    def residual(cls, model: Model, driver: Driver, wanted: Vector, view: View) -> Vector:
        """R = exp(value): the sine vector of the rotation between them, body frame."""
        x, y, z = wanted
        return so3.vee(so3.multiply(so3.transpose(so3.exp((x, y, z))), view[driver.bodies[-1]].R))

    @classmethod
    def effort_in_body(cls, driver: Driver) -> bool:
        return True

    @classmethod
    def turned(cls, driver: Driver, R: Matrix) -> float:
        if any(map(reads_state, driver.value)):
            return 0.0
        x, y, z = (at_time(number, 0.0) for number in driver.value)
        return hypot(*so3.log(so3.multiply(so3.transpose(so3.exp((x, y, z))), R)))

    def rotation_at_start(self) -> tuple[str, Matrix] | None:
        value = timed3(self.value)
        if any(map(reads_state, value)):
            return None
        x, y, z = (at_time(number, 0.0) for number in value)
        return self.body, so3.exp((x, y, z))


@DRIVERS.add
class AngularVelocityDriver(BodyDriver):
    own_level = VELOCITY
    ties = False

    motion: Literal["angular_velocity"]
    frame: Axes = AXES
    value: Annotated[Timed3, Unit("rad s-1")] = Field(
        description=f"the angular velocity in rad/s: 3 numbers {OR_FORMULA}"
    )

    @classmethod
    def residual(cls, model: Model, driver: Driver, wanted: Vector, view: View) -> Vector:
        """w (body frame) or R w (global) is as prescribed."""
        body = view[driver.bodies[-1]]
        x, y, z = wanted
        return so3.subtract(body.w if driver.frame == "body" else so3.rotate(body.R, body.w), (x, y, z))

    @classmethod
    def effort_in_body(cls, driver: Driver) -> bool:
        return driver.frame == "body"
