"""Locks: which coordinates of joints events may hold as they are.

A joint whose coordinates are only ever locked together has one lock, and one of which an event names a coordinate has
one for each that is. A ball is locked as a whole.
"""

from collections.abc import Container, Iterable, Mapping

from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.joints.freedoms import Freedom
from lienumba.mechanics.mechanism.model import Lock

LOCK = "lock"
BALL = ("rx", "ry", "rz")  # coordinates that are locked together


def lockable(kind: str) -> tuple[Freedom, ...]:
    """What a joint of this type leaves free, as far as it has names."""
    joint = JOINTS[kind]
    return joint.independent() or joint.freedoms()


def whole(kind: str) -> bool:
    """Whether its coordinates are locked together or not at all."""
    return JOINTS[kind].together is not None


def locks_of(
    asked: Iterable[tuple[str, str | None]], kinds: Mapping[str, str], locked: Container[str] = ()
) -> tuple[Lock, ...]:
    """The locks of a mechanism; asked: by the events that lock or unlock, the joint and which coordinate; kinds: the
    types of all joints by their names, in their order; locked: those that begin so."""
    named: dict[str, set[str | None]] = {name: {None} for name in kinds if name in locked}
    for joint, coordinate in asked:
        named.setdefault(joint, set()).add(coordinate)
    found: list[Lock] = []
    for index, (name, kind) in enumerate(kinds.items()):
        every = tuple(x.name for x in lockable(kind)) if name in named else ()
        if every and (len(every) == 1 or named[name] == {None}):
            found.append(Lock(f"{name}.{LOCK}", index, every, name in locked))
        else:
            asked_for = every if None in named.get(name, ()) else named.get(name, ())
            each = (x for x in every if x in asked_for)
            found += [Lock(f"{name}.{x}.{LOCK}", index, (x,), name in locked) for x in each]
    return tuple(found)


def chosen(locks: Iterable[Lock], joint: int, coordinate: str | None) -> tuple[int, ...]:
    """Of all locks those (indices) that hold a coordinate of a joint, or any of it."""
    return tuple(
        n
        for n, lock in enumerate(locks)
        if lock.joint == joint and (coordinate is None or coordinate in lock.coordinates)
    )
