"""A start along the joints: coordinates that are given say where the body behind a joint is, and how it moves.

One pass from the bodies that are known to those behind them, elementwise for all runs. Between the bodies a and b of a
joint, with its points p and q, its frames' axes as columns of F, and E, d, w and d' of the second frame against the
first (`moves.Relative`), e = p + F_a d:
    R_b F_b = R_a F_a E,                  r_b + R_b q = r_a + R_a e,
    W_b = W_a + R_a F_a E w,              v_b + W_b x R_b q = v_a + W_a x R_a e + R_a F_a d',
W global.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import pi
from typing import Any, NamedTuple

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.kinematics import FIXED, UNIT, Motion
from lienumba.mechanics.mechanism.model import GROUND, Frame, Joint, JointStart, Model, Start, Vec3
from lienumba.mechanics.mechanism.moves import ZERO, Ball
from lienumba.mechanics.start.poses import Local, Poses
from lienumba.mechanics.tree.spanning import Tie, joints_of, leads
from lienumba.numerics.operations import is_zero


class Along(NamedTuple):
    """local: as in `Poses`; ties: by which joints bodies were put there, parents first."""

    local: tuple[Local, ...]
    ties: tuple[Tie, ...]

    @property
    def bodies(self) -> set[int]:
        return {tie.body for tie in self.ties}

    @property
    def joints(self) -> set[int]:
        return joints_of(self.ties)


def along_joints(model: Model, start: Start, poses: Poses, zero_by_axes: bool = False) -> Along:
    """The bodies of which neither position nor rotation is given or guessed, put where joints with all coordinates
    given have them; what slides is turned by its axes, where no references say how. zero_by_axes: also those whose
    angle counts from the axes.

    Then also bodies of which at least the position is not: where a joint holds their points together, turned as they
    start."""
    says, ways = start.joints, _Ways(poses)
    ways.open = {i for i in range(len(start.poses)) if _is_open(start, poses, i)}
    ways.telling = {j for j, joint in enumerate(model.joints) if _tells(joint, says[j], zero_by_axes)}
    if not ways.open or not ways.telling:
        return Along(poses.local, ())
    pins = {j for j, joint in enumerate(model.joints) if _pins(joint) and says[j].at is None}
    ways.pinning = pins - ways.telling
    local, ties = list(poses.local), []
    placed: dict[int, Motion] = {GROUND: FIXED}
    for tie in ways.ties(model):
        as_it_starts = _on(placed[poses.bases[tie.body]], local[tie.body]) if tie.joint not in ways.telling else None
        if tie.joint is None:
            assert as_it_starts is not None
            placed[tie.body] = as_it_starts
            continue
        placed[tie.body] = _placed(model.joints[tie.joint], says[tie.joint], placed[tie.parent], tie.side, as_it_starts)
        ties.append(tie)
    for tie in ties:
        seen = _seen_from(placed[poses.bases[tie.body]], placed[tie.body])
        local[tie.body] = (*seen[0:3], *local[tie.body][3:12]) if tie.joint in ways.pinning else seen
    return Along(tuple(local), tuple(ties))


def _is_open(start: Start, poses: Poses, i: int) -> bool:
    """Whether nothing is said of where a body is."""
    pose = start.poses[i]
    said = [pose.position, pose.rotation]
    said += [] if pose.guess is None else [pose.guess.position, pose.guess.rotation]
    return all(x is None for x in said) and 6 * i + 3 in poses.turns


def _tells(joint: Joint, says: JointStart, zero_by_axes: bool) -> bool:
    """Whether a joint says where its second body is relative to its first."""
    kind = JOINTS[joint.type]
    if not leads(joint) or says.at is not None or (kind.sides and says.axes is None):
        return False
    assert kind.moves is not None
    names = [x.name for x in kind.freedoms()]
    few = sum(move.freedoms for move in kind.moves) <= len(names)
    from_axes = (zero_by_axes or "angle" not in names) and says.axes is not None and _equal(says.axes)
    zero = not kind.sides or says.references is not None or from_axes
    return few and all(name in says.known for name in names) and zero


def _equal(axes: tuple[Vec3, Vec3]) -> bool:
    """Whether both are the same in every run, for whatever runs there are."""
    return all(isinstance(a, float | int) and isinstance(b, float | int) and a == b for a, b in zip(*axes, strict=True))


def _pins(joint: Joint) -> bool:
    """Whether a joint holds two points together, and nothing else."""
    return leads(joint) and JOINTS[joint.type].moves == (Ball(),)


@dataclass
class _Ways:
    """From body to body: open, of which nothing is said; telling, pinning: joints (indices)."""

    poses: Poses
    open: set[int] = field(default_factory=set)
    telling: set[int] = field(default_factory=set)
    pinning: set[int] = field(default_factory=set)

    def ties(self, model: Model) -> Iterator[Tie]:
        """Every body once: tied by a joint, or to its base by its pose; what it is tied to comes before."""
        at: dict[int, list[int]] = {}
        for j in (*sorted(self.telling), *sorted(self.pinning)):
            for i in model.joints[j].bodies:
                at.setdefault(i, []).append(j)
        loose = {c // 6 for c in self.poses.loose}
        hung = self.open | {i for j in self.pinning for i in model.joints[j].bodies if i in loose}
        on: dict[int, list[int]] = {}
        for i, base in enumerate(self.poses.bases):
            if i not in hung:
                on.setdefault(base, []).append(i)
        reached: set[int] = set()
        for root in (GROUND, *self.poses.order):  # of those that no joint reaches, the first is where it starts
            front = [] if root in reached else [root]
            if root != GROUND and front:
                yield Tie(root, self.poses.bases[root])
            reached.add(root)
            while front:
                first = front.pop(0)
                tied = [Tie(i, first) for i in on.get(first, [])]
                for j in at.get(first, []):
                    side = 1 - model.joints[j].bodies.index(first)
                    body = model.joints[j].bodies[side]
                    telling = j in self.telling
                    if body in (self.open if telling else hung) and (telling or self.poses.bases[body] in reached):
                        tied.append(Tie(body, first, j, side))
                for tie in tied:
                    if tie.body not in reached:
                        reached.add(tie.body)
                        front.append(tie.body)
                        yield tie


def _on(base: Motion, local: Local) -> Motion:
    p, R = local[0:3], local[3:12]
    return Motion(p, R) if base is FIXED else Motion(base.point(p), so3.multiply(base.R, R))


def _seen_from(base: Motion, body: Motion) -> Local:
    """The reverse of `_on`."""
    if base is FIXED:
        return (*body.r, *body.R)
    p = so3.rotate_back(base.R, so3.subtract(body.r, base.r))
    return (*p, *so3.multiply(so3.transpose(base.R), body.R))


def _placed(joint: Joint, says: JointStart, parent: Motion, side: int, turned: Motion | None) -> Motion:
    """The body at this side of a joint whose other one is at the parent; turned so, or as the joint has it."""
    R = _rotation(joint, says, parent.R, side) if turned is None else turned.R
    ends = _ends(joint, says)
    return Motion(so3.subtract(parent.point(ends[1 - side]), so3.rotate(R, ends[side])), R)


def _rotation(joint: Joint, says: JointStart, parent: Any, side: int) -> Any:
    """R of the body at this side; parent: that of the other one."""
    relative = joints.placement(joint, says.known)
    if joint.frames is None:
        first = second = so3.IDENTITY
    else:
        first, second = (_columns(frame) for frame in joint.frames)
    turn = first if relative is None else so3.multiply(first, relative.E)
    own, other = (second, turn) if side == 1 else (turn, second)
    return so3.multiply(parent, so3.multiply(other, so3.transpose(own)))


def _ends(joint: Joint, says: JointStart) -> tuple[Any, Any]:
    """Where the second body's point is, in the first body and in the second."""
    assert joint.points is not None
    first, second = joint.points
    relative = None if _pins(joint) else joints.placement(joint, says.known)
    for x, axis in zip(ZERO if relative is None else relative.d, _axes(joint), strict=True):
        first = first if is_zero(x) else so3.axpy(x, axis, first)
    return first, second


def _axes(joint: Joint) -> Any:
    """Those of the first body's frame, in that body."""
    return UNIT if joint.frames is None else joint.frames[0]


def _columns(frame: Frame) -> Any:
    return tuple(axis[i] for i in range(3) for axis in frame)


# ---------------------------------------------------------------- velocities
def moving_along(
    model: Model, start: Start, poses: Poses, ties: Sequence[Tie], bodies: tuple[Any, ...]
) -> tuple[Any, ...] | None:
    """The bodies with the velocities that are given, or that these joints say behind them; None where any has others.
    bodies: with those that are given."""
    tied = {tie.body for tie in ties}
    if not tied:
        return None
    moving: dict[int, Motion] = {GROUND: FIXED}
    for i in set(poses.order) - tied:
        if not poses.free_rates.isdisjoint(range(6 * i, 6 * i + 6)) or poses.bases[i] in tied:
            return None
        x = bodies[i]
        moving[i] = Motion(x[0:3], x[3:12], x[12:15], x[15:18])
    for tie in ties:
        assert tie.joint is not None
        i, joint, says = tie.body, model.joints[tie.joint], start.joints[tie.joint]
        x, free = bodies[i], [c in poses.free_rates for c in (6 * i, 6 * i + 3)]
        body, parent = Motion(x[0:3], x[3:12], w=x[15:18]), moving[tie.parent]
        rates = _rates(joint, says) if free == [True, True] else None
        if rates is None:
            if not _pins(joint) or free != [True, False] or poses.bases[i] != GROUND:
                return None
            moving[i] = _moving(joint, says, parent, body, tie.side)
            continue
        relative = joints.placement(joint, says.known | rates)
        turning, parting = so3.rotate(parent.R, parent.w), ZERO
        if relative is not None:
            sign, first = 1.0 if tie.side == 1 else -1.0, body if tie.side == 0 else parent
            n = [so3.rotate(first.R, axis) for axis in _axes(joint)]
            turning = _along(sign, so3.rotate(relative.E, relative.w), n, turning)
            parting = _along(sign, relative.rate, n, ZERO)
        body = body._replace(w=so3.rotate_back(body.R, turning))
        moving[i] = _moving(joint, says, parent, body, tie.side, parting)
    return tuple((*bodies[i][0:12], *moving[i].v, *moving[i].w) for i in range(len(bodies)))


def _along(sign: float, x: Any, axes: Sequence[Any], start: Any) -> Any:
    """start, and what is given along axes."""
    for number, axis in zip(x, axes, strict=True):
        start = start if is_zero(number) else so3.axpy(sign * number, axis, start)
    return start


def _rates(joint: Joint, says: JointStart) -> dict[str, Any] | None:
    """Those of all coordinates; None if they, or the coordinates, are not all given."""
    every = JOINTS[joint.type].freedoms()
    if any(x.name not in says.known for x in every):
        return None
    names = [x.rate for x in every]
    known = {name: says.known[name] for name in names if name in says.known}
    if "pitch" in joint.numbers:
        per_angle = joint.numbers["pitch"] * (0.5 / pi)
        if names[0] in known:
            known.setdefault(names[1], per_angle * known[names[0]])
        elif names[1] in known:
            known[names[0]] = known[names[1]] / per_angle
    return known if len(known) == len(names) else None


def _moving(
    joint: Joint, says: JointStart, parent: Motion, body: Motion, side: int, parting: Any = (0.0, 0.0, 0.0)
) -> Motion:
    """A body with the velocity that the joint to its parent gives it. parting: the points, relative to the parent."""
    ends = _ends(joint, says)
    along, own = so3.rotate(parent.R, ends[1 - side]), so3.rotate(body.R, ends[side])
    at = so3.add(parent.v, so3.cross(so3.rotate(parent.R, parent.w), along))
    return body._replace(v=so3.subtract(so3.add(at, parting), so3.cross(so3.rotate(body.R, body.w), own)))
