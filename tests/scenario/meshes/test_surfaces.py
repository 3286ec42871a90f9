"""Surfaces of solids: volumes, areas and boxes against closed forms, the volume by the divergence theorem."""

from math import pi

import numpy as np
import pytest

from lienumba.scenario.meshes import surfaces
from lienumba.scenario.schema.shapes import SHAPES

TURN = 2 * pi / surfaces.SIDES
POLYGON = 0.5 * surfaces.SIDES * np.sin(TURN)  # the area of the polygon in a circle of radius 1


def volume_of(surface):
    a, b, c = surface[0][surface[1]].swapaxes(0, 1)
    return np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0


def area_of(surface):
    a, b, c = surface[0][surface[1]].swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def is_closed(surface):
    """Each edge is there once in each direction."""
    edges = [(x, y) for a, b, c in surface[1].tolist() for x, y in ((a, b), (b, c), (c, a))]
    return len(set(edges)) == len(edges) and {(y, x) for x, y in edges} == set(edges)


def shape(kind, **keys):
    return SHAPES[kind].model_validate({"type": kind, **keys})


def test_a_box():
    found = surfaces.box([1, 2, 3])
    assert volume_of(found) == pytest.approx(6)
    assert area_of(found) == pytest.approx(22)
    assert is_closed(found)


@pytest.mark.parametrize("length", [0.1, 3.0])
def test_a_cylinder(length):
    found = surfaces.cylinder(0.5, length)
    assert volume_of(found) == pytest.approx(POLYGON * 0.25 * length)
    assert area_of(found) == pytest.approx(POLYGON * 0.5 + surfaces.SIDES * np.sin(TURN / 2) * length)
    assert np.ptp(found[0], axis=0) == pytest.approx([1, 1, length])
    assert is_closed(found)


@pytest.mark.parametrize(("radius", "length"), [(1.0, 1e-9), (0.2, 3.0)])
def test_a_capsule_and_a_ball(radius, length):
    found = surfaces.capsule(radius, length)
    ball = 4 / 3 * pi * radius**3
    assert volume_of(found) == pytest.approx(ball + pi * radius**2 * length, rel=0.03)
    assert volume_of(found) < ball + pi * radius**2 * length
    assert area_of(found) == pytest.approx(4 * pi * radius**2 + 2 * pi * radius * length, rel=0.02)
    assert np.ptp(found[0], axis=0) == pytest.approx([2 * radius, 2 * radius, length + 2 * radius])
    assert is_closed(found)


def test_an_ellipsoid():
    found = surfaces.ellipsoid([1, 2, 3])
    assert volume_of(found) == pytest.approx(8 * pi, rel=0.03)
    assert np.ptp(found[0], axis=0) == pytest.approx([2, 4, 6])
    assert (found[0] / [1, 2, 3] ** np.array(1)) ** 2 @ np.ones(3) == pytest.approx(np.ones(len(found[0])))
    assert is_closed(found)


def test_a_rotation_turns_before_the_position_moves():
    corners, _ = shape(
        "box", size=[2, 4, 6], position=[10, 0, 0], rotation={"axis": [0, 0, 1], "angle": pi / 2}
    ).placed()
    assert corners.min(axis=0) == pytest.approx([8, -1, -3])
    assert corners.max(axis=0) == pytest.approx([12, 1, 3])


@pytest.mark.parametrize("way", [[0, 0, 1], [0, 0, -1], [1, 0, 0], [1, -2, 3]])
def test_ends_say_where_a_capsule_is(way):
    first, last = np.array([1.0, 2, 3]), np.array([1.0, 2, 3]) + way
    found = shape("capsule", radius=0.1, ends=[first.tolist(), last.tolist()]).placed()
    between = np.clip((found[0] - first) @ (last - first) / (np.array(way) @ way), 0, 1)[:, None]
    away = np.linalg.norm(found[0] - first - between * (last - first), axis=1)
    assert away == pytest.approx(np.full(len(away), 0.1))
    assert volume_of(found) > 0


def test_a_mirrored_mesh_has_its_outside_outside():
    from lienumba.scenario.meshes.packing import packed

    mesh = shape("mesh", data=packed(*surfaces.box([1, 1, 1])), scale=[-2, 1, 1])
    assert volume_of(mesh.placed()) == pytest.approx(2, rel=1e-4)
