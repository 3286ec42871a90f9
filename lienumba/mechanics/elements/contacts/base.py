"""What types of contacts have in common. A type is one class: its keys, and where its two bodies come closest.

A contact is a unilateral constraint: its gap stays at least 0, with Newton's restitution and Coulomb's friction. With a
stiffness it is a force law instead (`compliant`), of the same geometry.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Discriminator, Field, Tag, WithJsonSchema

from lienumba.errors import Problem
from lienumba.keys.conversions import undirected, vec3
from lienumba.keys.facts import Unit
from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import (
    NAME_RULE,
    WRITTEN,
    ZERO,
    BodyPair,
    Name,
    NotNegative,
    Positive,
    Section,
    Two,
    Vec3,
)
from lienumba.mechanics.elements.contacts.geometry import Place, slip, unit
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.kinematics import Motion
from lienumba.numerics.number import Vector
from lienumba.words import show

VELOCITY = 1e-3  # m/s
REST = (
    "(or omit it: 0.001 sqrt(a L), where a is the acceleration that presses, of lengths gravity at least, and L the "
    "size of the smaller body, or 1 rad)"
)
Share = Annotated[
    float,
    Field(strict=True, allow_inf_nan=False, ge=0, le=1),
    WithJsonSchema({**WRITTEN, "minimum": 0, "maximum": 1}),
]


class Coefficients(Section):
    """Of Coulomb friction that sticks and slides."""

    static: NotNegative = Field(description="the coefficient up to which it sticks, at least 0")
    kinetic: NotNegative = Field(description="the coefficient with which it slides, at least 0 and at most static")


AnyFriction = Annotated[
    Annotated[NotNegative, Tag("number")] | Annotated[Coefficients, Tag("coefficients")],
    Discriminator(lambda value: "coefficients" if isinstance(value, dict | Coefficients) else "number"),
]


class ContactType(Section):
    """A contact, as a scenario describes it.

    words: what it is, for the documents; example: keys of its own, for tests; leaps: whether where it touches may leap
    to another place, while both bodies hardly turn.
    """

    words: ClassVar[str] = ""
    example: ClassVar[dict[str, Any]] = {}
    leaps: ClassVar[bool] = False

    name: Name = Field(description=NAME_RULE)
    if TYPE_CHECKING:
        type: str
    bodies: BodyPair = Field(description='the names of the two bodies that may touch; the fixed world is "ground"')
    points: Annotated[Two, Unit("m")] = Field(
        default=[ZERO, ZERO], description="two points in m, each with 3 numbers in the frame of its own body"
    )
    restitution: Share = Field(
        default=0.0, description="the restitution, from 0 (nothing comes back of an impact) to 1 (as fast as it came)"
    )
    friction: AnyFriction = Field(
        default=0.0, description="the coefficient of friction, at least 0, or { static = ..., kinetic = ... }"
    )
    rest_speed: Annotated[NotNegative | None, Unit("m s-1")] = Field(
        default=None,
        description=f"the speed in m/s below which a rebound is none, at least 0 {REST}",
    )
    stiffness: Annotated[Positive | None, Unit("N m-1")] = Field(
        default=None, description="the stiffness in N/m of a contact that yields, above 0 (or omit it: it is rigid)"
    )
    dissipation: Annotated[NotNegative | None, Unit("s m-1")] = Field(
        default=None, description="the damping in s/m of a contact with stiffness, at least 0 (or omit it: 0)"
    )
    velocity: Annotated[Positive | None, Unit("m s-1")] = Field(
        default=None,
        description="the speed in m/s at which a contact with stiffness begins to slide, above 0 (or omit it: "
        f"{VELOCITY:g})",
    )

    # ---------------------------------------------------------------- geometry
    @staticmethod
    def place(contact: m.Contact, a: Motion, b: Motion) -> Place:
        """Where the two bodies come closest."""
        raise NotImplementedError

    @classmethod
    def gap(cls, contact: m.Contact, a: Motion, b: Motion) -> Any:
        """The distance of the two surfaces (m), below 0 where they overlap."""
        return cls.place(contact, a, b).gap

    @classmethod
    def turns(cls, contact: m.Contact) -> bool:
        """Whether its gap may change as one of its bodies turns."""
        return True

    @classmethod
    def rates(cls, contact: m.Contact, a: Motion, b: Motion) -> Vector:
        """The velocity (m/s) of the first body against the second where they touch, along two tangents."""
        return slip(cls.place(contact, a, b), a, b)

    # ---------------------------------------------------------------- from a scenario to a model
    @property
    def compliant(self) -> bool:
        """Whether it yields."""
        return self.stiffness is not None

    def parts(self) -> Iterator[tuple[str, str, m.Vec3]]:
        """Of each of its points of contact: the name, the type, and the point of the first body."""
        yield self.name, self.type, vec3(self.points[0])

    def numbers(self) -> dict[str, m.Number]:
        """Those that its geometry finds in `contact.numbers`."""
        return {}

    def to_model(self, names: Names) -> Iterator[m.Contact]:
        """Its points of contact, as kernels see them."""
        first, second = (names.bodies[name] for name in self.bodies)
        static, kinetic = (
            (self.friction.static, self.friction.kinetic)
            if isinstance(self.friction, Coefficients)
            else (self.friction, self.friction)
        )
        normal = getattr(self, "normal", None)
        for name, kind, point in self.parts():
            axis = getattr(self, "axis", None) if "axis" in CONTACTS[kind].model_fields else None
            yield m.Contact(
                name,
                kind,
                (first, second),
                (point, vec3(self.points[1])),
                normal=None if normal is None else unit(vec3(normal))[0],
                axis=None if axis is None else unit(vec3(axis))[0],
                numbers=self.numbers(),
                restitution=self.restitution,
                static=static,
                kinetic=kinetic,
                rest_speed=self.rest_speed,
            )

    def faults(self) -> Iterator[Problem]:
        if isinstance(self.friction, Coefficients) and self.friction.static < self.friction.kinetic:
            rule = f"must be at least kinetic = {show(self.friction.kinetic)}"
            yield Problem("friction.static", rule, "exchange the two, or give one number", self.friction.static)
        rigid, yielding = ("restitution", "rest_speed"), ("dissipation", "velocity")
        for key in self.model_fields_set.intersection(rigid if self.compliant else yielding):
            if getattr(self, key) == type(self).model_fields[key].default:
                continue
            if self.compliant:
                rule, remedy = "is of a rigid contact, and this one has a stiffness", "give dissipation instead"
            else:
                rule, remedy = "is of a contact with stiffness, and this one is rigid", "give stiffness, too"
            yield Problem(key, rule, f"leave it out, or {remedy}", getattr(self, key))
        for key in type(self).model_fields.keys() & {"normal", "axis"}:
            yield from undirected(key, getattr(self, key))


CONTACTS: Registry[type[ContactType]] = Registry("contact", literal("type"))


class OnPlane(ContactType):
    """Of something of the first body with a plane of the second."""

    normal: Vec3 = Field(
        default=[0.0, 0.0, 1.0],
        description="the normal of the plane, 3 numbers in the frame of the second body, towards the first",
    )


class Radius(ContactType):
    radius: Annotated[Positive, Unit("m")] = Field(description="the radius in m, above 0")

    def numbers(self) -> dict[str, m.Number]:
        return {"radius": self.radius}


class WithAxis(ContactType):
    axis: Vec3 = Field(description="the direction of its axis, 3 numbers in the frame of the first body")
