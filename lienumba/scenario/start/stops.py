"""Limits and contacts at the start: nothing may begin beyond a stop, or inside of another body."""

from math import isfinite

from lienumba.errors import Problem
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Contact, Limit, Model
from lienumba.mechanics.system.constraints import largest

CLOSE = 1e-9  # relative to the size, up to which two things touch
ONE = 1.0  # m or rad: the size of what has none


def problems_of_stops(model: Model, now: Instant) -> list[Problem]:
    """Of one run (floats) at its start."""
    found = [_beyond(model, limit, now) for limit in model.limits]
    found += [_inside(model, contact, now) for contact in model.contacts]
    return [problem for problem in found if problem is not None]


def _beyond(model: Model, limit: Limit, now: Instant) -> Problem | None:
    which = limit.coordinate
    view = still(now, model.joints[which.joint].bodies)
    x = float(joints.coordinate(model, which, view))
    beyond = limit.side * (limit.value - x)
    if not beyond > CLOSE * max(abs(limit.value), ONE):
        return None
    name, _, key = limit.name.rpartition(".")
    unit = joints.freedom(model, which).unit
    rule = f"the {which.kind} of {model.joints[which.joint].name} begins at {x:.6g} {unit}, {beyond:.3g} {unit} beyond"
    return Problem(f"model.limits.{name}.{key}", rule, "correct one of the two", limit.value)


def _inside(model: Model, contact: Contact, now: Instant) -> Problem | None:
    a, b = (still(now, contact.bodies)[i] for i in contact.bodies)
    gap = float(CONTACTS[contact.type].gap(contact, a, b))
    sizes = [*(x for p in contact.points for x in p), *contact.numbers.values(), *a.r, *b.r]
    if not isfinite(gap) or not -gap > CLOSE * max(float(largest(sizes)), ONE * CLOSE):
        return None
    names = [model.bodies[i].name if i >= 0 else "ground" for i in contact.bodies]
    rule = f"{names[0]} and {names[1]} overlap by {-gap:.3g} m at the start"
    return Problem(f"model.contacts.{contact.name}", rule, "move one of them apart, or correct its points and normal")
