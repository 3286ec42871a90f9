"""The distributions with plain names, and those of SciPy, against scipy.stats; what is refused; the bits."""

import hashlib

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import stats

from lienumba.sweep.distributions.registry import AnyDistribution
from lienumba.sweep.samplers.streams import uniforms
from tests.facade import ScenarioError

ADAPTER = TypeAdapter(AnyDistribution)
U = uniforms("bodies.top.mass", range(20000), 2015)


def kind(distribution=None, **numbers):
    return ADAPTER.validate_python(({"distribution": distribution} if distribution else {}) | numbers)


def truncated(mean, std, low, high):
    return stats.truncnorm((low - mean) / std, (high - mean) / std, mean, std)


CONTINUOUS = [
    (kind("truncated_normal", std=0.5, low=14, high=15.2), 15.0, truncated(15, 0.5, 14, 15.2)),
    (kind("truncated_normal", mean=1, std=2, low=0), 15.0, truncated(1, 2, 0, np.inf)),
    (kind("truncated_normal", std=1, high=-6), 0.0, truncated(0, 1, -np.inf, -6)),
    (kind("truncated_normal", std=1, low=6, high=7), 0.0, truncated(0, 1, 6, 7)),
    (kind("truncated_normal", std=0.1, low=0.9, relative=True), -10.0, truncated(-10, 1, -np.inf, -9)),
    (kind("truncated_normal", std=0.1, low=0.9, high=1.3, relative=True), 10.0, truncated(10, 1, 9, 13)),
    (kind("lognormal", sigma=0.2), 15.0, stats.lognorm(0.2, scale=15)),
    (kind("lognormal", median=2, sigma=1.5, relative=True), 15.0, stats.lognorm(1.5, scale=30)),
    (kind("triangular", low=14, high=18), 15.0, stats.triang(0.25, 14, 4)),
    (kind("triangular", low=0.5, mode=1.0, high=1.0, relative=True), 10.0, stats.triang(1.0, 5, 5)),
    (kind("triangular", low=0.5, mode=0.6, high=1.0, relative=True), -10.0, stats.triang(0.8, -10, 5)),
    (kind(scipy="lognorm", s=0.2, scale=3), 15.0, stats.lognorm(0.2, scale=3)),
    (kind(scipy="weibull_min", c=1.7, loc=1.0, scale=2.0), 15.0, stats.weibull_min(1.7, 1.0, 2.0)),
    (kind(scipy="norm", loc=1.0, scale=0.1, relative=True), 15.0, stats.norm(15, 1.5)),
    (kind(scipy="beta", a=2, b=3), 0.0, stats.beta(2, 3)),
]


@pytest.mark.parametrize(("given", "nominal", "expected"), CONTINUOUS, ids=lambda x: str(x)[:30])
def test_samples_follow_the_distribution(given, nominal, expected):
    samples = given.ppf(U, nominal)
    np.testing.assert_allclose(samples, expected.ppf(U), rtol=1e-9)
    assert stats.kstest(samples, expected.cdf).pvalue > 1e-3


@pytest.mark.parametrize(
    ("given", "nominal", "weights"),
    [
        (kind("choice", values=[1, 2, 4]), 15.0, {1: 1 / 3, 2: 1 / 3, 4: 1 / 3}),
        (kind("choice", values=[1, 2, 4], weights=[0, 3, 1]), 15.0, {2: 0.75, 4: 0.25}),
        (kind("choice", values=[0.5, 2], relative=True), -10.0, {-5: 0.5, -20: 0.5}),
        (kind(scipy="randint", low=2, high=5), 15.0, {2: 1 / 3, 3: 1 / 3, 4: 1 / 3}),
        (kind(scipy="binom", n=2, p=0.5), 15.0, {0: 0.25, 1: 0.5, 2: 0.25}),
    ],
)
def test_values_come_as_often_as_they_should(given, nominal, weights):
    found, counts = np.unique(given.ppf(U, nominal), return_counts=True)
    expected = dict(sorted(weights.items()))
    np.testing.assert_array_equal(found, list(expected))
    assert stats.chisquare(counts, len(U) * np.array(list(expected.values()))).pvalue > 1e-3


def test_a_constant_is_one_and_takes_no_random_numbers():
    given = kind("constant", value=3.0)
    assert (given.dimensions, given.streams("x"), given.draw([], 15.0)) == (0, [], [3.0])
    assert kind("constant", value=3.0, relative=True).draw([], 15.0) == [45.0]


def test_bounds_hold_to_the_last_bit():
    extremes = np.array([2.0**-54, 1e-300, 1 - 2.0**-53])
    for numbers in ({"low": 0.1, "high": 0.3}, {"low": 30.0}, {"high": -30.0}):
        samples = kind("truncated_normal", mean=0.0, std=1.0, **numbers).ppf(extremes, 1.0)
        assert (samples >= numbers.get("low", -np.inf)).all()
        assert (samples <= numbers.get("high", np.inf)).all()
    assert (kind("choice", values=[1, 2], weights=[1, 0]).ppf(extremes, 1.0) == 1).all()


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ({"distribution": "truncated_normal", "std": 1}, "has neither low nor high; give one of them"),
        ({"distribution": "truncated_normal", "std": 0, "low": 1}, "greater than 0"),
        ({"distribution": "truncated_normal", "std": 1, "low": 2, "high": 1}, "low = 2: must not be above high = 1"),
        ({"distribution": "lognormal", "sigma": -1}, "greater than or equal to 0"),
        ({"distribution": "triangular", "low": 1, "high": 1}, "low = 1: must be below high"),
        ({"distribution": "choice", "values": []}, "values = []: is empty; give at least one value"),
        (
            {"distribution": "choice", "values": [1], "weights": [1, 2]},
            "must be as many as there are values, which is 1",
        ),
        ({"distribution": "choice", "values": [1], "weights": [0]}, "are all 0; give at least one above 0"),
        ({"distribution": "choice", "values": [1], "weights": [-1]}, "greater than or equal to 0"),
        ({"scipy": "lognrom"}, 'is no distribution of a number in scipy.stats; the nearest known name is "lognorm"'),
        ({"scipy": "lognorm"}, 'scipy = "lognorm": needs s; give s = ...'),
        ({"scipy": "norm", "std": 1}, "std = 1: norm has no such parameter"),
        ({"scipy": "norm", "scale": -1}, 'scipy = "norm": does not exist with scale = -1'),
        ({"scipy": "beta", "a": -2, "b": 1}, 'scipy = "beta": does not exist with a = -2, b = 1'),
        ({"scipy": "randint", "low": 1, "high": 3, "scale": 2}, "scale = 2: randint has no such parameter"),
        ({"scipy": "multivariate_normal"}, "is no distribution of a number in scipy.stats"),
        ({"scipy": "norm", "scale": "x"}, "valid number"),
    ],
)
def test_bad_numbers_are_refused(numbers, text):
    with pytest.raises(ValidationError) as caught:
        ADAPTER.validate_python(numbers)
    (error,) = caught.value.errors()
    assert text in error["msg"]


@pytest.mark.parametrize(
    ("given", "nominal", "text"),
    [
        (kind("lognormal", sigma=1), 0.0, "median: is the nominal value, which is 0"),
        (kind("lognormal", sigma=1, relative=True, median=1), 0.0, "relative = true: must be false"),
        (
            kind("triangular", low=1, high=2),
            3.0,
            "mode: the nominal value 3 does not lie between low and high, 1 and 2",
        ),
        (kind("triangular", low=1, high=2, mode=4), 1.0, "mode: the mode 4 does not lie"),
        (
            kind("truncated_normal", std=1, low=50),
            0.0,
            "mean: 0 lies more than 35 standard deviations outside of the bounds, 50 and inf",
        ),
        (
            kind("truncated_normal", std=1, high=-50),
            0.0,
            "mean: 0 lies more than 35 standard deviations outside of the bounds, -inf and -50",
        ),
        (kind("constant", value=2, relative=True), 0.0, "relative = true: must be false"),
    ],
)
def test_numbers_that_do_not_fit_the_nominal_value_are_refused(given, nominal, text):
    with pytest.raises(ScenarioError) as caught:
        given.draw([U] * given.dimensions, nominal)
    assert str(caught.value).startswith(text)


PINS = {
    "normal": (kind("normal", std=0.3), "df199f3c0acab991"),
    "uniform": (kind("uniform", low=1, high=4), "5f6e9e609c258ce8"),
    "truncated_normal": (kind("truncated_normal", std=0.3, low=14.9), "f39a7d3ee27a20b0"),
    "lognormal": (kind("lognormal", sigma=0.4), "4dc2f0264a2cfef1"),
    "triangular": (kind("triangular", low=13, high=16), "cd5ed99ff1f2016c"),
    "choice": (kind("choice", values=[1, 2, 5], weights=[0.1, 0.2, 0.3]), "6ea4fff4dc0238ba"),
}


@pytest.mark.parametrize("name", PINS)
def test_the_bits_are_the_same_everywhere(name):
    given, pin = PINS[name]
    assert hashlib.sha256(given.ppf(U, 15.0).tobytes()).hexdigest()[:16] == pin
