"""What switched constraints demand, as plain functions of a view: each as rows of one level.

A lock compares coordinates of a joint with those that it keeps (a ball joint: the sines of the rotation from the one it
keeps). A rigid stop and a contact have a gap, which closes. What sticks, a contact or the friction of a joint, has no
rate along the sliding.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.contacts.geometry import carried, hemisphere
from lienumba.mechanics.elements.joints import parts
from lienumba.mechanics.mechanism.kinematics import OFF, Law, View
from lienumba.mechanics.mechanism.model import Contact, Coordinate, Limit, Lock, Model
from lienumba.mechanics.system.switches import CONTACT, FRICTION, LIMIT, LOCK, RIGID, Switch, is_ball, switches_of
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import maximum, sqrt, where

POSITION, RATE, VELOCITY = "position", "rate", "velocity"
SQUARE_FLOOR = 1e-300  # (m/s)^2: what does not slide has no direction


class Switched(NamedTuple):
    """Rows of a switch on one level; see `constraints.Constraint`. tangents: whether they are those of sliding."""

    switch: Switch
    bodies: tuple[int, ...]
    kinds: str
    level: str
    law: Law
    tangents: bool = False


def laws(model: Model) -> Iterator[Switched]:
    """The laws of all switches but joints, in the order of their rows."""
    for switch in switches_of(model):
        if switch.what == LOCK:
            lock = model.locks[switch.index]
            joint = model.joints[lock.joint]
            kinds = "".join(joints.freedom(model, Coordinate(lock.joint, x)).letter for x in lock.coordinates)
            yield Switched(switch, joint.bodies, kinds, POSITION, partial(_locked, model, lock, switch))
        elif switch.what == LIMIT:
            limit = model.limits[switch.index]
            yield Switched(switch, *_along(model, limit.coordinate), POSITION, partial(_room, model, limit))
        elif switch.what == CONTACT:
            contact = model.contacts[switch.index]
            yield Switched(switch, contact.bodies, "m", POSITION, partial(_gap, contact))
            if switch.tangents:
                yield Switched(switch, contact.bodies, "mm", VELOCITY, partial(_slip, contact), tangents=True)
        elif switch.what == FRICTION:
            which = model.forces[switch.index].coordinate
            assert which is not None
            law = partial(_rests, model, which)
            yield Switched(switch, *_along(model, which), RATE, law, tangents=True)


def _along(model: Model, which: Coordinate) -> tuple[tuple[int, ...], str]:
    """The bodies of a coordinate, and the letter of its row."""
    return model.joints[which.joint].bodies, joints.freedom(model, which).letter


def _locked(model: Model, lock: Lock, switch: Switch, view: View) -> Vector:
    now = measured(model, lock, view)
    mode = view.modes.get(switch.key)
    if is_ball(lock):
        kept = tuple(lift(x).a for x in now)  # what it would keep: its rows are then the rates
        if mode is not None:
            kept = tuple(where(mode.on > OFF, x, y) for x, y in zip(mode.memory, kept, strict=True))
        sines: Vector = so3.vee(so3.multiply(so3.transpose(kept), now))
        return sines
    kept = mode.memory if mode is not None else (0.0,) * len(now)
    rows = []
    for name, x, was in zip(lock.coordinates, now, kept, strict=True):
        counts = joints.freedom(model, Coordinate(lock.joint, name)).counts
        rows.append((parts.counted(x, was) if counts else x) - was)
    return tuple(rows)


def measured(model: Model, lock: Lock, view: View) -> Vector:
    """What a lock keeps, as it is now: its coordinates, angles up to whole turns; of a ball joint the rotation matrix
    of the second body against the first."""
    joint = model.joints[lock.joint]
    a, b = (view[i] for i in joint.bodies)
    if is_ball(lock):
        return so3.multiply(so3.transpose(a.R), b.R)
    return tuple(joints.freedom(model, Coordinate(lock.joint, x)).value(joint, a, b) for x in lock.coordinates)


def _room(model: Model, limit: Limit, view: View) -> Vector:
    return (limit.side * (joints.coordinate(model, limit.coordinate, view) - limit.value),)


def _gap(contact: Contact, view: View) -> Vector:
    return (CONTACTS[contact.type].gap(contact, *(view[i] for i in contact.bodies)),)


def _slip(contact: Contact, view: View) -> Vector:
    rates: Vector = CONTACTS[contact.type].rates(contact, *(view[i] for i in contact.bodies))
    return rates


def _rests(model: Model, which: Coordinate, view: View) -> Vector:
    return (joints.in_motion(model, which, view),)


def keeps(model: Model, switch: Switch, view: View, rates: Vector) -> Vector:
    """The memory of a switch if it were turned on now; of what slides in a plane the direction against which friction
    acts. rates: of its rows."""
    if switch.what == LOCK:
        return tuple(lift(x).a for x in measured(model, model.locks[switch.index], view))
    if not switch.tangents:
        return ()
    slides = tuple(rates[switch.rows - switch.tangents :])
    if switch.tangents > 1:
        found = sliding(slides, *heading(model, switch, view, view.modes[switch.key].memory))
    else:
        found = direction(slides, (0.0,) * switch.tangents)
    if _moves(model, switch):
        found = (*found, hemisphere(_normal(model, switch, view)))
    return (*found, *RIGID) if switch.compliant else found


def heading(model: Model, switch: Switch, view: View, kept: Vector) -> tuple[Vector, Any]:
    """The direction of sliding that was kept, along the tangents as they are now, and the speed (m/s) with which: what
    is slower has no direction of its own (see `sliding`)."""
    now = _kept(model, switch, view, kept, 0)
    return direction(now, (0.0,) * switch.tangents), length(now)


def compliance(model: Model, switch: Switch, view: View, kept: Vector) -> tuple[Vector, list[list[Any]]]:
    """How what sticks shares with others what holds them: lambda_t = c lambda_n + V y along its tangents, where y is
    what contacts that are all alike would have. c and V = w (1 - g g^T), 2 x 2, from what was kept: c, then g and w."""
    c, g, w = _kept(model, switch, view, kept, 0), _kept(model, switch, view, kept, -len(RIGID)), kept[-1]
    return c, [[w * ((1.0 if a == b else 0.0) - g[a] * g[b]) for b in range(2)] for a in range(2)]


def _kept(model: Model, switch: Switch, view: View, kept: Vector, first: int) -> Vector:
    """What was kept along tangents, along these as they are now."""
    own = tuple(kept[first:][: switch.tangents])
    if not _moves(model, switch):
        return own
    return carried(_normal(model, switch, view), (*own, kept[switch.tangents]))


def _moves(model: Model, switch: Switch) -> bool:
    """Whether the tangents of a switch may jump, as its normal turns, and it remembers whose they are."""
    return switch.what == CONTACT and switch.tangents > 0 and model.contacts[switch.index].normal is None


def _normal(model: Model, switch: Switch, view: View) -> so3.Vec3:
    """Of a contact, as a number, in the frame of its second body."""
    contact = model.contacts[switch.index]
    x, y, z = CONTACTS[contact.type].place(contact, *(view[i] for i in contact.bodies)).normal
    return lift(x).a, lift(y).a, lift(z).a


def length(rows: Sequence[Number]) -> Any:
    """Of what is along tangents."""
    if len(rows) == 1:
        return where(rows[0] < 0.0, -rows[0], rows[0])
    square: Any = 0.0
    for x in rows:
        square = square + x * x
    return sqrt(square)


def direction(rates: Vector, otherwise: Vector) -> Vector:
    """The unit vector along these; another one where they vanish."""
    square: Any = 0.0
    for x in rates:
        square = square + x * x
    moves = square > SQUARE_FLOOR
    inverse = 1.0 / sqrt(where(moves, square, 1.0))
    return tuple(where(moves, inverse * x, d) for x, d in zip(rates, otherwise, strict=True))


def own(rates: Vector, slow: Number) -> Any:
    """How far the direction of what slides in a plane is its own: from 0 at rest to 1 where it is not slow."""
    (x, y), limit = rates, slow * slow
    left = 1.0 - (x * x + y * y) / where(limit > SQUARE_FLOOR, limit, 1.0)
    left = where(limit > SQUARE_FLOOR, maximum(left, 0.0), 0.0)
    return 1.0 - left * left


def sliding(rates: Vector, ahead: Vector, slow: Number) -> Vector:
    """The direction against which friction acts: that of w, times the sign of w . d with the direction d that was kept,
    so that it goes on as it is where the rates turn round. Slower than `slow` it turns into d: beside w = 0 that of w
    is rounding, or the error of a step, and turns the faster the slower it slides."""
    (x, y), (c, s) = rates, ahead
    sign, towards = where(x * c + y * s < 0.0, -1.0, 1.0), slow * (1.0 - own(rates, slow))
    return direction((sign * x + towards * c, sign * y + towards * s), ahead)
