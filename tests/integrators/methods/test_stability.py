"""Where explicit methods are stable: known ends of their regions."""

import numpy as np
import pytest

from tests.facade import METHODS
from tests.integrators.methods.stability import polynomial, reach


@pytest.mark.parametrize(
    ("name", "real"),
    [("euler", 2.0), ("heun", 2.0), ("kutta3", 2.5127), ("rk4", 2.7853), ("bs32", 2.5127), ("dp54", 3.3066)],
)
def test_ends_on_the_real_axis(name: str, real: float) -> None:
    """Hairer and Wanner (1996), section IV.2."""
    assert reach(polynomial(METHODS[name]), np.array([-1.0 + 0j])) == pytest.approx(real, abs=0.011)


def test_the_end_of_rk4_on_the_imaginary_axis_and_of_a_series() -> None:
    assert reach(polynomial(METHODS["rk4"]), np.array([1j])) == pytest.approx(np.sqrt(8.0), abs=0.02)
    np.testing.assert_allclose(polynomial(METHODS["taylor"], 4), polynomial(METHODS["rk4"]), rtol=1e-15)
    assert reach(polynomial(METHODS["taylor"], 6), np.array([-1.0 + 0j])) == pytest.approx(3.5534, abs=0.011)
