"""Rolling without slip: a law of velocities, which no law of positions can say."""

from lienumba.laws import Vector


def rolls(disc, *, radius):
    """The point of the rim that is lowest has no velocity. z of the body frame is the axis of the disc."""
    n = disc.to_global((0, 0, 1))
    down = Vector(n.x * n.z, n.y * n.z, n.z * n.z - 1.0)
    lowest = disc.to_body(radius * down / down.norm())
    return disc.velocity_of(lowest)
