"""What acts on the links of a tree, and what closes its loops, along the axes of the links.

Forces, constraints and rotors are those of the bodies in the ground's axes (`lienumba.mechanics.system`); what acts
along a joint of the tree acts along its rate.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.elements.forces import law_of
from lienumba.mechanics.mechanism.model import Body, Force
from lienumba.mechanics.system import applied_forces, dynamics, kkt, rotors
from lienumba.mechanics.tree.inertia import Rigid, Six
from lienumba.mechanics.tree.links import Link, Tree
from lienumba.mechanics.tree.motion import Moving, centre, state_of
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero, sqrt

NOTHING: Six = (0.0,) * 6


def rigid(tree: Tree, link: Link, bodies: Sequence[Body]) -> Rigid | None:
    """A link's body, about its origin."""
    if link.body is None:
        return None
    body = bodies[link.body]
    if is_zero(body.mass) and all(is_zero(x) for x in body.inertia):
        return None
    assert link.frame is not None
    still = Rigid(body.mass, (0.0, 0.0, 0.0), body.inertia)
    return still.rotated(so3.transpose(link.frame.axes)).shifted(centre(link))


def along(posture: Posture, force: Force) -> tuple[int, Any] | None:
    """The rate along which a force acts, and its effort; None if it acts on bodies."""
    which = force.coordinate
    if which is None or force.code is not None or law_of(force).velocity_level:
        return None
    for tie in posture.tree.ties:
        if tie.joint == which.joint:
            for link in posture.tree.links:
                gain = link.move.gain(which.kind, link.pitch)
                if link.joint == tie.joint and gain is not None:
                    gain = gain if tie.side else -gain
                    rate = gain * state_of(link, tuple(posture.z))[link.move.places]
                    return link.first_rate, gain * applied_forces.effort(posture.model, force, posture.now, rate)
    return None


def efforts(every: Iterable[tuple[int, Any]]) -> dict[int, Any]:
    """The sum of the efforts of all forces, by rate."""
    found: dict[int, Any] = {}
    for rate, x in every:
        found[rate] = found[rate] + x if rate in found else x
    return found


def wrenches(posture: Posture, without: set[str]) -> list[Six]:
    """What acts on each link beside its joints and its weight, about its origin: forces but for some, and what turning
    bodies have against being turned."""
    model, tree = posture.model, posture.tree
    forces = [force for force in model.forces if force.name not in without]
    applied = [NOTHING] * len(tree.links)
    if forces:
        applied = of_bodies(posture, applied_forces.generalized(model, posture.now, forces))
    found = []
    for link, moving, wrench in zip(tree.links, posture.links, applied, strict=True):
        own = rigid(tree, link, model.bodies)
        if own is not None:
            w = moving.w
            centrifugal = so3.cross(so3.cross(w, own.h), w)
            inner = centrifugal + dynamics.gyroscopic(own.J, w)
            wrench = tuple(a + b for a, b in zip(wrench, inner, strict=True))
        found.append(wrench)
    return found


def of_bodies(posture: Posture, f: Sequence[Number]) -> list[Six]:
    """What acts on the bodies (6 k: forces, global, on mass centres; torques, body frame) as wrenches on the links."""
    found = []
    for link, moving in zip(posture.tree.links, posture.links, strict=True):
        body = link.body
        found.append(NOTHING if body is None else _to_link(link, moving, f[6 * body : 6 * body + 6]))
    return found


def in_use(C: kkt.Entries, mask: Sequence[Number], structure: kkt.Structure) -> kkt.Entries:
    """The rows in use."""
    used = set(structure.order)
    return {key: mask[key[0]] * x for key, x in C.items() if key[0] in used and not is_zero(mask[key[0]])}


def by_link(posture: Posture, C: kkt.Entries) -> dict[int, dict[int, Six]]:
    """The entries of each row of C by link."""
    rows: dict[int, dict[int, list[Any]]] = {}
    for (row, column), x in C.items():
        rows.setdefault(row, {}).setdefault(column // 6, [0.0] * 6)[column % 6] = x
    tree = posture.tree
    found: dict[int, dict[int, Six]] = {}
    for row, by_body in rows.items():
        found[row] = {}
        for body, entries in by_body.items():
            place = tree.of_body[body]
            found[row][place] = _to_link(tree.links[place], posture.links[place], entries)
    return found


def rotors_apart(posture: Posture, first: int) -> tuple[kkt.Entries, dict[int, Any]]:
    """Of the rotors whose joints close loops, as rows from `first` on: their entries, so scaled that each weighs 1 in
    them, and what c a is where it does not resist."""
    model, tied = posture.model, posture.tree.joints
    every = [rotor for rotor in rotors.rotors_of(model) if rotor.joint not in tied]
    entries: kkt.Entries = {}
    free: dict[int, Any] = {}
    for row, rotor in enumerate(every, first):
        root = sqrt(rotor.inertia)
        entries |= {(row, column): root * x for column, x in rotor.row(posture.now).items()}
        free[row] = -(root * rotor.rate_and_bias(posture.now)[1])
    return entries, free


def without_centrifugal(
    posture: Posture, C: kkt.Entries, rows: Mapping[int, Mapping[int, Six]], xi: Sequence[Number], g: Vector
) -> list[Any]:
    """xi as it is for accelerations of origins, with the weight's acceleration in them."""
    rest = list(xi)
    for row, by_link in rows.items():
        for place, y in by_link.items():
            w, c = posture.links[place].w, centre(posture.tree.links[place])
            rest[row] = rest[row] - so3.dot(y[0:3], so3.cross(w, so3.cross(w, c)))
    for (row, column), x in C.items():
        if column % 6 < 3:
            rest[row] = rest[row] - x * g[column % 6]
    return rest


def _to_link(link: Link, moving: Moving, f: Sequence[Number]) -> Six:
    """A force (global) on a body's mass centre and a torque (body frame) as a wrench on its link; so rows of C."""
    assert link.frame is not None
    force = so3.rotate_back(moving.R, tuple(f[0:3]))
    torque = so3.rotate_back(link.frame.axes, tuple(f[3:6]))
    return (*force, *so3.add(torque, so3.cross(centre(link), force)))
