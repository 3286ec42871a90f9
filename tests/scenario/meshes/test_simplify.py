"""Simplified and packed meshes: few triangles, near to the surface, nothing lost, the same text again."""

import re

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lienumba.errors import BadValueError
from lienumba.scenario.meshes import surfaces
from lienumba.scenario.meshes.packing import packed, packed_mesh, unpacked
from lienumba.scenario.meshes.simplify import simplified


def torus(count, wide=1.0, thick=0.3):
    u, v = np.meshgrid(*[np.arange(count) * 2 * np.pi / count] * 2, indexing="ij")
    out = wide + thick * np.cos(v)
    vertices = np.stack([out * np.cos(u), out * np.sin(u), thick * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    a, b, c, d = ((x % count * count + y % count).ravel() for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    return vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def soup(surface):
    """Each triangle with corners of its own, as STL has them."""
    return surface[0][surface[1]].reshape(-1, 3), np.arange(surface[1].size).reshape(-1, 3)


def beside(first, second, shift):
    return np.concatenate([first[0], second[0] + shift]), np.concatenate([first[1], second[1] + len(first[0])])


def samples(surface, count=4000):
    corners = surface[0][surface[1]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    random = np.random.default_rng(1)
    chosen, share = random.choice(len(area), count, p=area / area.sum()), random.dirichlet([1, 1, 1], count)
    return np.einsum("nk,nkc->nc", share, corners[chosen])


def hausdorff(first, second):
    """The largest distance from points of one surface to a dense sample of the other."""
    dense = [cKDTree(samples(x, 40_000)) for x in (first, second)]
    return max(dense[1].query(samples(first))[0].max(), dense[0].query(samples(second))[0].max())


@pytest.mark.parametrize("most", [40, 300, 1000])
def test_a_torus_stays_one(most):
    whole = torus(70)
    found = simplified(*soup(whole), most)
    assert 0.9 * most < len(found[1]) <= most
    assert hausdorff(found, whole) < {40: 0.35, 300: 0.08, 1000: 0.05}[most]
    edges = np.sort(found[1][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # closed
    assert len(found[0]) - len(found[1]) / 2 == 0  # with one hole


def test_flat_faces_take_the_fewest_triangles_and_keep_their_edges():
    corners, faces = surfaces.box([1, 2, 3])
    for _ in range(4):  # each triangle into four
        a, b, c = corners[faces].swapaxes(0, 1)
        middle = [(x + y) / 2 for x, y in ((a, b), (b, c), (c, a))]
        parts = [(a, middle[0], middle[2]), (middle[0], b, middle[1]), (middle[2], middle[1], c), tuple(middle)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts]).reshape(-1, 3)
        faces = np.arange(len(corners)).reshape(-1, 3)
    found = simplified(corners, faces, 12)
    assert len(found[1]) == 12
    assert np.ptp(found[0], axis=0) == pytest.approx([1, 2, 3], abs=1e-2)


def test_no_part_is_lost():
    parts = beside(torus(40), surfaces.ellipsoid([0.1] * 3), [0, 0, 2])
    parts = beside(parts, surfaces.capsule(0.1, 4), [3, 0, 0])
    found = simplified(*parts, 200)
    assert len(found[1]) <= 200
    assert np.ptp(found[0], axis=0) == pytest.approx(np.ptp(parts[0], axis=0), rel=0.03)
    assert hausdorff(found, parts) < 0.15


def test_few_triangles_stay_as_they_are():
    found = simplified(*soup(surfaces.box([1, 2, 3])), 12)
    assert len(found[0]) == 8
    assert len(found[1]) == 12


def test_packed_meshes_are_small_and_near():
    whole = torus(70)
    mesh = packed_mesh(*soup(whole), 1000)
    assert mesh == packed_mesh(*soup(whole), 1000)
    assert len(mesh["data"]) < 11_000
    assert hausdorff(unpacked(mesh["data"]), whole) < 0.05
    exact = surfaces.ellipsoid([1, 2, 3])
    again = unpacked(packed(*exact))
    same = [np.sort(x[0][x[1]].round(3).reshape(-1, 9), axis=0) for x in (exact, again)]
    assert same[0] == pytest.approx(same[1], abs=2e-3)


@pytest.mark.parametrize("text", ["", "abc", "eJxjYGBgAAAABAAB", packed(*surfaces.box([1, 1, 1]))[:-8], "é"])
def test_other_text_is_no_mesh(text):
    with pytest.raises(BadValueError, match=re.escape("is no packed mesh")):
        unpacked(text)
