"""What is drawn of contacts: the outline of a plane, and a circle for each round part."""

from collections.abc import Iterator
from math import cos, pi, sin

import numpy as np

from lienumba.mechanics.mechanism.model import Contact, Vec3

SIDES = 16  # of a circle
PLANE = 0.5  # half an edge of a plane, relative to the size of the mechanism
Outline = tuple[int, list[Vec3]]  # a body (index), and corners of a closed line on it


def outlines(contact: Contact, size: float) -> Iterator[Outline]:
    """Closed lines in the frames of the bodies; size: of the mechanism (m)."""
    (first, second), (own, other) = contact.bodies, contact.points
    if contact.normal is not None:
        yield second, _ring(other, contact.normal, PLANE * size * 2.0**0.5, 4)
    numbers = contact.numbers
    radii = numbers.get("radius", numbers.get("first_radius")), numbers.get("second_radius")
    for body, point, radius in zip((first, second), (own, other), radii, strict=True):
        if radius is not None:
            yield body, _ring(point, contact.axis or (0.0, 1.0, 0.0), float(radius), SIDES)


def _ring(centre: Vec3, axis: Vec3, radius: float, sides: int) -> list[Vec3]:
    """The corners of a regular polygon across an axis."""
    n = np.array(axis, float) / np.linalg.norm(axis)
    x = np.cross(n, np.eye(3)[int(abs(n).argmin())])
    x /= np.linalg.norm(x)
    y, turns = np.cross(n, x), [2.0 * pi * (k + 0.5) / sides for k in range(sides)]
    corners = [np.array(centre, float) + radius * (cos(u) * x + sin(u) * y) for u in turns]
    return [(float(a), float(b), float(c)) for a, b, c in corners]
