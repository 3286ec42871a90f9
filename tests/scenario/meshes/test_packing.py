"""Packed meshes: each vertex once, near to the surface, the same text again."""

import re

import numpy as np
import pytest

from lienumba.errors import BadValueError
from lienumba.scenario.meshes import surfaces
from lienumba.scenario.meshes.packing import MOST, merged, packed, packed_mesh, unpacked


def soup(surface):
    """Each triangle with corners of its own, as STL has them."""
    return surface[0][surface[1]].reshape(-1, 3), np.arange(surface[1].size).reshape(-1, 3)


def test_vertices_become_one_and_triangles_without_area_go():
    corners, faces = soup(surfaces.box([1, 2, 3]))
    found = merged(corners, np.concatenate([faces, faces[:2], [[0, 0, 1]]]))
    assert len(found[0]) == 8
    assert len(found[1]) == 12
    assert np.ptp(found[0], axis=0) == pytest.approx([1, 2, 3])


def test_packed_meshes_are_small_and_near():
    exact = surfaces.ellipsoid([1, 2, 3])
    mesh = packed_mesh(*soup(exact))
    assert mesh == packed_mesh(*soup(exact))
    assert len(mesh["data"]) < 12 * len(exact[1])
    for again in (unpacked(mesh["data"]), unpacked(packed(*exact))):
        same = [np.sort(x[0][x[1]].round(3).reshape(-1, 9), axis=0) for x in (exact, again)]
        assert same[0] == pytest.approx(same[1], abs=2e-3)


def test_too_many_triangles_are_refused():
    ends = np.random.default_rng(1).normal(size=(3 * MOST + 3, 3))
    with pytest.raises(BadValueError, match=r"has 20,001 triangles, of which a shape takes 20,000 at most"):
        packed_mesh(ends, np.arange(len(ends)).reshape(-1, 3))


@pytest.mark.parametrize("text", ["", "abc", "eJxjYGBgAAAABAAB", packed(*surfaces.box([1, 1, 1]))[:-8], "é"])
def test_other_text_is_no_mesh(text):
    with pytest.raises(BadValueError, match=re.escape("is no packed mesh")):
        unpacked(text)
