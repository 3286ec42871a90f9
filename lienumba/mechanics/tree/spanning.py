"""Which joint ties which body to which: a tree that spans the mechanism. What it does not use are constraints.

A massless body cannot be the last of a branch. Where it closes a loop, it carries the body at the other side, whose own
joint becomes a constraint.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.massless import is_massless, massless
from lienumba.mechanics.mechanism.model import GROUND, Joint, Model
from lienumba.mechanics.system.constraints import rows_of
from lienumba.numerics.operations import is_zero


@dataclass(frozen=True)
class Tie:
    """body is tied to parent by a joint (index), of which it is the body number `side`; without one it is free."""

    body: int
    parent: int
    joint: int | None = None
    side: int = 1


def ties_of(model: Model) -> list[Tie]:
    """One for each body, parents before children: as near to the ground as joints go, those with rotors first, then
    from each body that is left, in the order of the model."""
    ties: list[Tie] = []
    reached = {GROUND}
    _grow(model, [GROUND], reached, ties)
    for body in range(len(model.bodies)):
        if body not in reached:
            ties.append(Tie(body, GROUND))
            reached.add(body)
            _grow(model, [body], reached, ties)
    for body in massless(model):
        ties = _with_load(model, ties, body)
    return ties


def idle(model: Model) -> Iterator[int]:
    """The massless bodies that their joints let move with all that they carry, which has no mass, and no rotor."""
    ties = ties_of(model)
    heavy: set[int] = set()
    for tie in reversed(ties):
        joint = None if tie.joint is None else model.joints[tie.joint]
        moves = joint is None or JOINTS[joint.type].moves != ()
        heavy |= {tie.body} if not is_massless(model.bodies[tie.body]) else set()
        if tie.body in heavy:
            heavy.add(tie.parent)
        elif moves and (joint is None or is_zero(joint.armature)):
            yield tie.body


def _with_load(model: Model, ties: list[Tie], body: int) -> list[Tie]:
    """With something tied to a massless body that carries nothing, if it closes a loop."""
    parents = {tie.body: tie.parent for tie in ties}
    if body in parents.values():
        return ties
    above = [body]
    while above[-1] != GROUND:
        above.append(parents[above[-1]])
    tied = {tie.joint for tie in ties}
    for index, joint in enumerate(model.joints):
        if index in tied or not leads(joint) or body not in joint.bodies:
            continue
        side = 1 - joint.bodies.index(body)
        other = joint.bodies[side]
        if other not in above:
            moved = [Tie(other, body, index, side) if tie.body == other else tie for tie in ties]
            return _parents_first(moved)
    return ties


def _parents_first(ties: list[Tie]) -> list[Tie]:
    done: list[Tie] = []
    reached = {GROUND}
    while len(done) < len(ties):
        for tie in ties:
            if tie.parent in reached and tie.body not in reached:
                done.append(tie)
                reached.add(tie.body)
    return done


def _grow(model: Model, front: list[int], reached: set[int], ties: list[Tie]) -> None:
    while front:
        parent = front.pop(0)
        for index, joint in sorted(enumerate(model.joints), key=lambda x: is_zero(x[1].armature)):
            if not leads(joint) or parent not in joint.bodies:
                continue
            side = 1 - joint.bodies.index(parent)
            body = joint.bodies[side]
            if body not in reached:
                ties.append(Tie(body, parent, index, side))
                reached.add(body)
                front.append(body)


def leads(joint: Joint) -> bool:
    """Whether a joint may tie a body to its parent."""
    holds = joint.active and not joint.switched
    return holds and joint.code is None and JOINTS[joint.type].moves is not None and len(set(joint.bodies)) == 2


def joints_of(ties: Iterable[Tie]) -> set[int]:
    """The joints (indices) that tie bodies to their parents."""
    return {tie.joint for tie in ties if tie.joint is not None}


def closing_rows(model: Model) -> set[int]:
    """The rows of C that no joint of the tree has."""
    tied = joints_of(ties_of(model))
    return {row for n, rows in enumerate(rows_of(model)) if n not in tied for row in range(rows.start, rows.stop)}
