"""From what a scenario says of a joint to its points and frames, and what else the start decides.

Frames: z is the axis, x the direction from which the angle counts, y = z x x. An exact 0 or 1 stays exact: whatever is
entered along coordinate axes remains structure.
"""

from dataclasses import replace
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.elements.drivers import POSITION, type_of
from lienumba.mechanics.elements.forces import law_of
from lienumba.mechanics.elements.joints import JOINTS, named
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, Motion, still
from lienumba.mechanics.mechanism.model import (
    GROUND,
    Coordinate,
    Counted,
    Force,
    Frame,
    Joint,
    JointStart,
    Model,
    Start,
    at_time,
    coordinate_of,
    reads_state,
)
from lienumba.mechanics.start.poses import Poses
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.operations import absolute, cos, sin, sqrt, where

X_AXIS, Y_AXIS, Z_AXIS = kinematics.UNIT
LIMIT = 0.9  # a direction nearer to an axis x than this cosine takes its perpendicular from y


# ---------------------------------------------------------------- what the scenario layer asks
def carried_by_start(start: Start, model: Model) -> set[int]:
    """The bodies on which a joint is placed in global coordinates: they keep the rotation that they start with."""
    return {
        i
        for joint, says in zip(model.joints, start.joints, strict=True)
        if says.at is not None or says.axis is not None
        for i in joint.bodies
        if i != GROUND
    }


def unplaced(model: Model, start: Start) -> list[tuple[int, int]]:
    """Joint and body (indices) where `at` or `axis` needs a position or rotation that the start does not give."""
    poses = Poses.of(start, carried_by_start(start, model))
    missing = []
    for j, (joint, says) in enumerate(zip(model.joints, start.joints, strict=True)):
        for i in joint.bodies:
            if i == GROUND:
                continue
            if (says.at is not None and not poses.placed[i]) or (says.axis is not None and poses.roots[i] != GROUND):
                missing.append((j, i))
    return missing


def without_zero(model: Model, start: Start) -> list[int]:
    """Joints (indices) whose angle is prescribed at the start while nothing says from where it counts."""
    poses = Poses.of(start, carried_by_start(start, model))
    return [
        j
        for j in sorted({coordinate_of(which).joint for which in angles_given(model, start)})
        if start.joints[j].references is None
        and JOINTS[model.joints[j].type].sides
        and not relative_known(model.joints[j], poses)
        and not _same_axes(model.joints[j], start.joints[j])
    ]


def angles_given(model: Model, start: Start) -> dict[Counted, Any]:
    """The angles at the start (rad) that are given, or driven."""
    angles: dict[Counted, Any] = {
        Coordinate(j, x.name).counted: says.known[x.name]
        for j, (joint, says) in enumerate(zip(model.joints, start.joints, strict=True))
        for x in JOINTS[joint.type].freedoms()
        if x.counts and x.name in says.known
    }
    for driver in model.drivers:
        c = driver.coordinate
        if c is None or c.kind != "angle" or reads_state(driver.value[0]):
            continue
        if type_of(driver).level(driver) == POSITION:
            angles.setdefault(c.joint, at_time(driver.value[0], 0.0))
    return angles


def with_driven(model: Model, start: Start) -> Start:
    """The start with the coordinates, and their rates, that drivers prescribe and joints do not say."""
    joints = list(start.joints)
    for driver in model.drivers:
        c = driver.coordinate
        if c is None or reads_state(driver.value[0]):
            continue
        driven, says = named(c.kind), joints[c.joint]
        x = lift(at_time(driver.value[0], Jet(0.0, 1.0)))
        found = {driven.name: x.a, driven.rate: x.b}
        found = found if type_of(driver).level(driver) == POSITION else {driven.rate: x.a}
        joints[c.joint] = replace(says, known=found | says.known)
    return replace(start, joints=tuple(joints))


# ---------------------------------------------------------------- directions
def unit(v: Any) -> Any:
    """The vector at length 1."""
    length = sqrt(so3.dot(v, v))
    return (v[0] / length, v[1] / length, v[2] / length)


def frame(z: Any, x: Any) -> Frame:
    """The frame with this axis (of length 1) and x as near as can be."""
    x = unit(so3.axpy(-so3.dot(x, z), z, x))
    return (x, so3.cross(z, x), z)


def any_frame(z: Any) -> Frame:
    """The same frame for the same axis, always."""
    near_x = absolute(z[0]) > LIMIT
    return frame(z, tuple(where(near_x, b, a) for a, b in zip(X_AXIS, Y_AXIS, strict=True)))


def _carried(first: Frame, z: Any, a: Motion, b: Motion) -> Frame:
    """The frame on the second side with this axis, and x of the first side where that is no axis of the second."""
    x, y = (so3.rotate_back(b.R, so3.rotate(a.R, v)) for v in first[:2])
    near = absolute(so3.dot(x, z)) > LIMIT
    return frame(z, tuple(where(near, d, c) for c, d in zip(x, y, strict=True)))


def relative_known(joint: Joint, poses: Poses) -> bool:
    """Whether the rotation of the joint's bodies relative to each other is given."""
    return len({poses.roots[i] if i != GROUND else GROUND for i in joint.bodies}) == 1


def _same_axes(joint: Joint, says: JointStart) -> bool:
    if says.axes is None or not JOINTS[joint.type].stays_parallel:
        return False
    first, second = (unit(axis) for axis in says.axes)
    return all(bool((a == b).all() if hasattr(a == b, "all") else a == b) for a, b in zip(first, second, strict=True))


# ---------------------------------------------------------------- joints
def provisional(joint: Joint) -> Joint:
    """Any number for what only the assembled start decides, so that the other rows can be computed."""
    return replace(joint, numbers={key: 1.0 if x is None else x for key, x in joint.numbers.items()})


def place(joint: Joint, says: JointStart, bodies: tuple[Any, ...], angle: Any | None, known: bool) -> Joint:
    """The joint with points and frames, as these positions of its bodies have it.

    angle: what the joint's angle is given to be; known: these bodies have their final relative rotation.
    """
    sides = JOINTS[joint.type].sides
    if says.at is None and not sides:
        return joint
    a, b = ends(joint, bodies)
    if says.at is not None:
        at = says.at
        p, q = (so3.rotate_back(m.R, so3.subtract(at, m.r)) for m in (a, b))
        joint = replace(joint, points=(p, q))
    if not sides:
        return joint
    first, second = _axes(joint, says, a, b)
    x1 = any_frame(first) if says.references is None else frame(first, says.references[0])
    if says.references is not None:
        x2 = frame(second, says.references[1])
    elif angle is None and known:
        x2 = _carried(x1, second, a, b)
    elif angle is not None and known:
        c, s = cos(angle), sin(angle)
        x2 = frame(second, so3.rotate_back(b.R, so3.rotate(a.R, so3.axpy(c, x1[0], so3.scale(s, x1[1])))))
    else:
        x2 = any_frame(second)
    return replace(joint, frames=(x1, x2))


def ends(joint: Joint, bodies: tuple[Any, ...]) -> tuple[Motion, Motion]:
    """How its two bodies are placed."""
    view = still(Instant(bodies), joint.bodies)
    first, second = joint.bodies
    return view[first], view[second]


def _axes(joint: Joint, says: JointStart, a: Motion, b: Motion) -> tuple[Any, Any]:
    """The axis on either side."""
    if says.axis is not None:
        pair = says.axis if len(says.axis) == 2 else (says.axis[0], says.axis[0])
        return unit(so3.rotate_back(a.R, pair[0])), unit(so3.rotate_back(b.R, pair[1]))
    if says.axes is None:
        return Z_AXIS, so3.rotate_back(b.R, so3.rotate(a.R, Z_AXIS))
    if JOINTS[joint.type].sides == 1:
        return unit(says.axes[0]), Z_AXIS
    return unit(says.axes[0]), unit(says.axes[1])


# ---------------------------------------------------------------- what the assembled start decides
def with_numbers(model: Model, bodies: tuple[Any, ...], angles: dict[Any, Any]) -> Model:
    """Omitted numbers of joints, and rests of forces, as they are at the start; an omitted one is None."""
    now = Instant(bodies, 0.0, angles)
    return replace(
        model,
        joints=tuple(_with_numbers(model, j, now) for j in range(len(model.joints))),
        forces=tuple(_with_rest(force, now) for force in model.forces),
    )


def _with_numbers(model: Model, index: int, now: Instant) -> Joint:
    joint = model.joints[index]
    if all(x is not None for x in joint.numbers.values()):
        return joint
    found = JOINTS[joint.type].at_start(model, index, still(now, joint.bodies))
    return replace(joint, numbers={key: found[key] if x is None else x for key, x in joint.numbers.items()})


def _with_rest(force: Force, now: Instant) -> Force:
    if force.rest is not None or force.code is not None:
        return force
    return replace(force, rest=law_of(force).at_start(force, still(now, force.bodies)))
