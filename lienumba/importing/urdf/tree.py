"""The tree of a robot's links: its order, what its fixed joints weld together, and whether all that moves has mass."""

from collections import defaultdict
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.importing.notes import Note
from lienumba.importing.urdf.robot import Array, Inertial, Joint, Pose, Robot

WORLD = "world"  # the link that ROS and MuJoCo hold to be the ground
SMALLEST = 1e-15  # moment of inertia in kg m², below which it is none
ROUNDING = 1e-9  # of moments of inertia, relative to the largest


@dataclass(frozen=True)
class Tree:
    """root: the link that hangs on nothing; joints: each behind that which carries its parent; free: the root moves;
    placed: where it stands on the ground, or is at first."""

    robot: Robot
    root: str
    joints: list[Joint]
    free: bool
    placed: Pose = field(default_factory=Pose)

    def heads(self) -> dict[str, str]:
        """By link, the one of those welded to it that is nearest to the root."""
        heads = {self.root: self.root}
        for joint in self.joints:
            heads[joint.child] = heads[joint.parent] if joint.type == "fixed" else joint.child
        return heads


def tree_of(robot: Robot, file: Path, base: Literal["fixed", "free"] | None, notes: list[Note]) -> Tree:
    """The tree of a robot whose base is as asked for; a ScenarioError where it is none."""
    carried: dict[str, Joint] = {}
    for joint in robot.joints.values():
        if joint.child in carried:
            first = carried[joint.child]
            raise ScenarioError.at(
                f'{file}, line {joint.line}: link "{joint.child}"',
                f'is the child of two joints, "{first.name}" and "{joint.name}"',
                "URDF knows trees only: leave one of them out, or write the robot in MJCF and close the loop there",
            )
        carried[joint.child] = joint
    below = defaultdict(list)
    for joint in robot.joints.values():
        below[joint.parent].append(joint)
    roots = [name for name in robot.links if name not in carried]
    if len(roots) > 1:
        names = ", ".join(f'"{name}"' for name in roots[:4]) + (", ..." if len(roots) > 4 else "")
        remedy = f'join them, such as by fixed joints to a link "{WORLD}"'
        raise ScenarioError.at(f"{file}: links {names}", f"{len(roots)} links are the child of no joint", remedy)
    reached, order = set(roots), list[Joint]()
    ahead = [joint for root in roots for joint in reversed(below[root])]
    while ahead:
        joint = ahead.pop()
        order.append(joint)
        reached.add(joint.child)
        ahead += reversed(below[joint.child])
    lost = [name for name in robot.links if name not in reached]
    if lost:
        ring = _ring(lost[0], carried)
        raise ScenarioError.at(
            f"{file}, line {carried[ring[0]].line}: links " + ", ".join(f'"{name}"' for name in ring),
            "carry one another in a loop of joints",
            "URDF knows trees only: one link has to be the child of no joint",
        )
    return _based(Tree(robot, roots[0], order, base == "free"), file, base, notes)


def _ring(link: str, carried: dict[str, Joint]) -> list[str]:
    """The links of the loop to which one leads upwards."""
    path = [link]
    while (above := carried[path[-1]].parent) not in path:
        path.append(above)
    return path[path.index(above) :]


def _based(tree: Tree, file: Path, base: Literal["fixed", "free"] | None, notes: list[Note]) -> Tree:
    """With the base asked for, where the file has the ground as a link."""
    on_root = [joint for joint in tree.joints if joint.parent == tree.root]
    floating = [joint for joint in on_root if joint.type == "floating"]
    if base == "fixed" and floating:
        notes.append(Note("fixed, as asked for", tuple(f'joint "{x.name}"' for x in floating), lost=False))
        joints = [replace(joint, type="fixed") if joint in floating else joint for joint in tree.joints]
        return replace(tree, joints=joints)
    if base != "free" or tree.root != WORLD:
        return tree
    if floating:
        return replace(tree, free=False)
    if len(on_root) != 1 or on_root[0].type != "fixed":
        raise ScenarioError.at(
            f'{file}: link "{WORLD}"',
            f"cannot be a free base, it carries {len(on_root)} joints, and would have to carry one that is fixed",
            "import it as it is, or change the file",
        )
    notes.append(Note("left out, for a free base", (f'joint "{on_root[0].name}"',), lost=False))
    rest = [x for x in tree.joints if x is not on_root[0]]
    return replace(tree, root=on_root[0].child, joints=rest, placed=on_root[0].pose)


def check_masses(tree: Tree, file: Path, notes: list[Note]) -> frozenset[str]:
    """The links at the heads of those welded together that have no mass; a ScenarioError where that cannot move."""
    heads, links = tree.heads(), tree.robot.links
    groups = _together(tree, heads)
    moving = {joint.child: joint for joint in tree.joints if joint.type != "fixed"}
    moved = {head: group for head, group in groups.items() if head in moving or (head == tree.root and tree.free)}
    carry = {head: groups[head].mass for head in groups}
    for joint in reversed(tree.joints):
        if joint.type != "fixed":
            carry[heads[joint.parent]] += carry[joint.child]
    idle = [head for head in moved if carry[head] <= 0]
    if idle:
        first = links[idle[0]]
        more = f"; likewise {_listed(idle[1:])}" if idle[1:] else ""
        shapes = any(not shape.drawn for shape in first.shapes)
        collides = ", or give the density of its collision shapes (--density 1000)" if shapes else ""
        how = f'moves by joint "{moving[first.name].name}"' if first.name in moving else "is a free base"
        raise ScenarioError.at(
            f'{file}, line {first.line}: link "{first.name}"',
            f"{how}, and neither it nor what it carries has mass{more}",
            f"give it an <inertial>, or make the joint fixed{collides}",
        )
    for head, group in moved.items():
        _check_inertia(f'{file}, line {links[head].line}: link "{head}"', head, group, heads, notes)
    for name, link in links.items():
        if link.inertial is not None and heads[name] in moved and groups[heads[name]] is not link.inertial:
            moments = _moments(link.inertial)
            if moments[0] < -ROUNDING * abs(moments).max() or _too_long(moments):
                notes.append(
                    Note(
                        f"{_BROKEN} {_three(moments)}: counted with what it is welded to",
                        (f'link "{name}"',),
                        lost=False,
                    )
                )
    return frozenset(head for head, group in moved.items() if group.mass <= 0)


_BROKEN = "no rigid body has its principal moments of inertia"


def _check_inertia(at: str, head: str, group: Inertial, heads: dict[str, str], notes: list[Note]) -> None:
    """Of what moves as one body."""
    moments = _moments(group)
    largest = float(np.abs(moments).max())
    welded = [name for name, above in heads.items() if above == head and name != head]
    whose = f" (with {_listed(welded)}, welded to it)" if welded else ""
    if group.mass <= 0:
        if largest > 0:
            rule = f"has moments of inertia {_three(moments)} kg m² and a mass of 0{whose}"
            raise ScenarioError.at(at, rule, "give its mass, or no <inertial> for a frame without mass")
        return
    if largest < SMALLEST:
        rule = f"has a mass of {group.mass:g} kg and moments of inertia of 0{whose}"
        raise ScenarioError.at(at, rule, "give the <inertia> of a body of that size in kg m²")
    if moments[0] <= 1e-14 * largest:
        rule = f"has principal moments of inertia {_three(moments)} kg m²{whose}, and all must be above 0"
        raise ScenarioError.at(at, rule, "check the signs of <inertia>, and that it is about the mass centre")
    if _too_long(moments):
        notes.append(
            Note(f"{_BROKEN} {_three(moments)}: one exceeds the sum of the others", (f'link "{head}"',), lost=False)
        )


def _moments(inertial: Inertial) -> Array:
    """The principal ones (3,) in kg m², least first."""
    return np.asarray(np.linalg.eigvalsh(inertial.tensor))


def _too_long(moments: Array) -> bool:
    return bool(moments[2] > (moments[0] + moments[1]) * (1 + ROUNDING))


def _three(moments: Array) -> str:
    return ", ".join(f"{x:.4g}" for x in moments)


def _listed(names: list[str]) -> str:
    shown = ", ".join(f'"{name}"' for name in names[:6])
    return f"{shown} and {len(names) - 6} others" if len(names) > 6 else shown


def _together(tree: Tree, heads: dict[str, str]) -> dict[str, Inertial]:
    """By head, the mass and inertia of all that is welded to it, in the frame of the head."""
    poses: dict[str, tuple[Array, Array]] = {tree.root: (np.zeros(3), np.eye(3))}
    for joint in tree.joints:
        if joint.type == "fixed":
            at, turned = poses[joint.parent]
            poses[joint.child] = at + turned @ joint.pose.at, turned @ joint.pose.rotation
        else:
            poses[joint.child] = np.zeros(3), np.eye(3)
    parts = defaultdict(list)
    for name, head in heads.items():
        found = tree.robot.links[name].inertial
        if found is not None:
            at, turned = poses[name]
            R = turned @ found.pose.rotation
            parts[head].append((found.mass, at + turned @ found.pose.at, R @ found.tensor @ R.T, found))
    together = {head: Inertial(0.0, np.zeros((3, 3)), Pose()) for head in heads.values()}
    for head, pieces in parts.items():
        if len(pieces) == 1:
            together[head] = pieces[0][3]
            continue
        mass = sum(m for m, *_ in pieces)
        centre = sum(m * c for m, c, *_ in pieces) / mass if mass > 0 else np.zeros(3)
        tensor = np.zeros((3, 3))
        for m, c, J, _ in pieces:
            d = c - centre
            tensor = tensor + J + m * (d @ d * np.eye(3) - np.outer(d, d))
        together[head] = Inertial(mass, tensor, Pose(np.asarray(centre)))
    return together
