"""The values of a scenario's keys: numbers, vectors, rotations, inertias, numbers that may vary in time.

A key's description is also the remedy in its error messages, which read "give <description>".
"""

from collections.abc import Iterator
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, WithJsonSchema

from lienumba.errors import Problem
from lienumba.keys.formulas import LARGEST, checked

# In the file a number may be a formula of parameters; it is a number before it comes here (see `parameters`).
WRITTEN: dict[str, Any] = {"type": ["number", "string"]}
Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST), WithJsonSchema(WRITTEN)]
Positive = Annotated[
    float,
    Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST),
    WithJsonSchema({**WRITTEN, "exclusiveMinimum": 0}),
]
NotNegative = Annotated[
    float,
    Field(strict=True, allow_inf_nan=False, ge=0, le=LARGEST),
    WithJsonSchema({**WRITTEN, "minimum": 0}),
]
Count = Annotated[int, Field(strict=True, ge=1)]
Vec3 = Annotated[list[Number], Field(min_length=3, max_length=3)]
Matrix3 = Annotated[list[Vec3], Field(min_length=3, max_length=3)]
NAME = r"^[A-Za-z]\w*$"
Name = Annotated[str, Field(strict=True, pattern=NAME, max_length=100)]  # of which names of variables are made
NAME_RULE = 'the name: a letter, then letters, digits or "_"'


class Section(BaseModel):
    model_config = ConfigDict(extra="forbid", defer_build=True)

    def faults(self) -> Iterator[Problem]:
        """What its keys say against one another; places are its keys."""
        return iter(())


# A number, or a formula of the time t.
Timed = Annotated[
    Annotated[Number, Tag("number")] | Annotated[str, AfterValidator(checked), Tag("formula")],
    Discriminator(lambda value: "formula" if isinstance(value, str) else "number"),
]
Timed2 = Annotated[list[Timed], Field(min_length=2, max_length=2)]
Timed3 = Annotated[list[Timed], Field(min_length=3, max_length=3)]
OR_FORMULA = '(or a formula of t in quotes, such as "0.3*sin(2*t)")'
ZERO: Any = [0.0, 0.0, 0.0]

# What elements act on, and where.
BodyPair = Annotated[list[str], Field(min_length=2, max_length=2)]
Two = Annotated[list[Vec3], Field(min_length=2, max_length=2)]
CoordinateKind = Literal["angle", "displacement"]
COORDINATE_KINDS: tuple[str, ...] = get_args(CoordinateKind)
Axes = Literal["global", "body"]
AXES: Any = Field(default="global", description='the axes of the value: "global" or "body"')


class AxisAngle(Section):
    axis: Vec3 = Field(description="the axis of rotation: 3 numbers, not all 0")
    angle: Number = Field(description="the angle in rad")


EulerSequence = Literal[
    "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ"
]  # fmt: skip


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


def rotation_form(value: object) -> str | None:
    """Which of the five forms a rotation is written in; None if it is none of them."""
    if isinstance(value, list):
        return "matrix" if any(isinstance(row, list) for row in value) else "quaternion"
    keys = type(value).model_fields if isinstance(value, Section) else value if isinstance(value, dict) else ()
    return next((ROTATION_TABLES[key] for key in keys if key in ROTATION_TABLES), None)


def rotation_keys(value: object) -> Any:
    """A rotation as its class has it, whatever its numbers are; it is known to have one of the five forms."""
    if not isinstance(value, dict):
        return value
    section = next(section for section in (AxisAngle, Euler, RotationVector) if value.keys() <= {*section.model_fields})
    return section.model_construct(**value)


Rotation = Annotated[
    Annotated[Quaternion, Tag("quaternion")]
    | Annotated[Matrix3, Tag("matrix")]
    | Annotated[AxisAngle, Tag("axis_angle")]
    | Annotated[Euler, Tag("euler_angles")]
    | Annotated[RotationVector, Tag("vector")],
    Discriminator(rotation_form),
]


def inertia_form(value: object) -> str | None:
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
