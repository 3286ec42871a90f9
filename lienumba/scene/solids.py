"""A body as a solid: its own shapes, or the homogeneous box or cylinder that has its mass and its principal moments."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np

from lienumba.scenario.schema.shapes import Shape

SHAPES, NOTHING = "shapes", "nothing"
SIDES = 24  # of a cylinder
ALIKE = 0.05  # of two moments: what differs by less is drawn as round
THINNEST = 0.06  # of the longest edge: a plate is still seen from its edge

Face = tuple[int, ...]  # vertices in order around it, counterclockwise from outside


@dataclass(frozen=True)
class Solid:
    """kind: "box" or "cylinder" of equivalent inertia, "shapes", or "nothing"; vertices (n, 3) in m in the body frame,
    its origin the mass centre; faces: plane polygons, as indices of vertices; the two ends of a cylinder are its last
    two faces. colours: of each face, or empty where it has that of the body, as all have where there are none."""

    kind: str
    vertices: np.ndarray
    faces: tuple[Face, ...]
    colours: tuple[str, ...] = ()

    @property
    def radius(self) -> float:
        """The distance of the farthest vertex from the mass centre in m."""
        return float(sqrt((self.vertices**2).sum(axis=1).max(initial=0.0)))

    def triangles(self) -> list[tuple[int, int, int]]:
        """The faces cut into triangles of the same vertices."""
        return [(face[0], face[k], face[k + 1]) for face in self.faces for k in range(1, len(face) - 1)]


def equivalent(mass: float, inertia: tuple[float, ...]) -> Solid:
    """The solid of this mass (kg) and these xx yy zz xy xz yz (kg m^2) about the mass centre.

    A cylinder if exactly two principal moments are alike, else a box: of a box with edges a, b, c
    I1 = m (b^2 + c^2) / 12, so a^2 = 6 (I2 + I3 - I1) / m; of a cylinder I1 = m r^2 / 2, I2 = m (3 r^2 + h^2) / 12.
    """
    xx, yy, zz, xy, xz, yz = inertia
    moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], float))
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    axis = _axis_of_symmetry(moments)
    if axis is None:
        a, b, c = (sqrt(max(6.0 * (moments.sum() - 2.0 * moment) / mass, 0.0)) for moment in moments)
        return Solid("box", _thick(np.array([a, b, c])) * _corners() @ axes.T, _BOX)
    across = (moments.sum() - moments[axis]) / 2.0
    radius = sqrt(2.0 * moments[axis] / mass)
    length = sqrt(max(12.0 * across / mass - 3.0 * radius**2, 0.0))
    edges = _thick(np.array([2.0 * radius, 2.0 * radius, length]))
    turned = axes[:, [(axis + 1) % 3, (axis + 2) % 3, axis]]
    return Solid("cylinder", edges * _ring() @ turned.T, _CYLINDER)


def looking(shapes: Iterable[Shape], colour: str = "") -> Solid:
    """All shapes of a body as one, in triangles; nothing if there are none. colour: of those that have none."""
    vertices: list[np.ndarray] = [np.zeros((0, 3))]
    faces: list[Face] = []
    colours: list[str] = []
    count = 0
    for shape in shapes:
        corners, triangles = shape.placed()
        vertices.append(corners)
        faces += map(tuple, (triangles + count).tolist())
        colours += [shape.colour or colour] * len(triangles)
        count += len(corners)
    return Solid(SHAPES if faces else NOTHING, np.concatenate(vertices), tuple(faces), tuple(colours))


def _axis_of_symmetry(moments: np.ndarray) -> int | None:
    """The principal axis about which the other two are alike, if there is just one."""
    low, middle, high = moments
    first, second = middle - low < ALIKE * high, high - middle < ALIKE * high
    return None if first == second else (2 if first else 0)


def _thick(edges: np.ndarray) -> np.ndarray:
    """No edge far shorter than the longest one."""
    return np.maximum(edges, THINNEST * edges.max())


def _corners() -> Any:
    return np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def _ring() -> Any:
    """The vertices of a cylinder of diameter 1 and height 1 about z."""
    turns = [2.0 * pi * k / SIDES for k in range(SIDES)]
    return np.array([[0.5 * cos(u), 0.5 * sin(u), z] for z in (-0.5, 0.5) for u in turns])


_BOX: tuple[Face, ...] = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
_CYLINDER: tuple[Face, ...] = (
    *((k, (k + 1) % SIDES, (k + 1) % SIDES + SIDES, k + SIDES) for k in range(SIDES)),
    tuple(range(SIDES - 1, -1, -1)),
    tuple(range(SIDES, 2 * SIDES)),
)
