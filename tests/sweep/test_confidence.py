"""How sure intervals may be of the variance that they are made of."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import stats

from lienumba.sweep.confidence import binomial, freedom


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


@given(
    st.integers(1, 10**6),
    st.one_of(st.sampled_from([0.0, 0.5, 0.99, 1.0]), st.floats(1e-6, 1.0)),
    st.one_of(st.sampled_from([0.5, 0.95, 0.975]), st.floats(1e-4, 0.9999)),
)
@example(59, 0.5, 0.5)
def test_binomial_quantiles_are_those_of_scipy(n: int, probability: float, part: float) -> None:
    ours, theirs = int(binomial(part, n, probability)), int(stats.binom.ppf(part, n, probability))
    if ours != theirs:  # both are right where the probability is that of so many, but for rounding
        fewer = stats.binom.cdf(min(ours, theirs), n, probability)
        assert abs(ours - theirs) == 1
        assert abs(fewer / part - 1.0) < 1e-11
