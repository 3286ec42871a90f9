"""Surfaces of solids as triangles, counterclockwise from outside, each about its own origin."""

from collections.abc import Sequence
from itertools import pairwise, product
from math import ceil, cos, pi, sin

import numpy as np

Surface = tuple[np.ndarray, np.ndarray]  # vertices (n, 3) in m, triangles (m, 3) of their indices

SIDES = 24  # around an axis
MOST_PARTS = 8  # along a cylinder
RINGS = 6  # from a pole of a ball to its equator
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # of a box


def box(size: Sequence[float]) -> Surface:
    """A box with these edges along x, y and z."""
    corners = np.array([*product((-0.5, 0.5), repeat=3)]) * np.array(size)
    return corners, np.array([half for a, b, c, d in QUADS for half in ((a, b, c), (a, c, d))])


def ellipsoid(radii: Sequence[float]) -> Surface:
    """An ellipsoid with these half axes along x, y and z."""
    vertices, faces = _turned(_arc(-pi / 2, pi / 2, 2 * RINGS))
    return vertices * np.array(radii), faces


def cylinder(radius: float, length: float) -> Surface:
    """A cylinder along z."""
    return _turned([(0.0, -0.5 * length), *_side(radius, length), (0.0, 0.5 * length)])


def capsule(radius: float, length: float) -> Surface:
    """A cylinder of this length along z between two half balls."""
    half = 0.5 * length
    below = [(radius * r, radius * z - half) for r, z in _arc(-pi / 2, 0.0, RINGS)]
    above = [(radius * r, radius * z + half) for r, z in _arc(0.0, pi / 2, RINGS)]
    return _turned([*below, *_side(radius, length)[1:-1], *above])


def _side(radius: float, length: float) -> list[tuple[float, float]]:
    """Points along a cylinder, no farther apart than it is thick, so that drawings can tell what lies before what."""
    parts = min(max(ceil(0.5 * length / radius), 1), MOST_PARTS)
    return [(radius, length * (n / parts - 0.5)) for n in range(parts + 1)]


def _arc(first: float, last: float, steps: int) -> list[tuple[float, float]]:
    """Points of the unit circle as distances from z and heights; those at the poles exactly."""
    angles = [first + (last - first) * n / steps for n in range(steps + 1)]
    return [(0.0 if abs(u) == pi / 2 else cos(u), sin(u)) for u in angles]


def _turned(profile: list[tuple[float, float]]) -> Surface:
    """What a line turned around z leaves, from one point on z up to another; it is given by distances and heights."""
    turns = np.arange(SIDES) * (2.0 * pi / SIDES)
    rings = [np.column_stack([r * np.cos(turns), r * np.sin(turns), np.full(SIDES, z)]) for r, z in profile[1:-1]]
    poles = [[0.0, 0.0, z] for _, z in (profile[0], profile[-1])]
    k, after = np.arange(SIDES), np.roll(np.arange(SIDES), -1)
    faces = []
    for low, high in pairwise(range(len(rings))):
        a, b, c, d = SIDES * low + k, SIDES * low + after, SIDES * high + after, SIDES * high + k
        faces += [np.column_stack([a, b, c]), np.column_stack([a, c, d])]
    bottom, last = SIDES * len(rings), SIDES * (len(rings) - 1)
    faces.append(np.column_stack([np.full(SIDES, bottom), after, k]))
    faces.append(np.column_stack([np.full(SIDES, bottom + 1), last + k, last + after]))
    return np.concatenate([*rings, poles]), np.concatenate(faces)
