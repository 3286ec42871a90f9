"""The types of quantities: points, coordinates, attitudes, reactions, momenta, and formulas of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from lienumba.errors import Problem
from lienumba.groups import so3
from lienumba.keys.conversions import rotation_of, timed, vec3
from lienumba.keys.types import OR_FORMULA, ZERO, Rotation, Timed, Vec3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.drivers import type_of
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities.base import (
    OBSERVED,
    POSITION,
    QUANTITIES,
    VELOCITY,
    Observed,
    Part,
    QuantityType,
    name_of,
)
from lienumba.mechanics.elements.quantities.evaluation import evaluate
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Mode, View
from lienumba.mechanics.mechanism.model import GROUND, Coordinate, Model, Quantity
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Vector
from lienumba.numerics.operations import sqrt
from lienumba.words import show

SQUARE_FLOOR = 1e-200  # so that an angle of zero has a rate
OF_POINT = (("m", "position"), ("m s-1", "velocity"), ("m s-2", "acceleration"))
AXES = 'the axes along which it is given: "global", "body" for those of the body itself, or the name of a body'


# ---------------------------------------------------------------- of a body
class _Seen(QuantityType):
    body: str = name_of("bodies", description="the name of the body")
    relative_to: str = name_of(
        "bodies", "ground", default="ground", description='the name of the body from which it is seen, or "ground"'
    )

    def to_model(self, names: Names) -> Quantity:
        body, base = names.bodies[self.body], names.bodies[self.relative_to]
        frames = {**names.bodies, "body": body, "global": GROUND}
        named: str | None = getattr(self, "frame", None)
        frame = base if named is None else frames[named]
        return Quantity(self.name, self.type, (body,), relative_to=base, frame=frame)

    def faults(self) -> Iterator[Problem]:
        if self.relative_to == self.body != "ground":
            yield Problem("relative_to", "is the body itself", "name another one, or leave it out", self.body)


def _along(quantity: Quantity, view: View, v: so3.Vec3) -> so3.Vec3:
    """A global vector along the axes of the quantity's frame."""
    return so3.rotate_back(view[quantity.frame].R, v)


@QUANTITIES.add
class PointQuantity(_Seen):
    """The position, velocity or acceleration of a point of a body."""

    type: Literal["point"]
    point: Vec3 = Field(default=ZERO, description="the point in m, 3 numbers in the body's frame")
    derivative: Literal[0, 1, 2] = Field(default=0, description="0 (position), 1 (velocity) or 2 (acceleration)")
    frame: str | None = name_of(
        "bodies", "global", "body", default=None, description=f"{AXES} (or omit it: those of relative_to)"
    )

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return quantity.derivative

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        units, what = OF_POINT[quantity.derivative]
        return (Part("", units, f"{what} of a point", vector=True, frame=quantity.frame),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        """Position of the point as seen from a body, or a derivative of it, there; then along the axes of the frame."""

        def seen(at: View) -> so3.Vec3:
            base = at[quantity.relative_to]
            return so3.rotate_back(base.R, so3.subtract(at[quantity.bodies[0]].point(quantity.point), base.r))

        if quantity.derivative == 0:
            p = seen(view)
        else:
            accelerations = observed.accelerations if observed and quantity.derivative == 2 else None
            x, y, z = (lift(jet) for jet in seen(kinematics.moving(view, accelerations)))
            p = (x.b, y.b, z.b) if quantity.derivative == 1 else (x.c, y.c, z.c)
        if quantity.frame == quantity.relative_to:
            return p
        return _along(quantity, view, so3.rotate(view[quantity.relative_to].R, p))

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        derivative = table.get("derivative")
        return Quantity(
            str(table.get("name")), str(table["type"]), (0,), derivative=int(derivative) if derivative in (1, 2) else 0
        )

    def to_model(self, names: Names) -> Quantity:
        return replace(super().to_model(names), point=vec3(self.point), derivative=self.derivative)


@QUANTITIES.add
class JointQuantity(QuantityType):
    """The coordinates of a joint, and their rates."""

    reads_coordinates: ClassVar[bool] = True

    type: Literal["joint"]
    joint: str = name_of("joints", description="the name of the joint")

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        kinds = joints.JOINTS.values()
        rates = {x.rate for kind in kinds for x in kind.freedoms()} | {x.together[1] for x in kinds if x.together}
        return VELOCITY if component.partition(".")[0] in rates else POSITION

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        joint = model.joints[quantity.joint]
        kind, of = joints.JOINTS[joint.type], f"of the joint {joint.name}"
        if kind.together is not None:
            second = joint.bodies[-1] if joint.bodies else GROUND
            named = zip(kind.together, ("rad", "rad s-1"), strict=True)
            return tuple(Part(x, unit, f"{x.replace('_', ' ')} {of}", vector=True, frame=second) for x, unit in named)
        named_each = [pair for x in kind.freedoms() for pair in ((x.name, x.unit), (x.rate, x.rate_unit))]
        return tuple(Part(x, unit, f"{x} {of}") for x, unit in named_each)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        kind = joints.JOINTS[model.joints[quantity.joint].type]
        every = [Coordinate(quantity.joint, x.name) for x in kind.freedoms()]
        both = [(joints.coordinate(model, which, view), cls._rate(model, which, view)) for which in every]
        return tuple(x for each in (zip(*both, strict=True) if kind.together is not None else both) for x in each)

    @staticmethod
    def _rate(model: Model, which: Coordinate, view: View) -> Any:
        """The rate of a coordinate: exactly 0 where dry friction sticks."""
        rate: Any = joints.rate(model, which, view)
        for force in model.forces:
            if force.coordinate == which:
                rate = view.modes.get(("friction", force.name), Mode()).sliding(rate)
        return rate

    @classmethod
    def instead(cls, model: Model, quantity: Quantity) -> tuple[str, str]:
        why = "of which rates are a part, and this law may depend on positions only"
        return why, f"give it joints = [{show(model.joints[quantity.joint].name)}] instead"

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        return _sketch_of_joint(table, joints)

    def to_model(self, names: Names) -> Quantity:
        return Quantity(self.name, self.type, joint=names.joints[self.joint])


def _sketch_of_joint(table: Mapping[str, Any], joints: Sequence[str]) -> Quantity | None:
    name = str(table.get("joint"))
    return (
        Quantity(str(table.get("name")), str(table["type"]), (0,), joint=joints.index(name)) if name in joints else None
    )


@QUANTITIES.add
class RotationError(_Seen):
    """The rotation from a target to a body."""

    singular: ClassVar[tuple[str, ...]] = ("angle",)
    rotations: ClassVar[tuple[str, ...]] = ("target",)

    type: Literal["rotation_error"]
    target: Rotation = Field(
        default=[1.0, 0.0, 0.0, 0.0],
        description="the rotation to be reached, in the frame of relative_to: a quaternion [w, x, y, z], a 3x3 matrix, "
        '{axis, angle}, {euler = "ZYX", angles} or {rotation_vector}, in rad',
    )

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return POSITION

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (
            Part("", "rad", "rotation vector from the target to the body", vector=True, frame=quantity.bodies[0]),
            Part("angle", "rad", "angle between the target and the body"),
        )

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        """log(R_target^T R), R_target being given in the frame of `relative_to`; the same along the axes of both."""
        assert quantity.target is not None
        target = so3.multiply(view[quantity.relative_to].R, quantity.target)
        e = so3.log(so3.multiply(so3.transpose(target), view[quantity.bodies[0]].R))
        return (*e, sqrt(so3.dot(e, e) + SQUARE_FLOOR))

    def to_model(self, names: Names) -> Quantity:
        return replace(super().to_model(names), target=rotation_of(self.target))


@QUANTITIES.add
class AngularVelocity(_Seen):
    """The angular velocity of a body."""

    type: Literal["angular_velocity"]
    frame: str = name_of("bodies", "global", "body", default="body", description=AXES)

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return VELOCITY

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (Part("", "rad s-1", "angular velocity", vector=True, frame=quantity.frame),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        body, base = view[quantity.bodies[0]], view[quantity.relative_to]
        if quantity.frame == quantity.bodies[0] and quantity.relative_to == GROUND:
            return tuple(body.w)
        return _along(quantity, view, so3.subtract(so3.rotate(body.R, body.w), so3.rotate(base.R, base.w)))


# ---------------------------------------------------------------- of joints and drivers
@QUANTITIES.add
class Reaction(QuantityType):
    """The force and torque of a joint on its second body, at its point."""

    type: Literal["reaction"]
    joint: str = name_of("joints", description="the name of the joint")
    frame: Literal["first", "second", "global"] = Field(
        default="global", description='the axes: "first" or "second" for those of the joint\'s bodies, or "global"'
    )

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return OBSERVED

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        of = f"of the joint {model.joints[quantity.joint].name} on its second body"
        return (
            Part("force", "N", f"force {of}, at its point", vector=True, frame=quantity.frame),
            Part("torque", "N m", f"torque {of}, about its point", vector=True, frame=quantity.frame),
        )

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        assert observed is not None
        first = 3 * quantity.joint
        loads = (observed.forces[first : first + 3], observed.torques[first : first + 3])
        return tuple(row for x, y, z in loads for row in _along(quantity, view, (x, y, z)))

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        return _sketch_of_joint(table, joints)

    def to_model(self, names: Names) -> Quantity:
        ends = names.ends(self.joint)
        frames = {"first": ends[0], "second": ends[-1], "global": GROUND}
        return Quantity(self.name, self.type, joint=names.joints[self.joint], frame=frames[self.frame])


@QUANTITIES.add
class DriverEffort(QuantityType):
    """The force or torque of a driver."""

    type: Literal["driver_effort"]
    driver: str = name_of("drivers", description="the name of the driver")

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return OBSERVED

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        driver = model.drivers[quantity.driver]
        said = f"effort of the driver {driver.name}"
        kind = type_of(driver)
        rows = kind.kinds(driver)
        frame = driver.bodies[-1] if kind.effort_in_body(driver) else GROUND
        units = "N" if rows[0] == "m" else "N m"
        return (Part("", units, said, vector=True, frame=frame) if len(rows) == 3 else Part("", units, said),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        assert observed is not None
        return tuple(observed.efforts[quantity.driver])

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        name = str(table.get("driver"))
        if name not in drivers:
            return None
        return Quantity(str(table.get("name")), str(table["type"]), (0,), driver=drivers.index(name))

    def to_model(self, names: Names) -> Quantity:
        return Quantity(self.name, self.type, driver=names.drivers[self.driver])


# ---------------------------------------------------------------- of everything
About = Annotated[
    Annotated[Literal["mass_centre"], Tag("name")] | Annotated[Vec3, Tag("point")],
    Discriminator(lambda value: "name" if isinstance(value, str) else "point"),
]


@QUANTITIES.add
class Momentum(QuantityType):
    """The linear and angular momentum of bodies."""

    type: Literal["momentum"]
    bodies: Annotated[list[str], Field(min_length=1)] | None = name_of(
        "bodies", default=None, description="the names of the bodies that count (or omit it: all)"
    )
    about: About = Field(
        default=ZERO,
        description='the point in m, global frame, about which moments are taken, or "mass_centre"',
    )

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return VELOCITY

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        about = "the mass centre" if quantity.about is None else "a point"
        return (
            Part("linear", "kg m s-1", "linear momentum", vector=True, frame=GROUND),
            Part("angular", "kg m2 s-1", f"angular momentum about {about}", vector=True, frame=GROUND),
        )

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        linear: so3.Vec3 = kinematics.AT_REST
        moment: so3.Vec3 = kinematics.AT_REST
        mass, about, moving = 0.0, quantity.about, kinematics.AT_REST
        for i in quantity.bodies:
            linear = so3.axpy(model.bodies[i].mass, view[i].v, linear)
            moment = so3.axpy(model.bodies[i].mass, view[i].r, moment)
            mass = mass + model.bodies[i].mass
        if about is None:
            about, moving = so3.scale(1.0 / mass, moment), so3.scale(1.0 / mass, linear)
        angular: so3.Vec3 = kinematics.AT_REST
        for i in quantity.bodies:
            m = view[i]
            spin = so3.rotate(m.R, kinematics.inertia_times(model.bodies[i].inertia, m.w))
            arm, v = so3.subtract(m.r, about), so3.subtract(m.v, moving)
            angular = so3.add(angular, so3.axpy(model.bodies[i].mass, so3.cross(arm, v), spin))
        return (*linear, *angular)

    def to_model(self, names: Names) -> Quantity:
        every = [name for name, index in names.bodies.items() if index != GROUND]
        bodies = tuple(names.bodies[name] for name in (every if self.bodies is None else self.bodies))
        return Quantity(self.name, self.type, bodies, about=None if isinstance(self.about, str) else vec3(self.about))


@QUANTITIES.add
class Expression(QuantityType):
    """A formula of quantities, parameters, tables and the time."""

    example: ClassVar[Mapping[str, Any]] = {"value": "2*t"}

    type: Literal["expression"]
    value: Timed = Field(description=f"a number {OR_FORMULA}, of other quantities and of parameters")
    units: str = Field(default="1", description='the units of the value as a text, such as "N m"')

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return POSITION

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (Part("", quantity.units, "formula"),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        return (evaluate(model, quantity.value, view, observed),)

    def to_model(self, names: Names) -> Quantity:
        return Quantity(self.name, self.type, value=timed(self.value), units=self.units)
