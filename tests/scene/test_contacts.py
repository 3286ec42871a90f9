"""Outlines of contacts: across their axes, at the right distances."""

import numpy as np
import pytest

from lienumba.mechanics.mechanism.model import Contact
from lienumba.scene.contacts import outlines
from tests.facade import GROUND

POINTS = ((0.1, 0.2, 0.3), (1.0, 2.0, 3.0))


def test_a_plane_and_a_wheel():
    contact = Contact(
        "c",
        "cylinder_plane",
        (0, GROUND),
        POINTS,
        normal=(0.0, 3.0, 4.0),
        axis=(1.0, 1.0, 0.0),
        numbers={"radius": 0.5},
    )
    (ground, plane), (wheel, circle) = outlines(contact, 2.0)
    assert (ground, wheel) == (GROUND, 0)
    assert (np.array(plane) - POINTS[1]) @ contact.normal == pytest.approx(np.zeros(4), abs=1e-12)
    assert np.linalg.norm(np.diff(plane, axis=0), axis=1) == pytest.approx(np.full(3, 2.0))
    assert (np.array(circle) - POINTS[0]) @ contact.axis == pytest.approx(np.zeros(16), abs=1e-12)
    assert np.linalg.norm(np.array(circle) - POINTS[0], axis=1) == pytest.approx(np.full(16, 0.5))


def test_two_spheres():
    radii = {"first_radius": 0.5, "second_radius": 0.25}
    found = dict(outlines(Contact("c", "sphere_sphere", (0, 1), POINTS, numbers=radii), 1.0))
    for body, radius in enumerate(radii.values()):
        assert np.linalg.norm(np.array(found[body]) - POINTS[body], axis=1) == pytest.approx(np.full(16, radius))
