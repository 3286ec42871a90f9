"""The tree of a robot's links, its base, and the joints that mimic others."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from lienumba.errors import ScenarioError
from lienumba.importing.notes import Note
from lienumba.importing.urdf.robot import Joint, Pose, Robot

WORLD = "world"  # the link that ROS and MuJoCo hold to be the ground


@dataclass(frozen=True)
class Tree:
    """root: the link that hangs on nothing; joints: each behind that which carries its parent; free: the root moves;
    placed: where it stands on the ground, or is at first."""

    robot: Robot
    root: str
    joints: list[Joint]
    free: bool
    placed: Pose = field(default_factory=Pose)


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


def mimics(robot: Robot, file: Path) -> Iterator[tuple[str, str, float, float]]:
    """(joint, the other, multiplier, offset): q = multiplier * q of the other + offset; the other has no mimic.

    Where the other does not move, it is "" and q = offset.
    """
    for joint in robot.joints.values():
        if joint.mimic is None:
            continue
        other, multiplier, offset = joint, 1.0, 0.0
        passed = [joint.name]
        while other.mimic is not None:
            offset += multiplier * other.mimic.offset
            multiplier *= other.mimic.multiplier
            other = robot.joints[other.mimic.joint]
            if other.name in passed:
                raise ScenarioError.at(
                    f'{file}, line {joint.line}: joint "{joint.name}"',
                    "mimics itself" + "".join(f', by "{name}"' for name in passed[1:]),
                    "leave out the <mimic> of one of them",
                )
            passed.append(other.name)
        if not other.has_coordinate and other.type != "fixed":
            rule = f'mimics "{other.name}", which is {other.type} and has no single coordinate'
            raise ScenarioError.at(
                f'{file}, line {joint.line}: joint "{joint.name}"', rule, "mimic a joint with one coordinate"
            )
        moves = other.type != "fixed" and multiplier != 0
        yield joint.name, other.name if moves else "", multiplier if moves else 0.0, offset
