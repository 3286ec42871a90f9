"""Normal and uniform distributions: values, moments, and what is refused."""

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import stats

from lienumba.sweep.distributions.registry import AnyDistribution
from lienumba.sweep.distributions.scalar import Normal, Uniform
from lienumba.sweep.samplers.streams import uniforms
from tests.facade import ScenarioError

ADAPTER = TypeAdapter(AnyDistribution)
U = uniforms("bodies.top.mass", range(20000), 2015)


def normal(**numbers):
    return ADAPTER.validate_python({"distribution": "normal", **numbers})


def uniform(**numbers):
    return ADAPTER.validate_python({"distribution": "uniform", **numbers})


def test_the_name_chooses_the_distribution():
    assert isinstance(normal(std=1), Normal)
    assert isinstance(uniform(low=0, high=1), Uniform)


@pytest.mark.parametrize(
    ("distribution", "nominal", "expected"),
    [
        (normal(std=0.2), 15.0, stats.norm(15.0, 0.2)),
        (normal(mean=3.0, std=0.2), 15.0, stats.norm(3.0, 0.2)),
        (normal(std=0.01, relative=True), 15.0, stats.norm(15.0, 0.15)),
        (normal(std=0.01, relative=True), -4.0, stats.norm(-4.0, 0.04)),
        (normal(mean=2.0, std=0.01, relative=True), -4.0, stats.norm(-8.0, 0.04)),
        (uniform(low=148, high=152), 150.0, stats.uniform(148, 4)),
        (uniform(low=0.9, high=1.1, relative=True), 10.0, stats.uniform(9.0, 2.0)),
        (uniform(low=0.9, high=1.2, relative=True), -10.0, stats.uniform(-12.0, 3.0)),
    ],
)
def test_samples_follow_the_distribution(distribution, nominal, expected):
    samples = distribution.ppf(U, nominal)
    np.testing.assert_allclose(samples, expected.ppf(U), rtol=1e-12, atol=1e-12 * expected.std())
    assert stats.kstest(samples, expected.cdf).pvalue > 1e-3
    assert samples.mean() == pytest.approx(expected.mean(), abs=4 * expected.std() / np.sqrt(len(U)))
    assert samples.std() == pytest.approx(expected.std(), rel=0.03)


def test_a_width_of_zero_gives_the_constant():
    np.testing.assert_array_equal(normal(std=0).ppf(U, 15.0), 15.0)
    np.testing.assert_array_equal(uniform(low=2, high=2).ppf(U, 15.0), 2.0)


@pytest.mark.parametrize("distribution", [normal(std=0.1, relative=True), uniform(low=1, high=2, relative=True)])
def test_a_multiple_of_zero_is_refused(distribution):
    with pytest.raises(ScenarioError, match=r"relative = true: .*absolute"):
        distribution.ppf(U, 0.0)


@pytest.mark.parametrize(
    ("numbers", "location", "text"),
    [
        ({"distribution": "normal", "std": -0.1}, "std", "greater than or equal to 0"),
        ({"distribution": "normal", "std": float("nan")}, "std", "finite"),
        ({"distribution": "normal", "mean": float("inf"), "std": 1}, "mean", "finite"),
        ({"distribution": "normal"}, "std", "required"),
        ({"distribution": "normal", "std": "0.1"}, "std", "number"),
        ({"distribution": "normal", "std": True}, "std", "number"),
        ({"distribution": "normal", "std": 1, "relative": "yes"}, "relative", "boolean"),
        ({"distribution": "normal", "std": 1, "sd": 1}, "sd", "not permitted"),
        ({"distribution": "uniform", "low": 3, "high": 1}, "uniform", "low = 3: must not be above high = 1"),
        ({"distribution": "uniform", "low": 0, "high": float("nan")}, "high", "finite"),
        ({"distribution": "gamma", "std": 1}, "", "Unable to extract tag"),
    ],
)
def test_bad_numbers_are_refused_by_name(numbers, location, text):
    with pytest.raises(ValidationError) as caught:
        ADAPTER.validate_python(numbers)
    (error,) = caught.value.errors()
    assert text in error["msg"]
    assert (str(error["loc"][-1]) if error["loc"] else "") == location
