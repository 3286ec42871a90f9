"""The inverse normal distribution function."""

import mpmath
import numpy as np
import pytest
from scipy import special

from lienumba.sweep.normal import _log, inverse, probability

AREAS = np.concatenate(
    [np.linspace(0.001, 0.999, 2001), 10.0 ** -np.linspace(0.3, 16.2, 500), [2.0**-54, 1 - 2.0**-53]]
)


def test_agrees_with_scipy():
    np.testing.assert_allclose(inverse(AREAS), special.ndtri(AREAS), rtol=2e-15, atol=3e-16)


@pytest.mark.parametrize("u", [2.0**-54, 1e-12, 1e-3, 0.0750001, 0.0749999, 0.3, 0.5, 0.925, 1 - 2.0**-53])
def test_agrees_with_mpmath(u):
    with mpmath.workdps(30):
        expected = float(mpmath.sqrt(2) * mpmath.erfinv(2 * mpmath.mpf(u) - 1))
    assert float(inverse(np.array(u))) == pytest.approx(expected, rel=2e-15, abs=1e-300)


def test_logarithm_agrees_with_mpmath():
    x = 10.0 ** -np.linspace(0.3, 17, 400)
    with mpmath.workdps(30):
        expected = [float(mpmath.log(float(value))) for value in x]
    np.testing.assert_allclose(_log(x), expected, rtol=4e-16)


def test_is_odd_and_increasing():
    u = np.arange(1, 4096) / 4096
    x = inverse(u)
    np.testing.assert_array_equal(x, -x[::-1])
    assert (np.diff(x) > 0).all()


def test_golden_bits():
    u = np.array([2.0**-54, 1e-6, 0.01, 0.3, 0.9, 0.999])
    assert [float(x).hex() for x in inverse(u)] == [
        "-0x1.095b059d67c4cp+3",
        "-0x1.30381a9799f7ep+2",
        "-0x1.29c5c4630ff0ep+1",
        "-0x1.0c7e39582c5fap-1",
        "0x1.4813c36e26d33p+0",
        "0x1.8b8cbb7204470p+1",
    ]


def test_probability_agrees_with_mpmath():
    x = np.concatenate([np.linspace(-9, 9, 400), [-37.0, -20.0, -2.0, 2.0, 20.0]])
    with mpmath.workdps(40):
        expected = [float(mpmath.ncdf(mpmath.mpf(float(value)))) for value in x]
    np.testing.assert_allclose(probability(x), expected, rtol=2e-14, atol=0)


def test_probability_is_the_inverse_of_its_inverse():
    np.testing.assert_allclose(probability(inverse(AREAS)), AREAS, rtol=1e-13)
    assert (np.diff(probability(np.linspace(-8, 5, 10001))) > 0).all()


def test_golden_bits_of_the_probability():
    assert [float(x).hex() for x in probability(np.array([-8.0, -1.9, -0.3, 0.7, 2.1]))] == [
        "0x1.669d2c90d55cfp-51",
        "0x1.d67dfb50dad20p-6",
        "0x1.87423a677e90ep-2",
        "0x1.841d5715c32a8p-1",
        "0x1.f6da7983d767bp-1",
    ]
