"""How sure intervals may be of the variance that they are made of."""

import numpy as np

from lienumba.sweep.confidence import freedom


def test_the_freedom_is_that_of_the_chi_squared_distribution_that_varies_as_much() -> None:
    """Of normal terms their number, of heavier tails fewer: 2 E^2 / Var of the estimated variance."""
    rng = np.random.default_rng(1)
    assert abs(freedom(rng.standard_normal(200_000)) / 200_000 - 1.0) < 0.02
    terms = rng.standard_normal((4000, 200)) * rng.choice([0.3, 1.0], (4000, 200), p=[0.6, 0.4])
    variances = (terms**2).mean(axis=1)
    expected = 2.0 * variances.mean() ** 2 / variances.var()
    assert abs(np.median([freedom(x) for x in terms]) / expected - 1.0) < 0.1
    assert freedom(np.array([1.0, -1.0, 1.0])) == 3.0
    assert freedom(np.array([1e3, 1e-3, 0.0])) >= 1.0
