"""Solids of equivalent inertia, their mass properties taken from the faces alone by the divergence theorem."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lienumba.scene.solids import SIDES, THINNEST, Solid, equivalent


def mass_properties(solid: Solid) -> tuple[float, np.ndarray, np.ndarray]:
    """Volume, first moment, second moment of the solid: signed tetrahedra from the origin to each triangle."""
    a, b, c = (solid.vertices[[face[k] for face in solid.triangles()]] for k in range(3))
    volumes = np.einsum("ni,ni->n", a, np.cross(b, c)) / 6.0
    corners = np.stack([a, b, c], axis=1)
    total = corners.sum(axis=1)
    first = (volumes[:, None] * total / 4.0).sum(axis=0)
    products = np.einsum("nki,nkj->nij", corners, corners) + np.einsum("ni,nj->nij", total, total)
    return volumes.sum(), first, (volumes[:, None, None] * products / 20.0).sum(axis=0)


def inertia_of(solid: Solid, mass: float) -> np.ndarray:
    """About the origin, of this mass spread evenly."""
    volume, _, second = mass_properties(solid)
    J = second * mass / volume
    return np.trace(J) * np.eye(3) - J


def six(tensor: np.ndarray) -> tuple[float, ...]:
    return tuple(tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


edges = st.floats(0.2, 1.0)  # thinner ones are drawn thicker
quaternions = st.tuples(*4 * [st.floats(-1, 1)]).filter(lambda q: np.linalg.norm(q) > 0.1)


@settings(max_examples=60)
@given(st.tuples(edges, edges, edges), quaternions, st.floats(1e-3, 1e4))
def test_a_box_is_found_again(size, turn, mass):
    a, b, c = np.array(size) * [1.0, 1.3, 1.7]
    R = Rotation.from_quat(turn).as_matrix()
    tensor = R @ np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) @ R.T * mass / 12.0
    solid = equivalent(mass, six(tensor))
    volume, first, _ = mass_properties(solid)
    assert volume > 0.0, "faces are counterclockwise from outside"
    assert first == pytest.approx(np.zeros(3), abs=1e-12)
    assert inertia_of(solid, mass) == pytest.approx(tensor, rel=0.06, abs=0.03 * np.trace(tensor))
    if solid.kind == "box":
        assert inertia_of(solid, mass) == pytest.approx(tensor, rel=1e-9, abs=1e-9 * np.trace(tensor))
        assert volume == pytest.approx(a * b * c, rel=1e-9)


@pytest.mark.parametrize(("radius", "length"), [(0.2, 1.5), (0.5, 0.2), (0.3, 2.0)])
def test_a_cylinder_is_found_again(radius, length):
    R = Rotation.from_rotvec([0.3, -1.2, 0.5]).as_matrix()
    across = (3.0 * radius**2 + length**2) / 12.0
    tensor = R @ np.diag([across, across, 0.5 * radius**2]) @ R.T * 7.0
    solid = equivalent(7.0, six(tensor))
    assert (solid.kind, len(solid.vertices)) == ("cylinder", 2 * SIDES)
    along = solid.vertices @ R[:, 2]
    assert abs(along) == pytest.approx(0.5 * length)
    assert np.linalg.norm(solid.vertices - np.outer(along, R[:, 2]), axis=1) == pytest.approx(radius)
    assert inertia_of(solid, 7.0) == pytest.approx(tensor, rel=0.02)


def test_what_has_no_thickness_is_seen_from_its_edge():
    disc = equivalent(15.0, (0.234375, 0.46875, 0.234375, 0.0, 0.0, 0.0))  # the paper's heavy top: r = 0.25 m, h = 0
    assert np.ptp(disc.vertices[:, 1]) == pytest.approx(THINNEST * 0.5)
    assert np.hypot(disc.vertices[:, 0], disc.vertices[:, 2]) == pytest.approx(0.25)
    rod = equivalent(2.0, (0.5, 0.0, 0.5, 0.0, 0.0, 0.0))
    assert np.ptp(rod.vertices[:, 1]) == pytest.approx(np.sqrt(3.0))
    impossible = equivalent(1.0, (0.35, 0.35, 0.9, 0.0, 0.0, 0.0))
    assert np.isfinite(impossible.vertices).all()


def test_a_cube_is_no_cylinder():
    cube = equivalent(6.0, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    assert cube.kind == "box"
    assert np.ptp(cube.vertices, axis=0) == pytest.approx(3 * [1.0])
