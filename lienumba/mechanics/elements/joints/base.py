"""What a type of joints says of itself. `JOINTS` knows the types by name.

A type is one class: its fields are its keys, its `residual` is its mathematics. Whatever else is asked of a joint has
an answer here, which a type overrides where its own is another.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import asin
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from lienumba.keys.conversions import vec3
from lienumba.keys.facts import Unit, facts, is_positive
from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import NAME_RULE, Name, Section
from lienumba.mechanics.elements.joints import parts
from lienumba.mechanics.elements.joints.freedoms import BY_KIND, Freedom
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.kinematics import Instant, Motion, View, moving, still
from lienumba.mechanics.mechanism.model import Coordinate, Joint, JointStart, Model, Number, Start, Vec3
from lienumba.mechanics.mechanism.moves import Move
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Vector

AXIS, RAIL, ROD, NOTHING = "axis", "rail", "rod", ""  # what is drawn of a joint beside its points


@dataclass(frozen=True)
class Own(Unit):
    """Of a key: a number that the residual finds in `joint.numbers`; where it is omitted, `at_start` says what it is.

    example: of its value; refused: what a value of 0 or below would be where it must be above 0: "which <refused>".
    """

    example: float = 1.0
    refused: str = "no joint of this type has"


class JointType(Section):
    """A type of joints, and one joint as a scenario has it."""

    words: ClassVar[str] = ""  # what it is, for the documents
    leaves: ClassVar[str] = ""  # what it leaves free
    row_kinds: ClassVar[str] = ""  # one letter for each row: "m" for a length, "r" for the sine of an angle
    vector: ClassVar[int] = 0  # how many of its first rows are components of a vector; those behind depend on no axes
    coordinate_kinds: ClassVar[tuple[str, ...]] = ()  # of "angle", "displacement": along which laws may act
    others: ClassVar[tuple[Freedom, ...]] = ()  # coordinates along which they may not
    together: ClassVar[tuple[str, str] | None] = None  # what these and their rates are called where they are a vector
    sides: ClassVar[int] = 0  # how many of its bodies have an axis
    rotor: ClassVar[str] = ""  # the coordinate with whose rate a rotor of it turns, if it may have one
    needs_axes: ClassVar[bool] = True  # where it may have any
    stays_parallel: ClassVar[bool] = False  # the axis of one body to that of the other
    same_way: ClassVar[tuple[int, ...]] = ()  # the axes (X, Y, Z) of both frames that shall not be half a turn apart
    has_points: ClassVar[bool] = False
    moves: ClassVar[tuple[Move, ...] | None] = None  # of its second body against its first, where they are few

    name: Name = Field(description=NAME_RULE)
    if TYPE_CHECKING:
        type: str
    active: Annotated[bool, Field(strict=True)] | None = Field(
        default=None, description="whether it holds from the start on: true or false (or omit it: true)"
    )
    locked: Annotated[bool, Field(strict=True)] | None = Field(
        default=None, description="whether it begins locked: true or false (or omit it: false)"
    )

    # ---------------------------------------------------------------- mathematics
    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        """What vanishes where the joint holds: one number for each row."""
        raise NotImplementedError

    @classmethod
    def equations(cls, model: Model, index: int, view: View) -> Vector:
        """The residual of joint number `index` of a model."""
        joint = model.joints[index]
        a, b = (view[i] for i in joint.bodies)
        return cls.residual(joint, a, b)

    @classmethod
    def kinds(cls, joint: Joint) -> str:
        """One letter for each row of a joint."""
        return cls.row_kinds

    @classmethod
    def freedoms(cls) -> tuple[Freedom, ...]:
        """All that it has, those first that its moves change each by itself."""
        return (*(BY_KIND[kind] for kind in cls.coordinate_kinds), *cls.others)

    @classmethod
    def independent(cls) -> tuple[Freedom, ...]:
        """Those that say all of where its second body is against its first; none where no moves do."""
        return cls.freedoms()[: sum(move.freedoms for move in cls.moves or ())]

    @classmethod
    def labelled(cls, name: str) -> dict[str, Freedom]:
        """The same of a joint of this name, as they are called among those of all joints: elbow, or piston.angle where
        the joint has several."""
        own = cls.independent()
        return {name if len(own) == 1 else f"{name}.{x.name}": x for x in own}

    @classmethod
    def reach(cls, joint: Joint) -> list[Number]:
        """Its lengths (m), with which violations compare, beside its points."""
        own = facts(cls, Own)
        lengths = [joint.numbers[key] for key in own if own[key].symbol == "m" and is_positive(cls, key)]
        return [x for x in lengths if x is not None]

    # ---------------------------------------------------------------- from a scenario to a model
    def ends(self, names: Names) -> tuple[int, ...]:
        """The bodies that it joins."""
        raise NotImplementedError

    def numbers(self) -> dict[str, Number]:
        """Those that the residual finds in `joint.numbers`; None where the start decides."""
        return {key: getattr(self, key) for key in facts(type(self), Own)}

    def to_model(self, names: Names) -> Joint:
        """The joint as kernels see it."""
        points = _pair(getattr(self, "points", None))
        armature = getattr(self, "armature", None)
        own = self.numbers()
        return Joint(
            self.name, self.type, self.ends(names), points, numbers=own, armature=0.0 if armature is None else armature
        )

    def start(self) -> JointStart:
        """What it says of the start."""
        given = dict(self)
        axes, axis, at = given.get("axes"), given.get("axis"), given.get("at")
        if axes is not None and len(axes) == 1:
            axes = [axes[0], [0.0, 0.0, 1.0]]  # of the first body alone
        if axis is not None:
            axis = _pair(axis) if isinstance(axis[0], list) else (vec3(axis),)
        return JointStart(
            axes=_pair(axes),
            references=_pair(given.get("references")),
            at=None if at is None else vec3(at),
            axis=axis,
            known={name: x for name, x in self.known().items() if x is not None},
        )

    def known(self) -> dict[str, Number | None]:
        """What its keys say of its coordinates and their rates at the start."""
        given, every = dict(self), self.freedoms()
        found = {name: given.get(name) for x in every for name in (x.name, x.rate)}
        for key, names in zip(self.together or (), ([x.name for x in every], [x.rate for x in every]), strict=False):
            found |= dict(zip(names, given[key], strict=True)) if given.get(key) is not None else {}
        return found

    @classmethod
    def unit(cls, key: str, coupled: tuple[str, ...]) -> str:
        """The unit of the numbers of a key; coupled: the kinds of the coordinates that it couples."""
        own = facts(cls, Unit)
        return own[key].symbol if key in own else "1"

    # ---------------------------------------------------------------- the start
    @classmethod
    def open_rows(cls, model: Model, start: Start, index: int) -> int:
        """How many of its last rows only the assembled start decides: one for each omitted number."""
        return sum(x is None for x in model.joints[index].numbers.values())

    @classmethod
    def at_start(cls, model: Model, index: int, view: View) -> dict[str, Number]:
        """Its omitted numbers as the bodies have them at the start."""
        return {}

    # ---------------------------------------------------------------- what to say of a start that does not fit
    @classmethod
    def meaningless(cls, joint: Joint) -> tuple[str, str] | None:
        """What is wrong with the numbers that the start decided, and the remedy."""
        return None

    @classmethod
    def missed(cls, joint: Joint, view: View, size: float, turning: bool) -> float:
        """The distance (m) or angle (rad) by which a residual of this size misses."""
        return asin(min(size, 1.0)) if turning else size

    @classmethod
    def unmet(cls, turning: bool) -> tuple[str, str]:
        """What is the case where it does not hold, and which of its keys to correct."""
        if turning:
            return "its axes do not fit together", "axes"
        meet = cls.row_kinds.startswith("mmm")
        return "its points do not meet" if meet else "its points are not where it allows them", "points"

    @classmethod
    def parting(cls, turning: bool) -> str:
        """What happens where velocities contradict it."""
        return "its bodies turn apart" if turning else "its points separate"

    # ---------------------------------------------------------------- pictures, documents, tests
    @classmethod
    def drawn(cls) -> str:
        """What is drawn of it beside its points."""
        return RAIL if "displacement" in cls.coordinate_kinds else AXIS if cls.sides else NOTHING

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        """The keys of one such joint between the bodies "first" and "second" of `example`."""
        own = {key: x.example for key, x in facts(cls, Own).items()}
        return {"name": "joint", "type": literal("type")(cls), **own}

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A small scenario, but for its steps; the last joint is of this type."""
        first = {
            "name": "first",
            "mass": 2.0,
            "inertia": [0.3, 0.4, 0.5],
            "position": [0.0, 0.0, 1.0],
            "rotation": [1.0, 0.0, 0.0, 0.0],
            "velocity": [0.1, 0.0, 0.2],
            "angular_velocity": [0.5, -0.4, 0.3],
        }
        second = {"name": "second", "mass": 1.0, "inertia": [0.1, 0.15, 0.2, 0.01, 0.0, 0.02],
                  "guess": {"position": [0.4, 0.1, 0.3], "velocity": [0.0, 0.3, 0.1],
                            "angular_velocity": [0.6, 1.0, -0.8]}}  # fmt: skip
        return {"model": {"bodies": [first, second], "joints": [cls.example_keys()]}}


def _pair(vectors: Sequence[Sequence[Number]] | None) -> tuple[Vec3, Vec3] | None:
    return None if vectors is None else (vec3(vectors[0]), vec3(vectors[1]))


JOINTS: Registry[type[JointType]] = Registry("joint", literal("type"))


def coordinate_kinds(type_of_joint: object) -> tuple[str, ...]:
    """The coordinates of a type of joints; none where there is no such type."""
    return JOINTS[str(type_of_joint)].coordinate_kinds if type_of_joint in JOINTS else ()


def coordinates(model: Model) -> list[Coordinate]:
    """Of all joints whose moves they are, in the order of the model."""
    return [Coordinate(j, x.name) for j, joint in enumerate(model.joints) for x in JOINTS[joint.type].independent()]


def named(coordinate: str) -> Freedom:
    """A coordinate by its name."""
    return next(x for kind in JOINTS.values() for x in kind.freedoms() if x.name == coordinate)


def freedom(model: Model, which: Coordinate) -> Freedom:
    """What a coordinate is."""
    return next(x for x in JOINTS[model.joints[which.joint].type].freedoms() if x.name == which.kind)


def coordinate(model: Model, which: Coordinate, view: View) -> Number:
    """The number (rad or m) that a coordinate of a joint is."""
    found, joint = freedom(model, which), model.joints[which.joint]
    a, b = (view[i] for i in joint.bodies)
    x = found.value(joint, a, b)
    return parts.counted(x, view.angles.get(which.counted, 0.0)) if found.counts else x


def in_motion(model: Model, which: Coordinate, view: View) -> Number:
    """What has its rate and acceleration in a view of bodies in motion: the number itself, unless that changes
    otherwise."""
    quasi, joint = freedom(model, which).quasi, model.joints[which.joint]
    return coordinate(model, which, view) if quasi is None else quasi(joint, *(view[i] for i in joint.bodies))


def rate(model: Model, which: Coordinate, view: View) -> Number:
    """Its rate (rad/s or m/s), as the bodies move."""
    found: Number = lift(in_motion(model, which, moving(view))).b
    return found


def gain(model: Model, which: Coordinate, along: Coordinate) -> Number | None:
    """How fast a coordinate grows with another one of the same joint, which its moves change by itself; None where it
    does not."""
    if which.joint != along.joint:
        return None
    joint = model.joints[which.joint]
    pitch = joint.numbers.get("pitch", 0.0)
    moves = [move for move in JOINTS[joint.type].moves or () if move.gain(which.kind, pitch) is not None]
    return moves[0].gain(along.kind, pitch) if moves else None


class _Asked(dict[int, Number]):
    """Of angles of which none is known: `joints` (indices), those that were asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.joints: set[int] = set()

    def get(self, joint: int, default: Any = None, /) -> Any:
        self.joints.add(joint)
        return default


def counted_angles(model: Model, now: Instant) -> set[int]:
    """The joints (indices) whose angle counts over all turns, because an equation of some joint asks for it."""
    asked = _Asked()
    for index, joint in enumerate(model.joints):
        if joint.code is None:
            JOINTS[joint.type].equations(model, index, replace(still(now, joint.bodies), angles=asked))
        else:
            asked.joints |= {j for j in joint.code.joints if "angle" in coordinate_kinds(model.joints[j].type)}
    return asked.joints
