"""Limits and contacts at the start: nothing may begin beyond a stop, or inside of another body."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from lienumba.errors import Problem
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Contact, Limit, Model
from lienumba.mechanics.system.constraints import largest

CLOSE = 1e-9  # relative to the size, up to which two things touch
ONE = 1.0  # rad or m: the size of a coordinate near 0


@dataclass(frozen=True)
class _Depth:
    """of: what one begins beyond; depth, size: of one run, or (runs,)."""

    of: Limit | Contact
    depth: Any
    size: Any

    @property
    def refused(self) -> Any:
        """Whether it is more than touching."""
        return self.depth > CLOSE * self.size


def problems_of_stops(model: Model, now: Instant) -> list[Problem]:
    """Of one run (floats) at its start."""
    found = [x for x in _depths(model, now) if isfinite(x.depth) and x.refused]
    return [
        _beyond(model, x.of, now, x.depth) if isinstance(x.of, Limit) else _inside(model, x.of, x.depth) for x in found
    ]


def begin_beyond(model: Model, now: Instant, runs: int) -> np.ndarray:
    """Which runs begin beyond a stop or inside of another body (runs,)."""
    bad = np.zeros(runs, bool)
    for x in _depths(model, now):
        bad |= x.refused
    return bad


def _depths(model: Model, now: Instant) -> Iterator[_Depth]:
    for limit in model.limits:
        view = still(now, model.joints[limit.coordinate.joint].bodies)
        depth = limit.side * (limit.value - joints.coordinate(model, limit.coordinate, view))
        yield _Depth(limit, depth, largest([ONE, limit.value]))
    for contact in model.contacts:
        a, b = (still(now, contact.bodies)[i] for i in contact.bodies)
        sizes = [*(x for p in contact.points for x in p), *contact.numbers.values(), *a.r, *b.r]
        yield _Depth(contact, -CONTACTS[contact.type].gap(contact, a, b), largest(sizes))


def _beyond(model: Model, limit: Limit, now: Instant, beyond: float) -> Problem:
    which, (name, _, key) = limit.coordinate, limit.name.rpartition(".")
    x = joints.coordinate(model, which, still(now, model.joints[which.joint].bodies))
    unit = joints.freedom(model, which).unit
    rule = f"the {which.kind} of {model.joints[which.joint].name} begins at {x:.6g} {unit}, {beyond:.3g} {unit} beyond"
    return Problem(f"model.limits.{name}.{key}", rule, "correct one of the two", limit.value)


def _inside(model: Model, contact: Contact, depth: float) -> Problem:
    names = [model.bodies[i].name if i >= 0 else "ground" for i in contact.bodies]
    rule = f"{names[0]} and {names[1]} overlap by {depth:.3g} m at the start"
    return Problem(f"model.contacts.{contact.name}", rule, "move one of them apart, or correct its points and normal")
