"""The links of a tree, each with axes in which little has to be computed.

A link is moved by one move (`lienumba.mechanics.mechanism.moves`) against its parent; a joint of several moves has
links without a body between. The axes of a link begin at its joint, z along the axis of the move. About z they are
turned such that the axes of its first child with an axis follow from them by a turn about x alone (as those of Denavit
and Hartenberg, without their common normals): then what goes from link to link meets two plane rotations.
All that depends on numbers of the model alone is computed before the steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.groups import so3
from lienumba.groups.state import State
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.model import GROUND, Joint, Model
from lienumba.mechanics.mechanism.moves import CYCLE, Ball, Free, Move, Turn, Weld, about_x, about_z
from lienumba.mechanics.tree.spanning import Tie, joints_of, leads, ties_of
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import is_zero, sqrt, where

NEARLY_PARALLEL = 1e-200  # the squared sine of an angle that has no direction


@dataclass(frozen=True)
class Frame:
    """In a body: its origin, from the mass centre, and its axes as columns; both along the body's axes."""

    origin: Any
    axes: Any


PINS = (Turn(), Turn(cycled=True))  # whose axes are across each other
AT_CENTRE = Frame((0.0, 0.0, 0.0), so3.IDENTITY)


@dataclass(frozen=True)
class Link:
    """parent: link, or GROUND. turns: rotations whose product has the axes from which the move starts as columns along
    the parent's axes; offset: where it starts, from the parent's origin along the parent's axes. frame: of the link in
    its body, for the last link of a joint. armature: of the move's one rate. first: of its state and of its rates."""

    parent: int
    move: Move
    turns: tuple[Matrix, ...]
    offset: Any
    body: int | None
    frame: Frame | None
    joint: int | None
    pitch: Any
    armature: Any
    first_state: int
    first_rate: int

    @property
    def rates(self) -> range:
        return range(self.first_rate, self.first_rate + self.move.freedoms)


@dataclass(frozen=True)
class Tree:
    """links: parents first; of_body: the link of each body; starts: of each tie the frame in its parent's body from
    which its moves start."""

    ties: tuple[Tie, ...]
    links: tuple[Link, ...]
    of_body: dict[int, int]
    starts: tuple[Frame, ...]

    @property
    def state(self) -> int:
        """Numbers of the state of all moves."""
        return sum(link.move.state for link in self.links)

    @property
    def freedoms(self) -> int:
        return sum(link.move.freedoms for link in self.links)

    @property
    def joints(self) -> set[int]:
        """The joints that hold by the links alone."""
        return joints_of(self.ties)


def tree_of(model: Model) -> Tree:
    """The tree of a model, whatever its numbers are."""
    ties = ties_of(model)
    frames: dict[int, Frame] = {GROUND: AT_CENTRE}
    links: list[Link] = []
    of_body: dict[int, int] = {GROUND: GROUND}
    starts: list[Frame] = []
    for tie in ties:
        moves = moves_of(model, tie)
        start, end = _ends(model, tie, frames[tie.parent])
        main = _main_child(model, ties, tie.body)
        spin = so3.IDENTITY
        if main is not None:
            spin = about_z(*_bend(_along(end.axes, _ends(model, main, end)[0].axes))[0])
        parent = frames[tie.parent]
        K = _along(parent.axes, start.axes)
        if isinstance(moves[-1], Ball | Free):
            turns: tuple[Matrix, ...] = ()
            end = Frame(end.origin, so3.multiply(end.axes, spin))
        else:
            across, bend, spun = _bend(K)
            turns = (about_z(*across), about_x(*bend))
            if moves[0].spins:
                start = Frame(start.origin, so3.multiply(start.axes, about_z(spun[0], -spun[1])))
            else:
                turns = (*turns, about_z(*spun))
            end = Frame(end.origin, so3.multiply(end.axes, spin))
            if not moves[-1].spins:
                turns = (*turns, spin)
        starts.append(start)
        frames[tie.body] = end
        offset = so3.rotate_back(parent.axes, so3.subtract(start.origin, parent.origin))
        joint = None if tie.joint is None else model.joints[tie.joint]
        pitch, armature = (0.0, 0.0) if joint is None else (joint.numbers.get("pitch", 0.0), joint.armature)
        above = of_body[tie.parent]
        for n, move in enumerate(moves):
            last = n == len(moves) - 1
            if move.cycled:
                turns = (*turns, CYCLE)
            state, rate = sum(x.move.state for x in links), sum(x.move.freedoms for x in links)
            body, frame = (tie.body, end) if last else (None, None)
            links.append(Link(above, move, turns, offset, body, frame, tie.joint, pitch, armature, state, rate))
            above, turns, offset = len(links) - 1, (), (0.0, 0.0, 0.0)
        of_body[tie.body] = above
    return Tree(tuple(ties), tuple(links), of_body, tuple(starts))


def moves_of(model: Model, tie: Tie) -> tuple[Move, ...]:
    """The moves of a body against its parent."""
    if tie.joint is None:
        return (Free(),)
    moves = JOINTS[model.joints[tie.joint].type].moves
    assert moves is not None
    return moves or (Weld(),)


def _ends(model: Model, tie: Tie, parent: Frame) -> tuple[Frame, Frame]:
    """Where the moves of a tie start, in the parent's body, and the frame that they move, in its own. parent: the frame
    of the parent's link."""
    if tie.joint is None:
        return AT_CENTRE, AT_CENTRE
    joint = model.joints[tie.joint]
    assert joint.points is not None
    first, second = joint.points[1 - tie.side], joint.points[tie.side]
    if isinstance(moves_of(model, tie)[-1], Ball):
        return Frame(first, parent.axes), Frame(second, so3.IDENTITY)
    assert joint.frames is not None
    axes = [_columns(joint.frames[0]), so3.multiply(_columns(joint.frames[1]), about_x(joint.way, 0.0))]
    return Frame(first, axes[1 - tie.side]), Frame(second, axes[tie.side])


def with_ways(model: Model, bodies: Sequence[State], usual: Model | None = None) -> Model:
    """The model, knowing which axes of joints point against each other where the bodies are, in every run. usual:
    the same model as it is nominally; where all runs are so, or say nothing, their ways are its."""
    joints = []
    for n, joint in enumerate(model.joints):
        if joint.frames is not None and leads(joint) and JOINTS[joint.type].moves != PINS:
            way = 1.0 if usual is None else usual.joints[n].way
            against = np.asarray(_cosine(joint, bodies) * way) < 0.0
            if np.any(against):
                way = np.where(against, -way, way) if against.ndim else -way
            joint = replace(joint, way=way)
        joints.append(joint)
    return replace(model, joints=tuple(joints))


def _cosine(joint: Joint, bodies: Sequence[State]) -> Any:
    """The cosine of the angle between the axes of a joint."""
    assert joint.frames is not None
    return so3.dot(*(_axis(bodies, body, frame) for body, frame in zip(joint.bodies, joint.frames, strict=True)))


def _axis(bodies: Sequence[State], body: int, frame: Any) -> Any:
    return frame[2] if body == GROUND else so3.rotate(bodies[body][3:12], frame[2])


def _main_child(model: Model, ties: list[Tie], body: int) -> Tie | None:
    """The child by whose axis the axes of a body's link are turned."""
    for tie in ties:
        if tie.parent == body and tie.joint is not None and not isinstance(moves_of(model, tie)[-1], Ball):
            return tie
    return None


def _columns(frame: Any) -> Matrix:
    x, y, z = frame
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


def _along(A: Matrix, B: Matrix) -> Matrix:
    """A^T B."""
    return so3.multiply(so3.transpose(A), B)


def _bend(K: Matrix) -> tuple[Vector, Vector, Vector]:
    """The cosine and sine of each angle of K = R_z R_x R_z."""
    x, y, cosine = K[2], K[5], K[8]
    straight = is_zero(x) and is_zero(y)  # where the cosine is 1 but for rounding, the sine may be 1e-8
    if isinstance(cosine, float) and (cosine == 0.0 or (straight and cosine in (-1.0, 1.0))):
        sine: Number = 1.0 - cosine * cosine
        across: tuple[Number, Number] = (-y, x) if sine else (1.0, 0.0)
    else:
        square = x * x + y * y
        none = square < NEARLY_PARALLEL
        n = sqrt(where(none, 1.0, square))
        sine = where(none, 0.0, n)
        across = where(none, 1.0, -y / n), where(none, 0.0, x / n)
    rest = so3.multiply(so3.transpose(about_x(cosine, sine)), so3.multiply(about_z(across[0], -across[1]), K))
    return across, (cosine, sine), (rest[0], rest[3])
