"""Rolling without slip on the plane z = 0: an ellipsoid, or a wheel, which is one without thickness."""

from lienumba.laws import Vector, sqrt


def rolls(body, *, a, b, c, up=0.0):
    """The point that touches the plane has no velocity. a, b, c: half axes (m) along the axes of the body; up: how far
    the centre of the ellipsoid is above the mass centre, along z of the body (m)."""
    n = body.to_body((0, 0, 1))
    square = Vector(a * a * n.x, b * b * n.y, c * c * n.z)
    down = square / sqrt(square.dot(n))
    return body.velocity_of(Vector(-down.x, -down.y, up - down.z))
