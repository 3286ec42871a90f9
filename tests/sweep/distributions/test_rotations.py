"""Random rotations and directions: their moments, frames and lengths."""

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import stats
from scipy.spatial.transform import Rotation

from lienumba.sweep.distributions.registry import AnyDistribution
from lienumba.sweep.samplers.streams import uniforms
from tests.facade import ScenarioError

ADAPTER = TypeAdapter(AnyDistribution)
START = Rotation.from_rotvec([0.3, -1.2, 0.7])
COUNT = 20000


def kind(distribution, **numbers):
    return ADAPTER.validate_python({"distribution": distribution, **numbers})


def draw(given, nominal, runs=COUNT):
    return np.array(given.draw([uniforms(name, range(runs), 1) for name in given.streams("x")], nominal)).T


def rotations(given, start=START):
    x, y, z, w = start.as_quat()
    found = draw(given, (2 * w, 2 * x, 2 * y, 2 * z))  # of any length
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, rtol=1e-14)
    return Rotation.from_quat(found, scalar_first=True)


@pytest.mark.parametrize("frame", ["body", "global"])
@pytest.mark.parametrize(
    ("numbers", "covariance"),
    [
        ({"std": 0.1}, np.diag([0.01, 0.01, 0.01])),
        ({"std": [0.1, 0.0, 0.3]}, np.diag([0.01, 0.0, 0.09])),
        ({"covariance": [[0.01, 0.01, 0], [0.01, 0.04, 0], [0, 0, 0]]}, [[0.01, 0.01, 0], [0.01, 0.04, 0], [0, 0, 0]]),
    ],
)
def test_the_covariance_comes_back_in_its_frame(frame, numbers, covariance):
    found = rotations(kind("rotation_normal", frame=frame, **numbers))
    turn = START.inv() * found if frame == "body" else found * START.inv()
    phi = turn.as_rotvec()
    np.testing.assert_allclose(phi.mean(axis=0), 0, atol=5 * 0.3 / np.sqrt(COUNT))
    np.testing.assert_allclose(np.cov(phi.T), covariance, atol=5 * 0.09 * np.sqrt(2 / COUNT))


def test_no_spread_gives_the_nominal_rotation():
    np.testing.assert_allclose((rotations(kind("rotation_normal", std=0)) * START.inv()).magnitude(), 0, atol=1e-14)


def test_uniform_rotations_have_their_moments():
    """Of the invariant measure: E R = 0, E R_ij R_kl = d_ik d_jl / 3, the angle has the density (1 - cos)/pi."""
    R = rotations(kind("rotation_uniform")).as_matrix().reshape(COUNT, 9)
    np.testing.assert_allclose(R.mean(axis=0), 0, atol=5 / np.sqrt(3 * COUNT))
    np.testing.assert_allclose(R.T @ R / COUNT, np.eye(9) / 3, atol=5 / np.sqrt(5 * COUNT))
    angle = rotations(kind("rotation_uniform")).magnitude()
    assert stats.kstest(angle, lambda a: (a - np.sin(a)) / np.pi).pvalue > 1e-3


@pytest.mark.parametrize("vector", [(0.0, 0.0, -9.81), (1.0, -2.0, 0.5)])
def test_directions_are_uniform_on_the_sphere(vector):
    found = draw(kind("direction"), vector)
    length = np.linalg.norm(vector)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), length, rtol=1e-14)
    for i in range(3):
        assert stats.kstest(found[:, i] / length, stats.uniform(-1, 2).cdf).pvalue > 1e-3
    np.testing.assert_allclose(found.T @ found / COUNT, np.eye(3) * length**2 / 3, atol=5 * length**2 / np.sqrt(COUNT))


def test_directions_within_an_angle_are_uniform_on_the_cap():
    vector, angle = np.array([1.0, -2.0, 0.5]), 0.2
    found = draw(kind("direction", angle=angle), tuple(vector))
    cosine = found @ vector / (vector @ vector)
    assert stats.kstest(cosine, stats.uniform(np.cos(angle), 1 - np.cos(angle)).cdf).pvalue > 1e-3
    across = found - np.outer(cosine, vector)
    np.testing.assert_allclose(across.mean(axis=0), 0, atol=5 * 0.5 / np.sqrt(COUNT))


def test_a_vector_without_length_has_no_direction():
    with pytest.raises(ScenarioError, match=r"the nominal vector .* has no direction"):
        draw(kind("direction"), (0.0, 0.0, 0.0), 3)


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ({}, "has neither std nor covariance; give one of them"),
        ({"std": 1, "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "has both std and covariance; give one of them"),
        ({"std": -1}, "greater than or equal to 0"),
        ({"std": [1, 2]}, "at least 3"),
        ({"covariance": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}, "is not positive semi-definite"),
        ({"covariance": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]}, "is not symmetric"),
        ({"std": 1, "frame": "world"}, "'body' or 'global'"),
    ],
)
def test_bad_numbers_are_refused(numbers, text):
    with pytest.raises(ValidationError) as caught:
        kind("rotation_normal", **numbers)
    (error,) = caught.value.errors()
    assert text in error["msg"]
