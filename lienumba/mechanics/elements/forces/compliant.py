"""Contacts that yield, as force laws."""

from collections.abc import Iterator

from lienumba.keys.types import Timed
from lienumba.mechanics.elements.contacts import CONTACTS, ContactType
from lienumba.mechanics.elements.contacts.base import VELOCITY
from lienumba.mechanics.elements.contacts.geometry import at_rest, slid
from lienumba.mechanics.elements.contacts.yielding import damping, energy, friction
from lienumba.mechanics.elements.forces.base import BESIDE, ForceLaw, Given
from lienumba.mechanics.elements.forces.numbers import number
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Force
from lienumba.numerics.number import Number, Vector

CONTACT = "contact"


class Yielding(ForceLaw):
    """Along the gap, and along both tangents."""

    stiffness: Timed = number("the stiffness in {}", "N m-1", required=True)
    dissipation: Timed = number("the damping in {}", "s m-1", in_potential=False)
    velocity: Timed = number("the speed in {} at which sliding begins", "m s-1", default=VELOCITY, in_potential=False)

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        contact = given.force.contact
        assert contact is not None
        kind, (a, b) = CONTACTS[contact.type], (view[i] for i in contact.bodies)
        now = (at_rest(a), at_rest(b))
        return kind.gap(contact, a, b), *slid(kind.place(contact, *now), now, a, b)

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        return energy(given["stiffness"], c[0])

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        contact, push = given.force.contact, conservative[0]
        assert contact is not None
        beside = damping(push, given["dissipation"], rates[0])
        return beside, *friction(contact, push + beside, rates[1:3], given["velocity"])


BESIDE[CONTACT] = Yielding


def forces_of(contact: ContactType, names: Names) -> Iterator[Force]:
    """What a contact that yields is to the model."""
    given = {key: getattr(contact, key) for key in Yielding.numbers()}
    for part in contact.to_model(names):
        numbers = {key: Yielding.default(key) if x is None else x for key, x in given.items()}
        yield Force(part.name, CONTACT, part.bodies, numbers=numbers, contact=part)
