"""Limits, contacts and joints that events engage, at the start.

Nothing may begin beyond a stop, or inside of another body. A joint that closes later must be able to close, and to
hold.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

from lienumba.errors import Problem
from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.events import ENGAGE
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Contact, Event, Frame, Joint, Limit, Model, Number, Vec3
from lienumba.mechanics.system import constraints, rank
from lienumba.mechanics.system.switches import permanent
from lienumba.words import listed

CLOSE = 1e-9  # relative to the size, up to which two things touch
ONE = 1.0  # rad or m: the size of a coordinate near 0
APART_RTOL = 1e-6  # relative to the lengths around: what is nearer may be roundoff
LOOKED_AT = 201  # times at which it is looked whether a driver moves


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
        yield _Depth(limit, depth, constraints.largest([ONE, limit.value]))
    for contact in model.contacts:
        a, b = (still(now, contact.bodies)[i] for i in contact.bodies)
        sizes = [*(x for p in contact.points for x in p), *contact.numbers.values(), *a.r, *b.r]
        yield _Depth(contact, -CONTACTS[contact.type].gap(contact, a, b), constraints.largest(sizes))


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


# ---------------------------------------------------------------- joints that events engage
def problems_of_captures(model: Model, now: Instant, end: float) -> list[Problem]:
    """Of one run (floats) at its start; end: of the run (s)."""
    engaging = [event for event in model.events if event.action == ENGAGE.name]
    return [problem for event in engaging for problem in _of_capture(model, now, event, end)]


def _of_capture(model: Model, now: Instant, event: Event, end: float) -> Iterator[Problem]:
    joint, place = model.joints[event.joint], f"events.{event.name}.joint"
    between, least = _reach(model, event.joint)
    if least > 0.0:
        rule = f"can never close: with {listed(between)} its points stay {least:.3g} m apart"
        yield Problem(place, rule, "correct its points, or those of these joints", joint.name)
    elif not model.drivers and _held(model, now, event.joint):
        names = [model.bodies[i].name if i >= 0 else "ground" for i in joint.bodies]
        rule = f"can never close: it is open, and {listed(names)} cannot move against each other"
        yield Problem(place, rule, "correct its points, or give a joint that lets them move", joint.name)
    for name in _driven(model, now, event.joint, end):
        rule = f"can never hold: model.drivers.{name} moves its bodies against each other all the time"
        yield Problem(place, rule, "let the driver come to rest, or let a force move them", joint.name)


def _driven(model: Model, now: Instant, index: int, end: float) -> Iterator[str]:
    """The driver that alone moves the bodies of a joint against each other, by what the joint would hold, and stands
    still at no time of the run."""
    lasting = permanent(model)
    if not _joins(model.joints[index]):
        return
    most = rank.rank_of(lasting, now).rank
    for n, driver in enumerate(model.drivers if rank.rank_of(_welded(model, now, index), now).rank == most else ()):
        left = replace(model, drivers=(*model.drivers[:n], *model.drivers[n + 1 :]))
        holds, welds = (rank.rank_of(x, now).rank for x in (_with(left, index), _welded(left, now, index)))
        if holds == welds == most == rank.rank_of(permanent(left), now).rank + 1:
            rows = constraints.rows_of(lasting)[len(lasting.joints) + n]
            rates = [
                constraints.time_rate(lasting, replace(now, t=float(t)))[rows] for t in np.linspace(0, end, LOOKED_AT)
            ]
            if any((x > 0).all() or (x < 0).all() for x in np.array(rates, float).T):
                yield driver.name


def _with(model: Model, index: int) -> Model:
    """What lasts, with a joint that is engaged."""
    lasting = permanent(model)
    joints = list(lasting.joints)
    joints[index] = replace(joints[index], active=True)
    return replace(lasting, joints=tuple(joints))


def _welded(model: Model, now: Instant, index: int) -> Model:
    """What lasts, with the bodies of a joint welded together where they are."""
    lasting, joint, (a, b) = permanent(model), model.joints[index], (now.motion(i) for i in model.joints[index].bodies)
    joints, place = list(lasting.joints), so3.rotate_back(a.R, so3.subtract(b.r, a.r))
    joints[index] = Joint(joint.name, "fixed", joint.bodies, (place, (0.0, 0.0, 0.0)), (_axes(a.R), _axes(b.R)))
    return replace(lasting, joints=tuple(joints))


def _held(model: Model, now: Instant, index: int) -> bool:
    """Whether a joint is open between two bodies that cannot move against each other: a weld where they are says
    nothing that the permanent constraints do not. In singular positions bodies seem to move more freely, never less."""
    closed = _with(model, index)
    rows = constraints.rows_of(closed)[index]
    gaps, (reach, far, _) = constraints.residual(closed, now)[rows], constraints.sizes(closed, now)
    if not any(abs(gap) > APART_RTOL * (x + y) for gap, x, y in zip(gaps, reach[rows], far[rows], strict=True)):
        return False
    stiff = _welded(model, now, index) if _joins(model.joints[index]) else closed
    return rank.rank_of(stiff, now).rank == rank.rank_of(permanent(model), now).rank


def _joins(joint: Joint) -> bool:
    """Whether a joint is one of two bodies, and not of other joints."""
    return len(joint.bodies) == 2


def _meets(joint: Joint) -> bool:
    """Whether a joint keeps its two points together."""
    moves = JOINTS[joint.type].moves if joint.code is None else None
    return moves is not None and joint.points is not None and not any("m" in move.letters for move in moves)


def _reach(model: Model, index: int) -> tuple[list[str], float]:
    """How far (m) from each other two points stay for which a joint is to close, by the lengths of the bodies between
    them: by how much the longest is longer than all others; and the joints between these bodies."""
    joint = model.joints[index]
    if not _meets(joint):
        return [], 0.0
    (first, last), (begin, end) = joint.bodies, _points(joint)
    ways: dict[int, tuple[list[str], list[float], Vec3]] = {first: ([], [], begin)}  # joints, lengths, where it enters
    waiting = [first]
    while waiting and last not in ways:
        body = waiting.pop(0)
        names, lengths, entry = ways[body]
        for other in model.joints:
            if other.active and not other.switched and _meets(other) and body in other.bodies:
                side, points = other.bodies.index(body), _points(other)
                beyond = other.bodies[1 - side]
                if beyond not in ways:
                    ways[beyond] = ([*names, other.name], [*lengths, _between(entry, points[side])], points[1 - side])
                    waiting.append(beyond)
    if last not in ways:
        return [], 0.0
    names, lengths, entry = ways[last]
    lengths = [*lengths, _between(entry, end)]
    least = 2.0 * max(lengths) - sum(lengths)
    return names, least if least > APART_RTOL * max(lengths) else 0.0


def _points(joint: Joint) -> tuple[Vec3, Vec3]:
    assert joint.points is not None
    return joint.points


def _between(p: Vec3, q: Vec3) -> float:
    return float(np.linalg.norm(np.subtract(p, q)))


def _axes(R: Sequence[Number]) -> Frame:
    """The global axes, in the frame of a body."""
    return (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
