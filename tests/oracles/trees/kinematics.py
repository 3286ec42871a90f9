"""Joints as textbooks draw them: from a joint's coordinates to where its second body is, or its first.

Angles, displacements and their bodies' poses may be complex and have any common shape (...).
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

Array = np.ndarray
Place = tuple[Array, Array]
GROUND: Place = (np.zeros(3), np.eye(3))


def vector(*parts: Any) -> Array:
    found = np.empty((*np.broadcast(*parts).shape, len(parts)), np.result_type(*parts))
    for i, part in enumerate(parts):
        found[..., i] = part
    return found


def turned(R: Array, u: Array) -> Array:
    """R u."""
    return (R @ u[..., None])[..., 0]


def hat(u: Array) -> Array:
    found = np.zeros((*u.shape, 3), u.dtype)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[..., k, j], found[..., j, k] = u[..., i], -u[..., i]
    return found


def exponential(u: Array) -> Array:
    """The rotation by a vector, after Rodrigues."""
    s = (u * u).sum(axis=-1)[..., None, None]
    near = abs(s) < 1e-3
    angle = np.sqrt(np.where(near, 1.0, s))
    sine = np.where(near, 1 - s / 6 + s**2 / 120 - s**3 / 5040 + s**4 / 362880, np.sin(angle) / angle)
    cosine = np.where(near, 1 / 2 - s / 24 + s**2 / 720 - s**3 / 40320, (1 - np.cos(angle)) / angle**2)
    U = hat(u)
    return np.eye(3) + sine * U + cosine * (U @ U)


def about_x(angle: Any) -> Array:
    return exponential(vector(angle, 0 * angle, 0 * angle))


def about_z(angle: Any) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    found = np.zeros((*np.shape(c), 3, 3), np.result_type(c))
    found[..., 0, 0] = found[..., 1, 1] = c
    found[..., 1, 0], found[..., 0, 1], found[..., 2, 2] = s, -s, 1.0
    return found


def frame(axis: Any, reference: Any) -> Array:
    """Columns x y z: z the axis, x the reference as far as it is across it."""
    z = np.array(axis, float) / np.linalg.norm(axis)
    x = np.array(reference, float)
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


@dataclass(frozen=True)
class Joint:
    """Between two bodies by name: points, axes and references in their own frames; says: more keys of the scenario."""

    name: str
    type: str
    bodies: tuple[str, str]
    points: tuple[Any, Any] = ((0, 0, 0), (0, 0, 0))
    axes: tuple[Any, Any] = ((0, 0, 1), (0, 0, 1))
    references: tuple[Any, Any] = ((1, 0, 0), (1, 0, 0))
    says: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def frames(self) -> tuple[Array, Array]:
        return frame(self.axes[0], self.references[0]), frame(self.axes[1], self.references[1])

    def carry(self, base: Place, relative: Place, base_is_first: bool = True) -> Place:
        """The pose of one body from the other's.

        relative: the second point (..., 3) and the second frame (..., 3, 3) as seen in the first.
        """
        (r, R), (d, Q) = base, relative
        A, B = self.frames
        p, q = (np.array(x, float) for x in self.points)
        if base_is_first:
            other = R @ A @ Q @ B.T
            return r + turned(R, p + turned(A, d)) - turned(other, q), other
        other = R @ B @ np.swapaxes(Q, -1, -2) @ A.T
        return r + turned(R, q) - turned(other, p + turned(A, d)), other


HALF = 0.5 * np.pi


def _swivel(first: Any, second: Any) -> Array:
    """A turn about the first axis and one about the second, which is perpendicular to it."""
    return about_z(first) @ about_x(HALF) @ about_z(second)


def relative(kind: str, c: list[Any], size: float = 0.0) -> Place:
    """The second frame as seen in the first, from the coordinates of a joint of this type; size: length or pitch."""
    o = 0 * c[0] if c else np.zeros(())
    still = vector(o, o, o)
    if kind == "spherical":
        return still, exponential(vector(*c))
    if kind == "revolute":
        return still, about_z(c[0])
    if kind == "universal":
        return still, _swivel(c[0], c[1])
    if kind == "cylindrical":
        return vector(o, o, c[1]), about_z(c[0])
    if kind == "prismatic":
        return vector(o, o, c[0]), about_z(o)
    if kind == "fixed":
        return still, about_z(o)
    if kind == "planar":
        return vector(c[1], c[2], o), about_z(c[0])
    if kind == "point_on_line":
        return vector(o, o, c[0]), exponential(vector(*c[1:]))
    if kind == "point_in_plane":
        return vector(c[0], c[1], o), exponential(vector(*c[2:]))
    if kind == "distance":
        return size * exponential(vector(c[0], c[1], o))[..., 2], exponential(vector(*c[2:]))
    if kind == "parallel_axes":
        return vector(*c[1:]), about_z(c[0])
    if kind == "perpendicular_axes":
        return vector(*c[2:]), _swivel(c[0], c[1])
    assert kind == "screw"
    return vector(o, o, c[0] * size / (2 * np.pi)), about_z(c[0])


COORDINATES = {
    "spherical": 3, "revolute": 1, "universal": 2, "cylindrical": 2, "prismatic": 1, "fixed": 0, "planar": 3,
    "point_on_line": 4, "point_in_plane": 5, "distance": 5, "parallel_axes": 4, "perpendicular_axes": 5, "screw": 1,
}  # fmt: skip
