"""The types of contacts: where each comes closest."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from lienumba.groups import so3
from lienumba.keys.conversions import vec3
from lienumba.keys.facts import Unit
from lienumba.keys.types import Positive
from lienumba.mechanics.elements.contacts.base import CONTACTS, ContactType, OnPlane, Radius, WithAxis
from lienumba.mechanics.elements.contacts.geometry import Place, height, unit
from lienumba.mechanics.mechanism.kinematics import Motion
from lienumba.mechanics.mechanism.model import GROUND, Contact, Number, Vec3
from lienumba.numerics.operations import is_zero

Radii = Annotated[list[Positive], Field(min_length=2, max_length=2)]


@CONTACTS.add
class PointPlane(OnPlane):
    words = "a point of the first body on a plane of the second"

    type: Literal["point_plane"]

    @staticmethod
    def place(contact: Contact, a: Motion, b: Motion) -> Place:
        assert contact.normal is not None
        gap, point, _ = height(a, contact.points[0], b, contact.points[1], contact.normal)
        return Place(gap, point, contact.normal)


@CONTACTS.add
class SpherePlane(Radius, OnPlane):
    words = "a sphere about a point of the first body on a plane of the second"
    example: ClassVar[dict[str, Any]] = {"radius": 0.1}

    type: Literal["sphere_plane"]

    @staticmethod
    def place(contact: Contact, a: Motion, b: Motion) -> Place:
        assert contact.normal is not None
        above, centre, up = height(a, contact.points[0], b, contact.points[1], contact.normal)
        radius = contact.numbers["radius"]
        return Place(above - radius, so3.axpy(-radius, up, centre), contact.normal)

    @classmethod
    def turns(cls, contact: Contact) -> bool:
        return contact.bodies[1] != GROUND or not all(map(is_zero, contact.points[0]))


@CONTACTS.add
class SphereSphere(ContactType):
    words = "two spheres, each about a point of its body"
    example: ClassVar[dict[str, Any]] = {"radii": [0.1, 0.2]}

    type: Literal["sphere_sphere"]
    radii: Annotated[Radii, Unit("m")] = Field(description="the two radii in m, above 0")

    def numbers(self) -> dict[str, Number]:
        return {"first_radius": self.radii[0], "second_radius": self.radii[1]}

    @staticmethod
    def place(contact: Contact, a: Motion, b: Motion) -> Place:
        centre = a.point(contact.points[0])
        up, distance = unit(so3.subtract(centre, b.point(contact.points[1])))
        first, second = contact.numbers["first_radius"], contact.numbers["second_radius"]
        return Place(distance - first - second, so3.axpy(-first, up, centre), so3.rotate_back(b.R, up))

    @classmethod
    def turns(cls, contact: Contact) -> bool:
        own = (p for body, p in zip(contact.bodies, contact.points, strict=True) if body != GROUND)
        return not all(is_zero(x) for p in own for x in p)


@CONTACTS.add
class CylinderPlane(WithAxis, Radius, OnPlane):
    words = "the edge of a round disc of the first body, a wheel, on a plane of the second"
    example: ClassVar[dict[str, Any]] = {"radius": 0.1, "axis": [0.0, 1.0, 0.0]}
    leaps: ClassVar[bool] = True  # to the other side, as the disc lies flat

    type: Literal["cylinder_plane"]

    @staticmethod
    def place(contact: Contact, a: Motion, b: Motion) -> Place:
        """The lowest point of the edge: down is the normal without its part along the axis."""
        assert contact.normal is not None
        assert contact.axis is not None
        above, centre, up = height(a, contact.points[0], b, contact.points[1], contact.normal)
        axis, radius = so3.rotate(a.R, contact.axis), contact.numbers["radius"]
        down, steepness = unit(so3.axpy(-so3.dot(up, axis), axis, up))
        return Place(above - radius * steepness, so3.axpy(-radius, down, centre), contact.normal)


@CONTACTS.add
class CapsulePlane(WithAxis, Radius, OnPlane):
    """Both ends are spheres, each a point of contact."""

    words = "a capsule about a point of the first body on a plane of the second: its two ends are spheres"
    example: ClassVar[dict[str, Any]] = {"radius": 0.1, "axis": [0.0, 1.0, 0.0], "length": 0.3}

    type: Literal["capsule_plane"]
    length: Annotated[Positive, Unit("m")] = Field(
        description="the distance in m of the centres of its two ends, above 0"
    )

    def parts(self) -> Iterator[tuple[str, str, Vec3]]:
        """Two spheres."""
        half, axis = 0.5 * self.length, unit(vec3(self.axis))[0]
        for name, sign in (("first", -1.0), ("second", 1.0)):
            x, y, z = so3.axpy(sign * half, axis, vec3(self.points[0]))
            yield f"{self.name}.{name}", "sphere_plane", (x, y, z)

    place = staticmethod(SpherePlane.place)
