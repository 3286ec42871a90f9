"""Contacts against vector geometry in NumPy, written for finite bodies, and against differences of their gaps."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from lienumba.groups import so3
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.contacts.geometry import tangents
from lienumba.mechanics.mechanism.kinematics import FIXED, Motion, View, columns, moving
from lienumba.mechanics.mechanism.model import Contact
from lienumba.numerics.jets import lift

RNG = np.random.default_rng(20)
TYPES = [name for name in CONTACTS if name != "capsule_plane"]  # which is two spheres


def motion(rng: np.random.Generator) -> Motion:
    R = Rotation.random(random_state=rng.integers(1 << 31)).as_matrix()
    r, v, w = rng.normal(size=(3, 3))
    return Motion(tuple(r), tuple(R.ravel()), tuple(v), tuple(w))


def contact(kind: str, rng: np.random.Generator) -> Contact:
    n, u = (x / np.linalg.norm(x) for x in rng.normal(size=(2, 3)))
    p, q = rng.normal(size=(2, 3))
    numbers = {"radius": 0.3} if kind != "sphere_sphere" else {"first_radius": 0.3, "second_radius": 0.2}
    return Contact("c", kind, (0, 1), (tuple(p), tuple(q)), tuple(n), tuple(u), numbers)


def matrix(m: Motion) -> np.ndarray:
    return np.array(m.R).reshape(3, 3)


def at(m: Motion, p: object) -> np.ndarray:
    return np.array(m.r) + matrix(m) @ np.array(p)


def after(m: Motion, t: float) -> Motion:
    R = matrix(m) @ Rotation.from_rotvec(t * np.array(m.w)).as_matrix()
    return Motion(tuple(np.array(m.r) + t * np.array(m.v)), tuple(R.ravel()), m.v, m.w)


def measured(c: Contact, a: Motion, b: Motion) -> tuple[float, np.ndarray, np.ndarray]:
    """Gap, point and normal (global)."""
    centre, q, n = at(a, c.points[0]), at(b, c.points[1]), matrix(b) @ np.array(c.normal)
    if c.type == "point_plane":
        return float(n @ (centre - q)), centre, n
    if c.type == "sphere_plane":
        return float(n @ (centre - q)) - 0.3, centre - 0.3 * n, n
    if c.type == "sphere_sphere":
        d = centre - q
        n = d / np.linalg.norm(d)
        return float(np.linalg.norm(d)) - 0.5, centre - 0.3 * n, n
    axis = matrix(a) @ np.array(c.axis)
    across = np.linalg.svd(axis[None])[2][1:]

    def edge(angle: float) -> np.ndarray:
        return centre + 0.3 * (np.cos(angle) * across[0] + np.sin(angle) * across[1])

    low = min(np.linspace(0.0, 2 * np.pi, 200), key=lambda x: n @ edge(x))
    found = minimize_scalar(lambda x: n @ edge(x), bracket=(low - 0.1, low, low + 0.1), tol=1e-14).x
    return float(n @ (edge(found) - q)), edge(found), n


@pytest.mark.parametrize("kind", TYPES)
def test_gap_and_slip_are_those_of_geometry(kind: str) -> None:
    for _ in range(20):
        c, a, b = contact(kind, RNG), motion(RNG), motion(RNG)
        gap, point, _ = measured(c, a, b)
        assert CONTACTS[kind].gap(c, a, b) == pytest.approx(gap, abs=1e-12)
        place = CONTACTS[kind].place(c, a, b)
        np.testing.assert_allclose(place.point, point, atol=1e-7)
        va, vb = (np.array(m.v) + np.cross(matrix(m) @ m.w, point - np.array(m.r)) for m in (a, b))
        expected = [(matrix(b) @ t) @ (va - vb) for t in tangents(place.normal)]
        np.testing.assert_allclose(CONTACTS[kind].rates(c, a, b), expected, atol=1e-6)


@pytest.mark.parametrize("kind", TYPES)
def test_rate_of_the_gap_is_the_normal_velocity_and_the_derivative(kind: str) -> None:
    """n.(v_a - v_b) at the contact: then a normal force does no work on what slides or rolls."""
    c, a, b = contact(kind, RNG), motion(RNG), motion(RNG)
    view = moving(View({0: a, 1: b}, 0.0, {}))
    jet = lift(CONTACTS[kind].gap(c, view[0], view[1]))
    _, point, n = measured(c, a, b)
    va, vb = (np.array(m.v) + np.cross(matrix(m) @ m.w, point - np.array(m.r)) for m in (a, b))
    h = 1e-4
    gaps = [CONTACTS[kind].gap(c, after(a, t), after(b, t)) for t in (-h, 0.0, h)]
    assert jet.b == pytest.approx(float(n @ (va - vb)), abs=1e-6)
    assert jet.b == pytest.approx((gaps[2] - gaps[0]) / (2 * h), abs=1e-6)
    assert jet.c == pytest.approx((gaps[2] - 2 * gaps[1] + gaps[0]) / h**2, abs=1e-4)


@pytest.mark.parametrize("kind", TYPES)
def test_slip_is_linear_in_velocities_and_its_bias_is_its_derivative(kind: str) -> None:
    c, a, b = contact(kind, RNG), motion(RNG), motion(RNG)

    def law(view: View) -> object:
        return CONTACTS[kind].rates(c, view[0], view[1])

    view = View({0: a, 1: b}, 0.0, {})
    C = [np.array(columns(law, view, i, velocity_level=True), float) for i in (0, 1)]
    found = sum(block @ np.array((*m.v, *m.w)) for block, m in zip(C, (a, b), strict=True))
    np.testing.assert_allclose(found, law(view), atol=1e-12)
    h = 1e-5
    ahead, behind = (law(View({0: after(a, t), 1: after(b, t)}, 0.0, {})) for t in (h, -h))
    biases = [lift(x).b for x in law(moving(view))]
    np.testing.assert_allclose(biases, (np.array(ahead) - np.array(behind)) / (2 * h), atol=1e-6)


def test_tangents_are_orthonormal_and_exact_along_axes() -> None:
    assert tangents((0.0, 0.0, 1.0)) == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    for n in (*RNG.normal(size=(50, 3)), np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])):
        n = n / np.linalg.norm(n)
        basis = np.array([*tangents(tuple(n)), n])
        np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(basis) == pytest.approx(1.0)


def test_a_wheel_that_rolls_does_not_slip() -> None:
    """Upright, heading along x with r w = v; and tilted by 30 degrees, where the edge is lower by cos."""
    wheel = Contact("w", "cylinder_plane", (0, -1), ((0.0,) * 3, (0.0,) * 3), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0),
                    {"radius": 0.5})  # fmt: skip
    rolling = Motion((0.0, 0.0, 0.5), so3.IDENTITY, (1.5, 0.0, 0.0), (0.0, 3.0, 0.0))
    assert CONTACTS["cylinder_plane"].gap(wheel, rolling, FIXED) == pytest.approx(0.0, abs=1e-16)
    assert CONTACTS["cylinder_plane"].rates(wheel, rolling, FIXED) == pytest.approx((0.0, 0.0), abs=1e-15)
    skidding = Motion((0.0, 0.0, 0.5), so3.IDENTITY, (1.5, 0.2, 0.0), (0.0, 0.0, 0.0))
    assert CONTACTS["cylinder_plane"].rates(wheel, skidding, FIXED) == pytest.approx((1.5, 0.2))
    tilted = Motion((0.0, 0.0, 1.0), so3.exp((np.pi / 6, 0.0, 0.0)))
    assert CONTACTS["cylinder_plane"].gap(wheel, tilted, FIXED) == pytest.approx(1.0 - 0.5 * np.cos(np.pi / 6))
