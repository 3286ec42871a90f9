"""What a URDF file says: links, joints, shapes, as numbers in SI units. Frames: of links, as URDF has them."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lienumba.groups import so3

Array = NDArray[np.float64]
JointType = Literal["revolute", "continuous", "prismatic", "fixed", "floating", "planar"]
JOINT_TYPES: tuple[JointType, ...] = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


@dataclass(frozen=True)
class Pose:
    """at (3,): in m; quaternion (4,): w x y z."""

    at: Array = field(default_factory=lambda: np.zeros(3))
    quaternion: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))

    @property
    def rotation(self) -> Array:
        """(3, 3), from its own axes to those in which it stands."""
        return np.array(so3.from_quaternion(tuple(self.quaternion))).reshape(3, 3)


@dataclass(frozen=True)
class Inertial:
    """mass in kg; tensor (3, 3) in kg m², about the mass centre, along the axes of `pose`, which is in the link."""

    mass: float
    tensor: Array
    pose: Pose


@dataclass(frozen=True)
class Shape:
    """kind: box, sphere, cylinder, capsule with MuJoCo's size, or mesh with file and scale; drawn: else collides."""

    kind: str
    size: tuple[float, ...]
    pose: Pose
    drawn: bool
    rgba: tuple[float, ...] | None = None
    file: str = ""
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Link:
    """A rigid body, or a frame only."""

    name: str
    line: int
    inertial: Inertial | None
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Mimic:
    """The joint's coordinate is multiplier * that of the other + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """Joins `child` to `parent`; pose: of the child's frame in the parent's, where coordinates are 0.

    axis (3,): unit vector in the child's frame; limits: in rad or m; effort: in N m or N, inf for none.
    """

    name: str
    line: int
    type: JointType
    parent: str
    child: str
    pose: Pose
    axis: Array
    limits: tuple[float, float] | None
    effort: float
    damping: float
    friction: float
    mimic: Mimic | None

    @property
    def has_coordinate(self) -> bool:
        """Whether one number says where it is."""
        return self.type in ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Robot:
    """links: by name; joints: by name; mesh_folder: as MuJoCo's extension of URDF names it."""

    name: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    mesh_folder: str = ""
