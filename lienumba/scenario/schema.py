"""The scenario as data: which keys exist, their types, units and defaults.

What one key says about another (names, step and interval, rotations) is in `checks`. A key's description is
also the remedy in its error messages, which read "give <description>".
"""

from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from lienumba.sweep.distributions import Distribution, Normal, Uniform

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
Count = Annotated[int, Field(strict=True, ge=1)]
Vec3 = Annotated[list[Number], Field(min_length=3, max_length=3)]
Matrix3 = Annotated[list[Vec3], Field(min_length=3, max_length=3)]
MOST_RUNS = 2**32  # the samplers' labels have 32 bits
NAME = r"^[A-Za-z]\w*$"
Name = Annotated[str, Field(strict=True, pattern=NAME)]

Method = Literal["euler", "midpoint", "heun", "kutta3", "rk4", "rk38"]
EulerSequence = Literal[
    "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ"
]  # fmt: skip
Variable = Literal[
    "position", "rotation", "velocity", "angular_velocity", "joint_force", "joint_torque", "multiplier",
    "energy", "kinetic_energy", "potential_energy", "work", "energy_residual", "position_violation",
    "velocity_violation", "position_iterations", "velocity_iterations",
]  # fmt: skip
VARIABLES: tuple[str, ...] = get_args(Variable)


class Section(BaseModel):
    model_config = ConfigDict(extra="forbid")


class AxisAngle(Section):
    axis: Vec3 = Field(description="the axis of rotation: 3 numbers, not all 0")
    angle: Number = Field(description="the angle in rad")


class Euler(Section):
    euler: EulerSequence = Field(description='the sequence of intrinsic axes, such as "ZYX"')
    angles: Vec3 = Field(description="the 3 angles in rad, in the order of the sequence")


class RotationVector(Section):
    rotation_vector: Vec3 = Field(description="axis times angle: 3 numbers in rad")


Quaternion = Annotated[list[Number], Field(min_length=4, max_length=4)]


# The forms of a rotation that are tables, by any of their keys.
ROTATION_TABLES = {
    key: form
    for form, section in (("axis_angle", AxisAngle), ("euler_angles", Euler), ("vector", RotationVector))
    for key in section.model_fields
}


def rotation_form(value: Any) -> str | None:
    """Which of the five forms a rotation is written in; None if it is none of them."""
    if isinstance(value, list):
        return "matrix" if any(isinstance(row, list) for row in value) else "quaternion"
    keys = type(value).model_fields if isinstance(value, Section) else value if isinstance(value, dict) else ()
    return next((ROTATION_TABLES[key] for key in keys if key in ROTATION_TABLES), None)


Rotation = Annotated[
    Annotated[Quaternion, Tag("quaternion")]
    | Annotated[Matrix3, Tag("matrix")]
    | Annotated[AxisAngle, Tag("axis_angle")]
    | Annotated[Euler, Tag("euler_angles")]
    | Annotated[RotationVector, Tag("vector")],
    Discriminator(rotation_form),
]


def inertia_form(value: Any) -> str | None:
    """Which of the three forms an inertia is written in; None if it is none of them."""
    if not isinstance(value, list):
        return None
    if any(isinstance(row, list) for row in value):
        return "tensor"
    return "moments" if len(value) <= 3 else "elements"


Inertia = Annotated[
    Annotated[Vec3, Tag("moments")]
    | Annotated[list[Number], Field(min_length=6, max_length=6), Tag("elements")]
    | Annotated[Matrix3, Tag("tensor")],
    Discriminator(inertia_form),
]


class Body(Section):
    name: Name = Field(description='the name: a letter, then letters, digits or "_"')
    mass: Positive = Field(description="the mass in kg, above 0")
    inertia: Inertia = Field(
        description="the inertia in kg m^2 about the mass centre in the body frame: 3 principal moments, "
        "the 6 elements xx yy zz xy xz yz of the tensor, or its 3x3 matrix"
    )
    position: Vec3 | None = Field(
        default=None,
        description="the mass centre in m, global frame: 3 numbers (or omit it: solved from the joints)",
    )
    rotation: Rotation | None = Field(
        default=None,
        description="the rotation from the body to the global frame: a quaternion [w, x, y, z], a 3x3 "
        'matrix, {axis, angle}, {euler = "ZYX", angles} or {rotation_vector}, in rad '
        "(or omit it: solved from the joints)",
    )
    velocity: Vec3 | None = Field(
        default=None,
        description="the velocity of the mass centre in m/s, global frame: 3 numbers "
        "(or omit it: solved from the joints)",
    )
    angular_velocity: Vec3 | None = Field(
        default=None,
        description="the angular velocity in rad/s, body frame: 3 numbers (or omit it: solved from the joints)",
    )


class Joint(Section):
    name: Name = Field(description='the name: a letter, then letters, digits or "_"')
    type: Literal["spherical", "distance"] = Field(
        description='the type: "spherical" (a common point) or "distance" (a massless rod between two points)'
    )
    bodies: Annotated[list[str], Field(min_length=2, max_length=2)] = Field(
        description='the names of the two bodies it joins; the fixed world is "ground"'
    )
    points: Annotated[list[Vec3], Field(min_length=2, max_length=2)] = Field(
        description="two points in m, each with 3 numbers in the frame of its own body"
    )
    length: Positive | None = Field(
        default=None,
        description="the distance of the two points in m, above 0 (or omit it: as at the start)",
    )


class ModelSection(Section):
    gravity: Vec3 = Field(default=[0.0, 0.0, -9.81], description="the acceleration of gravity in m/s^2: 3 numbers")
    bodies: Annotated[list[Body], Field(min_length=1)] = Field(
        description="at least one body, each as [[model.bodies]]"
    )
    joints: list[Joint] = Field(default=[], description="the joints, each as [[model.joints]]")


class Integrator(Section):
    method: Method = Field(default="rk4", description="the Runge-Kutta method: " + ", ".join(get_args(Method)))
    step: Positive = Field(description="the time step in s, above 0")
    end_time: Positive = Field(description="the simulated time in s, above 0")


class Projection(Section):
    position: Literal["local", "none"] = Field(
        default="local", description='"local" (back onto the joints after each step) or "none"'
    )
    velocity: Literal["mass", "identity", "none"] = Field(
        default="mass", description='the weight of the correction: "mass" or "identity", or "none"'
    )
    tolerance: Positive = Field(default=1e-11, description="the largest violation left over, in m, above 0")
    max_iterations: Count = Field(default=10, description="a whole number of iterations, at least 1")


class Output(Section):
    every: Positive | None = Field(default=None, description="the interval between stored times in s, above 0")
    times: Annotated[list[Number], Field(min_length=1)] | None = Field(
        default=None, description="the stored times in s, ascending, from 0 to integrator.end_time"
    )
    variables: list[Variable] = Field(
        default=list(get_args(Variable)),
        description="names of the variables to store: " + ", ".join(VARIABLES),
    )


class Sweep(Section):
    runs: Annotated[int, Field(strict=True, ge=1, le=MOST_RUNS)] = Field(
        default=1, description="a whole number of runs, at least 1"
    )
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = Field(
        default=0, description="a whole number from 0 to 2^63 - 1"
    )
    sampler: Literal["random"] = Field(default="random", description='"random"')
    vary: dict[str, Distribution] = Field(
        default={},
        description='what varies: "path" = { distribution = "normal", std = ... } '
        'or { distribution = "uniform", low = ..., high = ... }',
    )


class ScenarioData(Section):
    """A whole scenario, as the TOML file has it."""

    title: Annotated[str, Field(strict=True)] = Field(default="", description="a text")
    model: ModelSection = Field(description="the section [model] with its bodies and joints")
    integrator: Integrator = Field(description="the section [integrator] with step and end_time")
    projection: Projection = Field(default_factory=Projection, description="the section [projection]")
    output: Output = Field(default_factory=Output, description="the section [output]")
    sweep: Sweep = Field(default_factory=Sweep, description="the section [sweep]")


# The class behind each place of the file; list indices are left out, "*" is any path of sweep.vary.
SECTIONS: dict[tuple[str, ...], type[BaseModel]] = {
    (): ScenarioData,
    ("model",): ModelSection,
    ("model", "bodies"): Body,
    ("model", "bodies", "rotation", "axis_angle"): AxisAngle,
    ("model", "bodies", "rotation", "euler_angles"): Euler,
    ("model", "bodies", "rotation", "vector"): RotationVector,
    ("model", "joints"): Joint,
    ("integrator",): Integrator,
    ("projection",): Projection,
    ("output",): Output,
    ("sweep",): Sweep,
    ("sweep", "vary", "*", "normal"): Normal,
    ("sweep", "vary", "*", "uniform"): Uniform,
}
