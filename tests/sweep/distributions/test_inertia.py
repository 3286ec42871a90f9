"""Random inertias: bodies have them, they spread as they should, and in all axes alike."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from lienumba.sweep.distributions.inertia import Inertia, _exponential
from lienumba.sweep.samplers.streams import uniforms
from tests.facade import ScenarioError

U = [uniforms(f"x[{i}]", range(20000), 1) for i in range(6)]


def draw(std, nominal, u=U):
    xx, yy, zz, xy, xz, yz = np.broadcast_arrays(*Inertia(distribution="inertia", std=std).draw(u, nominal))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)


def elements(J):
    return [float(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]


def second_moments(J):
    return 0.5 * np.trace(J, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - J


@settings(max_examples=60)
@given(st.lists(st.floats(0.01, 1), min_size=3, max_size=3), st.floats(0, 1), st.integers(0, 2**32 - 1))
def test_every_sample_is_the_inertia_of_a_body(moments, std, seed):
    random = np.random.default_rng(seed)
    R = Rotation.random(random_state=random).as_matrix()
    J = R @ np.diag(np.sum(moments) - np.array(moments)) @ R.T  # of these second moments
    u = [random.uniform(1e-12, 1, 50) for _ in range(6)]
    principal = np.linalg.eigvalsh(draw(std, elements(J), u))
    assert (principal[:, 0] > 0).all()
    assert (principal[:, 0] + principal[:, 1] - principal[:, 2] >= -1e-12 * principal[:, 2]).all()


def test_second_moments_spread_by_std_in_all_axes_alike():
    R = Rotation.from_rotvec([0.4, 1.0, -0.7]).as_matrix()
    P = np.diag([1.0, 2.0, 4.0])
    straight = second_moments(draw(0.02, elements(np.trace(P) * np.eye(3) - P)))
    turned = second_moments(draw(0.02, elements(R @ (np.trace(P) * np.eye(3) - P) @ R.T)))
    back = R.T @ turned @ R
    for found in (straight, back):
        diagonal = np.diagonal(found, axis1=1, axis2=2)
        np.testing.assert_allclose(diagonal.mean(axis=0), np.diag(P), rtol=2e-3)
        np.testing.assert_allclose(diagonal.std(axis=0) / np.diag(P), 0.02, rtol=0.03)
    np.testing.assert_allclose(straight.std(axis=0), back.std(axis=0), rtol=0.05)


def test_a_plate_stays_one():
    principal = np.linalg.eigvalsh(draw(0.3, (1.0, 2.0, 3.0, 0.0, 0.0, 0.0)))
    np.testing.assert_allclose(principal[:, 0] + principal[:, 1], principal[:, 2], rtol=1e-12)


def test_no_spread_gives_the_nominal_inertia():
    nominal = (1.0, 1.2, 1.3, 0.1, -0.2, 0.05)
    np.testing.assert_allclose([elements(J) for J in draw(0.0, nominal)[:3]], [nominal] * 3, rtol=1e-14)


@settings(max_examples=30)
@given(st.floats(0, 5), st.integers(0, 2**32 - 1))
def test_the_exponential_agrees_with_scipy(size, seed):
    S = np.random.default_rng(seed).normal(size=(3, 3)) * size
    S = 0.5 * (S + S.T)
    S *= min(1.0, 10 / (np.linalg.norm(S, 2) + 1e-9))
    found = np.array(_exponential(tuple(S.ravel().tolist()))).reshape(3, 3)
    np.testing.assert_allclose(found, expm(S), atol=2e-13 * np.linalg.norm(expm(S), 2))


@pytest.mark.parametrize("nominal", [(1, 1, 2.1, 0, 0, 0), (2, 2, 2, 0.5, 0.9, 0.9), (1, 1, 1, 0.9, 0, 0)])
def test_an_inertia_that_no_body_has_is_refused(nominal):
    with pytest.raises(ScenarioError, match=r"no body has the nominal inertia .*triangle inequality"):
        draw(0.1, nominal)
