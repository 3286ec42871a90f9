"""Joints as residuals. A joint is one function that vanishes where the joint holds; nothing else is written down.

A residual takes the placements (r, R) of its two bodies and returns its rows, in metres. Velocity and acceleration
equations are derived from it (`lienumba.mechanics.constraints`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.model import Joint, Model

Placement = tuple[Any, Any]  # r (3), R (9)


@dataclass(frozen=True)
class JointType:
    rows: int
    residual: Callable[[Joint, Placement, Placement], tuple[Any, ...]]


def separation(joint: Joint, a: Placement, b: Placement) -> Any:
    """The vector from the point on the second body to the point on the first, global frame."""
    p, q = joint.points
    return so3.subtract(so3.add(a[0], so3.rotate(a[1], p)), so3.add(b[0], so3.rotate(b[1], q)))


def spherical(joint: Joint, a: Placement, b: Placement) -> tuple[Any, ...]:
    """The two points coincide."""
    return separation(joint, a, b)


def distance(joint: Joint, a: Placement, b: Placement) -> tuple[Any, ...]:
    """The two points keep their distance L: (d.d/L - L)/2, which is |d| - L to first order."""
    d = separation(joint, a, b)
    return (0.5 * (so3.dot(d, d) / joint.length - joint.length),)


JOINT_TYPES: dict[str, JointType] = {
    "spherical": JointType(3, spherical),
    "distance": JointType(1, distance),
}


def rows_of(model: Model) -> list[slice]:
    """Which rows of Phi belong to each joint."""
    slices: list[slice] = []
    first = 0
    for joint in model.joints:
        slices.append(slice(first, first + JOINT_TYPES[joint.type].rows))
        first = slices[-1].stop
    return slices
