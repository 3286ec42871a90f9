"""What of a mechanism can be drawn: a solid for each body, and the points, axes and rods of its joints."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, pairwise
from math import hypot

import numpy as np

from lienumba.groups import so3
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.joints.base import AXIS, RAIL, ROD
from lienumba.mechanics.elements.locks import lockable
from lienumba.mechanics.mechanism.massless import is_massless
from lienumba.mechanics.mechanism.model import GROUND, Contact, Joint, Vec3
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.start import joint_frames
from lienumba.mechanics.system import switches
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.build import geometry, numbered
from lienumba.scene.contacts import outlines
from lienumba.scene.solids import NOTHING, SHAPES, Solid, equivalent, looking

ARM = "arm"
STANDING = "#a8a8a8"  # the colour of what stands still
# How long an axis is drawn, relative to the size of the mechanism; where something slides along it, it is a rail.
LENGTHS = {AXIS: 0.25, RAIL: 0.6}
ORIGIN = (0.0, 0.0, 0.0)
STILL = (0.0,) * 6  # velocities


@dataclass(frozen=True)
class Place:
    """A point (m) of a body (index; -1 for the ground), in its own frame."""

    body: int
    point: Vec3


@dataclass(frozen=True)
class Segment:
    """A straight line between two places. kind: the "axis" of a joint, the "rod" of a distance joint, or the "arm" from
    the mass centre of a body to one of its joints; name: of the joint."""

    kind: str
    name: str
    ends: tuple[Place, Place]


@dataclass(frozen=True)
class Mark:
    """The point of a joint on one of its bodies."""

    name: str
    type: str
    place: Place


@dataclass(frozen=True)
class Mechanism:
    """bodies: names, in the order of `masses` (kg) and `solids`; ground: what stands still, in the global frame;
    switched: where one sees a switched constraint, by what it is and its name."""

    bodies: tuple[str, ...]
    masses: tuple[float, ...]
    solids: tuple[Solid, ...]
    segments: tuple[Segment, ...]
    marks: tuple[Mark, ...]
    ground: Solid
    switched: Mapping[tuple[str, str], Place] = field(default_factory=dict)

    @property
    def seen(self) -> tuple[int, ...]:
        """The bodies of which there is something to see, not helpers without mass between two joints."""
        return tuple(n for n, solid in enumerate(self.solids) if solid.faces)


def mechanism(
    scenario: Scenario, samples: Mapping[str, float], positions: np.ndarray, rotations: np.ndarray
) -> Mechanism:
    """The mechanism of a run: with its samples, by path, and the poses of its bodies at the start, (k, 3) in m and
    (k, 3, 3) body to global, which say where a joint that is entered in the global frame is in each body.

    No code of the user's own runs; joints that are such code are not drawn, nor are gears and couplers, which have no
    place. Where a body has shapes, neither arms nor joints are drawn on it.
    """
    model, start = geometry(scenario, samples)
    model = map_numbers(model, lambda x, _: float(x))
    states = [(*r, *R.ravel(), *STILL) for r, R in zip(positions, rotations, strict=True)]
    joints = [
        joint_frames.place(joint, says, tuple(states), None, known=True)
        for joint, says in zip(model.joints, start.joints, strict=True)
    ]
    keys = numbered(scenario, samples)
    ground = looking(keys.ground_shapes or (), STANDING)
    solids = tuple(
        looking(own.shapes or ()) if own.shapes or is_massless(x) else equivalent(x.mass, x.inertia)
        for own, x in zip(keys.bodies, model.bodies, strict=True)
    )
    shaped = {i for i, solid in enumerate(solids) if solid.kind == SHAPES}
    if shaped:  # with helpers between them
        shaped |= {i for i, solid in enumerate(solids) if solid.kind == NOTHING}
    clad = shaped | ({GROUND} if ground.faces else set())
    marks = tuple(Mark(joint.name, joint.type, place) for joint in joints for place in _points(joint))
    own = [mark for mark in marks if mark.place.body != GROUND]
    size = max([0.0, *(solid.radius for solid in solids), *(hypot(*mark.place.point) for mark in own)])
    bare = [mark for mark in own if mark.place.body not in shaped]
    arms = [Segment(ARM, mark.name, (Place(mark.place.body, ORIGIN), mark.place)) for mark in bare]
    return Mechanism(
        tuple(body.name for body in model.bodies),
        tuple(body.mass for body in model.bodies),
        solids,
        (
            *arms,
            *(line for joint in joints for line in _lines(joint, size) if line.kind == ROD or _is_bare(joint, shaped)),
            *(line for contact in model.contacts for line in _touching(contact, size)),
        ),
        tuple(mark for mark in marks if mark.place.body not in clad),
        ground,
        dict(_switched(scenario, joints, model.contacts)),
    )


def _switched(
    scenario: Scenario, joints: Sequence[Joint], contacts: Sequence[Contact]
) -> Iterator[tuple[tuple[str, str], Place]]:
    """Where one sees the joints, locks, limits, contacts and friction that may be on or off."""
    places = {joint.name: place for joint in joints for place in islice(_points(joint), 1)}
    for joint in joints:
        if joint.name in places:
            names = [joint.name, *(f"{joint.name}.{x.name}" for x in lockable(joint.type))]
            yield (switches.JOINT, joint.name), places[joint.name]
            yield from (((switches.LOCK, f"{name}.lock"), places[joint.name]) for name in names)
    for limit in scenario.data.model.limits:
        if limit.joint in places:
            yield from (((switches.LIMIT, f"{limit.name}.{side}"), places[limit.joint]) for side in ("low", "high"))
    for contact in contacts:
        yield (switches.CONTACT, contact.name), Place(contact.bodies[0], contact.points[0])
    for force in scenario.data.model.forces:
        held = str(getattr(force, "joint", ""))
        if held in places:
            yield (switches.FRICTION, force.name), places[held]


def _is_bare(joint: Joint, shaped: set[int]) -> bool:
    """Whether one of its bodies is drawn without shapes of its own, which would tell where it moves."""
    return any(body != GROUND and body not in shaped for body in joint.bodies)


def _points(joint: Joint) -> Iterator[Place]:
    """Where a joint is, on each of its bodies."""
    if joint.points is not None:
        yield from map(Place, joint.bodies, joint.points)


def _lines(joint: Joint, size: float) -> Iterator[Segment]:
    """The axis of a joint, on every body where it has one of its own; the rod of a distance."""
    kind = JOINTS[joint.type]
    drawn = kind.drawn()
    if drawn == ROD:
        first, second = _points(joint)
        yield Segment(ROD, joint.name, (first, second))
    if joint.frames is None or drawn not in LENGTHS:
        return
    half = 0.5 * size * LENGTHS[drawn]
    for body, point, frame in zip(joint.bodies, joint.points or (ORIGIN, ORIGIN), joint.frames, strict=True):
        z = frame[2]
        ends = (Place(body, _along(point, z, sign * half)) for sign in (-1.0, 1.0))
        yield Segment(AXIS, joint.name, (next(ends), next(ends)))
        if kind.stays_parallel or kind.sides == 1:
            return  # one line for both


def _touching(contact: Contact, size: float) -> Iterator[Segment]:
    """Planes and round parts of a contact."""
    for body, corners in outlines(contact, size):
        for ends in pairwise([*corners, corners[0]]):
            yield Segment(AXIS, contact.name, (Place(body, ends[0]), Place(body, ends[1])))


def _along(point: Vec3, z: Vec3, length: float) -> Vec3:
    x, y, z = so3.axpy(length, z, point)
    return x, y, z
