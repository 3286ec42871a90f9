"""Contacts that yield against Hunt and Crossley's formula written down for one body, and against their energy."""

from dataclasses import replace

import numpy as np
import pytest

from lienumba.mechanics.elements.forces.compliant import CONTACT
from lienumba.mechanics.mechanism.model import Contact, Force
from lienumba.mechanics.system import applied_forces
from tests.facade import GROUND, Body, Instant, Model
from tests.mechanics.elements.contacts.test_geometry import after, at, matrix, motion

STIFFNESS, DISSIPATION, SPEED, STATIC, KINETIC = 400.0, 0.7, 0.05, 0.8, 0.5
Q = (0.1, -0.2, 0.3)
N = np.array([0.6, 0.0, 0.8])


def yielding(radius: float, **more: object) -> Model:
    part = Contact("c", "sphere_plane", (0, 1), ((0.2, 0.1, -0.3), Q), tuple(N), None, {"radius": radius},
                   static=STATIC, kinetic=KINETIC)  # fmt: skip
    numbers = {"stiffness": STIFFNESS, "dissipation": DISSIPATION, "velocity": SPEED, **more}
    bodies = tuple(Body(name, 1.0, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)) for name in "ab")
    return Model((0.0, 0.0, 0.0), bodies, forces=(Force("c", CONTACT, (0, 1), numbers=numbers, contact=part),))


def instant(*motions: object) -> Instant:
    return Instant(tuple((*m.r, *m.R, *m.v, *m.w) for m in motions))


@pytest.mark.parametrize("seed", range(12))
def test_forces_are_those_of_the_formula_and_balance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = motion(rng), motion(rng)
    b = b._replace(v=tuple(np.array(a.v) + 0.1 * rng.normal(size=3)), w=a.w) if seed % 2 else b
    normal, c = matrix(b) @ N, at(a, (0.2, 0.1, -0.3))
    gap = normal @ (c - at(b, Q))
    radius = abs(gap) + 0.1
    depth = radius - gap
    point = c - radius * normal
    va, vb = (np.array(m.v) + np.cross(matrix(m) @ m.w, point - np.array(m.r)) for m in (a, b))
    w = va - vb
    push = STIFFNESS * depth * max(0.0, 1.0 - DISSIPATION * (normal @ w))
    along = w - (normal @ w) * normal
    s = np.linalg.norm(along)
    mu = np.tanh(s / SPEED) * (KINETIC + (STATIC - KINETIC) * np.exp(-((s / (10 * SPEED)) ** 2)))
    force = push * (normal - mu * along / s)
    expected = [
        x
        for m, sign in ((a, 1.0), (b, -1.0))
        for x in (*(sign * force), *(matrix(m).T @ np.cross(point - np.array(m.r), sign * force)))
    ]
    model = yielding(radius)
    now = instant(a, b)
    np.testing.assert_allclose(applied_forces.generalized(model, now), expected, rtol=1e-9, atol=1e-9)
    total = np.dot(applied_forces.generalized(model, now), [x for m in (a, b) for x in (*m.v, *m.w)])
    h = 1e-5
    V = [applied_forces.potential(model, instant(after(a, t), after(b, t))) for t in (h, -h)]
    assert applied_forces.power(model, now) == pytest.approx(total + (V[0] - V[1]) / (2 * h), abs=1e-4)
    assert applied_forces.potential(model, now) == pytest.approx(0.5 * STIFFNESS * depth**2)


def test_apart_nothing_acts_and_at_rest_nothing_is_lost() -> None:
    rng = np.random.default_rng(1)
    a, b = motion(rng), motion(rng)
    height = (matrix(b) @ N) @ (at(a, (0.2, 0.1, -0.3)) - at(b, Q))
    apart = yielding(height - 0.01)
    assert not np.any(applied_forces.generalized(apart, instant(a, b)))
    assert applied_forces.power(apart, instant(a, b)) == 0.0
    still = instant(a._replace(v=(0.0,) * 3, w=(0.0,) * 3), b._replace(v=(0.0,) * 3, w=(0.0,) * 3))
    touching = yielding(height + 0.01)
    assert applied_forces.power(touching, still) == 0.0
    assert np.isfinite(applied_forces.generalized(touching, still)).all()


def test_leaving_it_never_pulls() -> None:
    rng = np.random.default_rng(2)
    a = motion(rng)
    ground = replace(yielding(10.0).forces[0], bodies=(0, GROUND))
    assert ground.contact is not None
    ground = replace(ground, contact=replace(ground.contact, bodies=(0, GROUND), normal=(0.0, 0.0, 1.0)))
    model = replace(yielding(10.0), forces=(ground,))
    Q = applied_forces.generalized(model, instant(a._replace(v=(0.0, 0.0, 50.0)), a))
    assert not np.any(Q)
