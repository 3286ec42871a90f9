"""Where the coordinates of a joint put the frame of its second body against that of its first, by its moves."""

from collections.abc import Mapping

from lienumba.mechanics.elements.joints.base import JOINTS
from lienumba.mechanics.mechanism.model import Joint, Number
from lienumba.mechanics.mechanism.moves import CYCLE, ZERO, Relative, behind

EXCHANGED = Relative(CYCLE, ZERO, ZERO, ZERO)


def placement(joint: Joint, known: Mapping[str, Number]) -> Relative | None:
    """The relative placement and motion; known: all coordinates by their names, and rates, which are 0 if omitted.
    None of bodies that are welded."""
    left, found = list(JOINTS[joint.type].freedoms()), None
    pitch = joint.numbers.get("pitch", 0.0)
    for move in JOINTS[joint.type].moves or ():
        own = []
        for letter in move.letters:
            own.append(next(x for x in left if x.letter == letter))
            left.remove(own[-1])
        place = move.place(tuple(known[x.name] for x in own))
        if own[0].quarter:
            place = (-place[1], place[0])
        rates = tuple(known.get(x.rate, 0.0) for x in own[: move.freedoms])
        for relative in (EXCHANGED, move.relative((*place, *rates), pitch))[not move.cycled :]:
            found = relative if found is None else behind(found, relative)
    return found
