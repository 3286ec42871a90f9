"""Contacts that yield, as force laws: Hunt and Crossley's normal force and a friction that is smooth about rest.

At the depth d = max(0, -gap) the normal force is N = k d max(0, 1 + D d') [@hunt1975], of which k d has a potential,
k d^2/2. The friction against the sliding velocity w has the size N mu(|w|),
mu(s) = tanh(s/v) (kinetic + (static - kinetic) exp(-(s/(10 v))^2)).
"""

from collections.abc import Iterator

from lienumba.keys.types import Timed
from lienumba.mechanics.elements.contacts.base import CONTACTS, VELOCITY, ContactType
from lienumba.mechanics.elements.contacts.geometry import SQUARE_FLOOR, at_rest, slid
from lienumba.mechanics.elements.forces.base import BESIDE, ForceLaw, Given, quadratic
from lienumba.mechanics.elements.forces.numbers import number
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Force
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import exp, maximum, sqrt, tanh

CONTACT = "contact"
FADES = 10.0  # of the speed at which sliding begins, that at which little is left of sticking


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
        return quadratic(given["stiffness"], maximum(0.0, -c[0]))

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        contact, push = given.force.contact, conservative[0]
        assert contact is not None
        damped = push * maximum(-1.0, -(given["dissipation"] * rates[0]))
        w, speed = rates[1:3], given["velocity"]
        sliding = sqrt(w[0] * w[0] + w[1] * w[1] + SQUARE_FLOOR)
        faded = sliding / (FADES * speed)
        coefficient = contact.kinetic + (contact.static - contact.kinetic) * exp(-(faded * faded))
        friction = coefficient * tanh(sliding / speed) * (push + damped) / sliding
        return damped, -(friction * w[0]), -(friction * w[1])


BESIDE[CONTACT] = Yielding


def forces_of(contact: ContactType, names: Names) -> Iterator[Force]:
    """What a contact that yields is to the model."""
    given = {key: x for key in Yielding.numbers() if (x := getattr(contact, key)) is not None}
    for part in contact.to_model(names):
        yield Force(part.name, CONTACT, part.bodies, numbers=given, contact=part)
