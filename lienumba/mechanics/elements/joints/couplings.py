"""Joints that tie two coordinates: second = ratio * first + offset."""

from math import pi
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from lienumba.errors import BadValueError
from lienumba.keys.types import BodyPair, CoordinateKind, Number
from lienumba.mechanics.elements.joints.base import JOINTS, JointType, Own, coordinate
from lienumba.mechanics.elements.joints.keys import Angle, Displacement, OneAxis, Placed, TurningRotor
from lienumba.mechanics.elements.joints.pairs import Cylindrical, Revolute
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Coordinate, Joint, Model, Start
from lienumba.mechanics.mechanism.moves import Wind
from lienumba.numerics.number import Vector


def not_zero(remedy: str) -> AfterValidator:
    """The rule that a number is not 0."""

    def check(x: float) -> float:
        if x == 0.0:
            raise BadValueError("must not be 0", remedy)
        return x

    return AfterValidator(check)


class Coupling(JointType):
    """A joint of two joints; its bodies are those of both."""

    words, leaves = "tie two coordinates", "ties two coordinates of other joints: second = ratio * first + offset"
    row_kinds = "m"  # or "r", as the second coordinate has it

    joints: BodyPair = Field(description="the names of the two joints whose coordinates it couples")
    coordinates: Annotated[list[CoordinateKind], Field(min_length=2, max_length=2)] | None = Field(
        default=None,
        description='which coordinate of each of the two joints: "angle" or "displacement" '
        "(or omit them where a joint has only one)",
    )
    ratio: Annotated[Number, not_zero("give second = ratio * first + offset"), Own("1", -1.5)] = Field(
        description="the ratio, not 0: second = ratio * first + offset"
    )
    offset: Annotated[Number | None, Own("1", 0.0)] = Field(
        default=None, description="the offset in rad or m (or omit it: as at the start)"
    )

    @classmethod
    def equations(cls, model: Model, index: int, view: View) -> Vector:
        joint = model.joints[index]
        return (_difference(model, joint, view) - joint.numbers["offset"],)

    @classmethod
    def kinds(cls, joint: Joint) -> str:
        return "r" if _pair(joint)[1].kind == "angle" else "m"

    def ends(self, names: Names) -> tuple[int, ...]:
        return tuple(dict.fromkeys(i for name in self.joints for i in names.ends(name)))

    def to_model(self, names: Names) -> Joint:
        first, second = (names.coordinate(*x) for x in zip(self.joints, self.coordinates or (None, None), strict=True))
        return Joint(self.name, self.type, self.ends(names), coordinates=(first, second), numbers=self.numbers())

    @classmethod
    def unit(cls, key: str, coupled: tuple[str, ...]) -> str:
        if key not in ("ratio", "offset"):
            return super().unit(key, coupled)
        first, second = ("rad" if kind == "angle" else "m" for kind in coupled)
        return second if key == "offset" else "1" if first == second else f"{second} {first}-1"

    @classmethod
    def open_rows(cls, model: Model, start: Start, index: int) -> int:
        joint = model.joints[index]
        free = [c for c in _pair(joint) if c.kind == "angle" and start.joints[c.joint].references is None]
        return 1 if joint.numbers["offset"] is None or free else 0

    @classmethod
    def at_start(cls, model: Model, index: int, view: View) -> dict[str, m.Number]:
        return {"offset": _difference(model, model.joints[index], view)}

    @classmethod
    def missed(cls, joint: Joint, view: View, size: float, turning: bool) -> float:
        return size  # of angles, not of their sines

    @classmethod
    def unmet(cls, turning: bool) -> tuple[str, str]:
        return "its coordinates do not have its ratio and offset", "offset"

    @classmethod
    def parting(cls, turning: bool) -> str:
        return "its coordinates leave its ratio"

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        return {**super().example_keys(), "joints": ["base", "elbow"]}

    @classmethod
    def example(cls) -> dict[str, Any]:
        base, elbow = Revolute.example_keys(), Revolute.example_keys()
        base |= {"name": "base", "bodies": ["ground", "first"], "points": [[0.0, 0.0, 1.3], [0.0, 0.0, 0.3]]}
        data = super().example()
        first, second = data["model"]["bodies"]
        del first["velocity"], second["guess"]
        first["angular_velocity"] = [0.0, 0.7, 0.0]
        data["model"]["joints"] = [base, elbow | {"name": "elbow"}, cls.example_keys()]
        return data


def _pair(joint: Joint) -> tuple[Coordinate, Coordinate]:
    assert joint.coordinates is not None
    return joint.coordinates


def _difference(model: Model, joint: Joint, view: View) -> m.Number:
    """second - ratio * first."""
    first, second = _pair(joint)
    return coordinate(model, second, view) - joint.numbers["ratio"] * coordinate(model, first, view)


@JOINTS.add
class Screw(Placed, OneAxis, Angle, Displacement, TurningRotor):
    # A cylindrical joint whose displacement follows its own angle; the start decides where it begins.
    words, leaves = "a pitch per turn", "the angle, and a displacement of one pitch for each turn"
    row_kinds = Cylindrical.row_kinds + "m"
    moves = (Wind(),)
    coordinate_kinds = ("angle", "displacement")

    type: Literal["screw"]
    pitch: Annotated[Number, not_zero("for a joint that only turns use a revolute joint"), Own("m", 0.2)] = Field(
        description="the displacement in m per turn, not 0; negative for a left-hand thread"
    )

    @classmethod
    def equations(cls, model: Model, index: int, view: View) -> Vector:
        joint = model.joints[index]
        a, b = (view[i] for i in joint.bodies)
        tie = cls._difference(model, index, view) - joint.numbers["offset"]
        return (*Cylindrical.residual(joint, a, b), tie)

    def numbers(self) -> dict[str, m.Number]:
        return {"pitch": self.pitch, "offset": None}

    @classmethod
    def at_start(cls, model: Model, index: int, view: View) -> dict[str, m.Number]:
        return {"offset": cls._difference(model, index, view)}

    @staticmethod
    def _difference(model: Model, index: int, view: View) -> m.Number:
        angle, displacement = (coordinate(model, Coordinate(index, kind), view) for kind in Screw.coordinate_kinds)
        return displacement - model.joints[index].numbers["pitch"] * (0.5 / pi) * angle


@JOINTS.add
class Gear(Coupling):
    type: Literal["gear"]


@JOINTS.add
class Coupler(Coupling):
    type: Literal["coupler"]
