"""Joints of URDF that mimic others, each by the joint at the end of the chain."""

from collections.abc import Iterator
from pathlib import Path

from lienumba.errors import ScenarioError
from lienumba.importing.urdf.robot import Robot


def resolved(robot: Robot, file: Path) -> Iterator[tuple[str, str, float, float]]:
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
