"""A cam: what it has to fulfil is one function that vanishes where the follower touches it."""

from lienumba.laws import atan2, cos


def touches(cam, follower, *, radius, lift, lobes):
    """The follower's tip is at r(a) = radius + lift (1 - cos(lobes a)) / 2 from the cam's axis, a seen from the cam."""
    tip = cam.to_body(follower.position - cam.position)
    angle = atan2(tip.z, tip.x)
    return tip.norm() - (radius + 0.5 * lift * (1.0 - cos(lobes * angle)))
