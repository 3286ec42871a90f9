"""Drivers and forces as data: one class per kind, with the keys that it has. Every number may be a formula of t."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from lienumba.keys.types import (
    NAME_RULE,
    BodyPair,
    CoordinateKind,
    Name,
    Number,
    Positive,
    Section,
    Timed,
    Timed3,
    Two,
    Vec3,
)

OrFormula = '(or a formula of t in quotes, such as "0.3*sin(2*t)")'
ZERO: Any = [0.0, 0.0, 0.0]


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


class _OfTwo(_Named):
    bodies: BodyPair = Field(description='the names of the two bodies; the fixed world is "ground"')
    points: Two = Field(description="two points in m, each with 3 numbers in the frame of its own body")


Frame = Literal["global", "body"]
FRAME: Any = Field(default="global", description='the axes of the value: "global" or "body"')


# ---------------------------------------------------------------- drivers
class JointDriver(_OfJoint):
    value: Timed | None = Field(default=None, description=f"the angle in rad or displacement in m {OrFormula}")
    rate: Timed | None = Field(default=None, description=f"its rate in rad/s or m/s, instead of value {OrFormula}")


class PointDriver(_OfPoint):
    motion: Literal["point"]
    value: Timed3 = Field(description=f"the position of the point in m, global frame: 3 numbers {OrFormula}")


class OrientationDriver(_OfBody):
    motion: Literal["orientation"]
    value: Timed3 = Field(description=f"the rotation vector from body to global in rad: 3 numbers {OrFormula}")


class AngularVelocityDriver(_OfBody):
    motion: Literal["angular_velocity"]
    frame: Frame = FRAME
    value: Timed3 = Field(description=f"the angular velocity in rad/s: 3 numbers {OrFormula}")


DRIVERS: dict[str, type[Section]] = {
    "joint": JointDriver, "point": PointDriver, "orientation": OrientationDriver,
    "angular_velocity": AngularVelocityDriver,
}  # fmt: skip


def driver_form(value: Any) -> str | None:
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


# ---------------------------------------------------------------- forces
class SpringDamper(_OfTwo):
    type: Literal["spring_damper"]
    stiffness: Timed = Field(default=0.0, description=f"the stiffness in N/m {OrFormula}")
    damping: Timed = Field(default=0.0, description=f"the damping in N s/m {OrFormula}")
    free_length: Timed | None = Field(
        default=None, description=f"the length in m without force {OrFormula} (or omit it: the length at the start)"
    )


class PointForce(_OfPoint):
    type: Literal["force"]
    frame: Frame = FRAME
    value: Timed3 = Field(description=f"the force in N: 3 numbers {OrFormula}")


class Torque(_OfBody):
    type: Literal["torque"]
    frame: Frame = FRAME
    value: Timed3 = Field(description=f"the torque in N m: 3 numbers {OrFormula}")


class TorsionSpring(_OfJoint):
    type: Literal["torsion_spring"]
    stiffness: Timed = Field(default=0.0, description=f"the stiffness in N m/rad {OrFormula}")
    damping: Timed = Field(default=0.0, description=f"the damping in N m s/rad {OrFormula}")
    free_angle: Timed = Field(default=0.0, description=f"the angle in rad without torque {OrFormula}")


class Actuator(_OfJoint):
    type: Literal["actuator"]
    value: Timed = Field(default=0.0, description=f"the force in N or torque in N m {OrFormula}")
    stiffness: Timed = Field(default=0.0, description=f"the gain towards the target in N/m or N m/rad {OrFormula}")
    damping: Timed = Field(default=0.0, description=f"the gain towards the target's rate {OrFormula}")
    target: Timed = Field(default=0.0, description=f"the angle in rad or displacement in m to reach {OrFormula}")
    limit: Timed | None = Field(default=None, description=f"the largest force in N or torque in N m {OrFormula}")


class Friction(_OfJoint):
    type: Literal["friction"]
    viscous: Timed = Field(default=0.0, description=f"the viscous coefficient in N s/m or N m s/rad {OrFormula}")
    coulomb: Timed = Field(default=0.0, description=f"the sliding force in N or torque in N m {OrFormula}")
    velocity: Timed = Field(
        default=1e-3, description=f"the speed in m/s or rad/s at which sliding sets in, above 0 {OrFormula}"
    )


class EndStop(_OfJoint):
    type: Literal["end_stop"]
    lower: Timed | None = Field(default=None, description=f"the lower stop in m or rad {OrFormula}")
    upper: Timed | None = Field(default=None, description=f"the upper stop in m or rad {OrFormula}")
    stiffness: Timed = Field(description=f"the stiffness in N/m or N m/rad {OrFormula}")
    damping: Timed = Field(default=0.0, description=f"the damping in contact in N s/m or N m s/rad {OrFormula}")


class Bushing(_OfTwo):
    type: Literal["bushing"]
    stiffness: Timed3 = Field(default=ZERO, description=f"the stiffness in N/m: 3 numbers {OrFormula}")
    damping: Timed3 = Field(default=ZERO, description=f"the damping in N s/m: 3 numbers {OrFormula}")
    rotational_stiffness: Timed3 = Field(
        default=ZERO, description=f"the rotational stiffness in N m/rad: 3 numbers {OrFormula}"
    )
    rotational_damping: Timed3 = Field(
        default=ZERO, description=f"the rotational damping in N m s/rad: 3 numbers {OrFormula}"
    )


class Drag(_OfPoint):
    type: Literal["drag"]
    linear: Timed = Field(default=0.0, description=f"the linear coefficient in N s/m {OrFormula}")
    quadratic: Timed = Field(default=0.0, description=f"the quadratic coefficient in N s^2/m^2 {OrFormula}")


class PointMassGravity(_OfTwo):
    type: Literal["point_mass_gravity"]
    points: Two = Field(
        default=[ZERO, ZERO], description="two points in m, each with 3 numbers in the frame of its own body"
    )
    mu: Timed = Field(description=f"the gravitational parameter of the first body in m^3/s^2 {OrFormula}")


class PythonForce(_Named):
    type: Literal["python"]
    function: str = Field(description='the file and the function in it: "arm.py:pd"')
    bodies: list[str] = Field(default=[], description='the names of the bodies that it gets, in order, or "ground"')
    joints: list[str] = Field(default=[], description="the names of the joints that it gets behind the bodies")
    returns: Literal["loads", "potential"] = Field(
        default="loads", description='"loads" (forces, torques and efforts) or "potential" (an energy in J)'
    )
    parameters: dict[str, Timed] = Field(
        default={}, description=f"numbers that it gets by name {OrFormula}: {{ kp = 40, kd = 2 }}"
    )
    states: dict[str, Number] = Field(default={}, description="its states and their initial values: { integral = 0 }")
    every: Positive | None = Field(
        default=None, description="the interval in s at which it is sampled, above 0 (or omit it: at every time)"
    )


Force = Annotated[
    SpringDamper | PointForce | Torque | TorsionSpring | Actuator | Friction | EndStop | Bushing | Drag
    | PointMassGravity | PythonForce,
    Field(discriminator="type"),
]  # fmt: skip
FORCES: dict[str, type[Section]] = {
    "spring_damper": SpringDamper, "force": PointForce, "torque": Torque, "torsion_spring": TorsionSpring,
    "actuator": Actuator, "friction": Friction, "end_stop": EndStop, "bushing": Bushing, "drag": Drag,
    "point_mass_gravity": PointMassGravity, "python": PythonForce,
}  # fmt: skip
