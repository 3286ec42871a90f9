"""Joints that events engage and that can never close, whatever the bodies do."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from lienumba.errors import Problem
from lienumba.groups import so3
from lienumba.mechanics.elements.events import ENGAGE
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Joint, Model
from lienumba.mechanics.system import constraints, rank
from lienumba.mechanics.system.switches import permanent
from lienumba.words import listed

APART = 1e-6  # relative to the lengths around: what is nearer may be rounding


def problems_of_captures(model: Model, now: Instant) -> list[Problem]:
    """Of one run (floats) at its start."""
    return [problem for event in model.events if event.action == ENGAGE.name for problem in _of(model, now, event)]


def _of(model: Model, now: Instant, event: m.Event) -> Iterator[Problem]:
    joint, place = model.joints[event.joint], f"events.{event.name}.joint"
    between, least = _reach(model, event.joint)
    if least > 0.0:
        rule = f"can never close: with {listed(between)} its points stay {least:.3g} m apart"
        yield Problem(place, rule, "correct its points, or those of these joints", joint.name)
    elif not model.drivers and _held(model, now, event.joint):
        names = [model.bodies[i].name if i >= 0 else "ground" for i in joint.bodies]
        rule = f"can never close: it is open, and {names[0]} and {names[1]} cannot move against each other"
        yield Problem(place, rule, "correct its points, or give a joint that lets them move", joint.name)


def _held(model: Model, now: Instant, index: int) -> bool:
    """Whether a joint is open between two bodies that cannot move against each other: a weld where they are says
    nothing that the permanent constraints do not. In singular positions bodies seem to move more freely, never less."""
    lasting, joint = permanent(model), model.joints[index]
    joints, (a, b) = list(lasting.joints), (now.motion(i) for i in joint.bodies)
    joints[index] = replace(joints[index], active=True)
    closed = replace(lasting, joints=tuple(joints))
    rows = constraints.rows_of(closed)[index]
    gaps, (reach, far, _) = constraints.residual(closed, now)[rows], constraints.sizes(closed, now)
    if not any(abs(gap) > APART * (x + y) for gap, x, y in zip(gaps, reach[rows], far[rows], strict=True)):
        return False
    place = so3.rotate_back(a.R, so3.subtract(b.r, a.r))
    joints[index] = Joint(joint.name, "fixed", joint.bodies, (place, (0.0, 0.0, 0.0)), (_axes(a.R), _axes(b.R)))
    welded = replace(lasting, joints=tuple(joints))
    return rank.rank_of(welded, now).rank == rank.rank_of(lasting, now).rank


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
    ways: dict[int, tuple[list[str], list[float], m.Vec3]] = {
        first: ([], [], begin)
    }  # joints, lengths, where it enters
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
    return names, least if least > APART * max(lengths) else 0.0


def _points(joint: Joint) -> tuple[m.Vec3, m.Vec3]:
    assert joint.points is not None
    return joint.points


def _between(p: m.Vec3, q: m.Vec3) -> float:
    return float(np.linalg.norm(np.subtract(p, q)))


def _axes(R: Sequence[m.Number]) -> m.Frame:
    """The global axes, in the frame of a body."""
    return (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
