"""The forces of contacts that yield: Hunt and Crossley's normal force and a friction that is smooth about rest.

At the depth d = max(0, -gap) the normal force is N = k d max(0, 1 + D d') [@hunt1975], of which k d has a potential,
k d^2/2. The friction against the sliding velocity w has the size N mu(|w|),
mu(s) = tanh(s/v) (kinetic + (static - kinetic) exp(-(s/(10 v))^2)).
"""

from lienumba.mechanics.elements.contacts.geometry import SQUARE_FLOOR
from lienumba.mechanics.mechanism.model import Contact
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import exp, maximum, sqrt, tanh

FADES = 10.0  # of the speed at which sliding begins, that at which little is left of sticking


def energy(stiffness: Number, gap: Number) -> Number:
    """The potential energy (J)."""
    depth = maximum(0.0, -gap)
    return (0.5 * stiffness) * (depth * depth)


def damping(push: Number, dissipation: Number, rate: Number) -> Number:
    """What the normal force (N) is besides; push: what it is at rest; rate: of the gap. Together they never pull."""
    beside: Number = push * maximum(-1.0, -(dissipation * rate))
    return beside


def friction(contact: Contact, push: Number, w: Vector, speed: Number) -> Vector:
    """Along both tangents (N), at this normal force; speed: at which sliding begins (m/s)."""
    sliding = sqrt(w[0] * w[0] + w[1] * w[1] + SQUARE_FLOOR)
    faded = sliding / (FADES * speed)
    coefficient = contact.kinetic + (contact.static - contact.kinetic) * exp(-(faded * faded))
    size = coefficient * tanh(sliding / speed) * push / sliding
    return -(size * w[0]), -(size * w[1])
