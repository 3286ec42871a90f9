"""Statistics of runs with weights, against those without and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from lienumba.sweep import confidence, weighted
from lienumba.sweep.samplers.importance import DEFENSIVE, Proposal, proposed
from lienumba.sweep.samplers.streams import uniforms

RUNS = 20000
LABELS = np.arange(RUNS)


def drawn(**proposal: float) -> tuple[np.ndarray, np.ndarray]:
    """Normal scores (runs,) and weights (runs,) of a proposal."""
    u = {"x": uniforms("x", LABELS, 7)}
    found, weights = proposed(u, {"x": Proposal(**proposal)}, LABELS, 7)
    return stats.norm.ppf(found["x"]), weights


@pytest.mark.parametrize("proposal", [{"shift": 3.0}, {"scale": 2.5}, {"shift": -1.0, "scale": 0.5}])
def test_weights_are_the_density_of_the_inputs_over_that_of_the_mixture(proposal: dict[str, float]) -> None:
    x, w = drawn(**proposal)
    own = stats.norm(proposal.get("shift", 0.0), proposal.get("scale", 1.0))
    mixture = DEFENSIVE * stats.norm.pdf(x) + (1 - DEFENSIVE) * own.pdf(x)
    np.testing.assert_allclose(w, stats.norm.pdf(x) / mixture, rtol=1e-6, atol=1e-9)
    assert w.max() <= 1 / DEFENSIVE
    assert stats.kstest(x, lambda z: DEFENSIVE * stats.norm.cdf(z) + (1 - DEFENSIVE) * own.cdf(z)).pvalue > 0.01


def test_a_rare_tail_is_known_to_a_few_per_cent() -> None:
    x, w = drawn(shift=4.5)
    truth = stats.norm.sf(4.5)
    found = weighted.proportion((x > 4.5).astype(float), w, 0.95)
    assert found.low < truth < found.high
    assert (found.high - found.low) / truth < 0.12


def test_means_quantiles_and_deviations_are_those_of_the_inputs() -> None:
    x, w = drawn(shift=1.0, scale=1.2)
    mean, upper = weighted.mean(x, w, 0.999), weighted.quantile(x, w, 0.95, 0.999)
    assert mean.low < 0.0 < mean.high
    assert upper.low < stats.norm.ppf(0.95) < upper.high
    assert weighted.deviation(x, w) == pytest.approx(1.0, abs=0.03)
    assert weighted.quantiles(x, w, (0.5,))[0] == pytest.approx(0.0, abs=0.05)


def test_equal_weights_are_none() -> None:
    x = np.random.default_rng(3).standard_normal(300)
    w = np.full(300, 0.7)
    half = confidence.half_width(x.std(ddof=1), 300, 0.9)
    found = weighted.mean(x, w, 0.9)
    np.testing.assert_allclose([found.low, found.high], [x.mean() - half, x.mean() + half])
    true = (x > 1).astype(float)
    both = weighted.proportion(true, w, 0.9)
    np.testing.assert_allclose([both.low, both.high], confidence.proportion(true.sum(), 300, 0.9))
    low, high = map(int, confidence.ranks(300, 0.8, 0.9))
    ends, near = weighted.quantile(x, w, 0.8, 0.9), np.sort(x)
    assert near[low - 1] <= ends.low <= near[low + 2]
    assert near[high - 2] <= ends.high <= near[high + 2]


def test_a_sum_that_is_rounded_tells_no_more_than_the_heaviest() -> None:
    """Of 2,000 sweeps that all meet it 544 told as much as 1e16 runs."""
    random = np.random.default_rng(0)
    for runs in random.integers(5, 400, 2000):
        w = random.lognormal(0.0, 2.0, runs)
        for true in (np.ones(runs), np.zeros(runs)):
            found = weighted.proportion(true, w, 0.9)
            assert found.value == true[0]
            assert found.low == 0.0 or found.high == 1.0
            assert weighted.runs_that_tell(true, w) == pytest.approx(w.sum() / w.max())


def test_none_that_fails_counts_as_the_heaviest() -> None:
    w = np.array([1.0] * 30 + [10.0])
    found = weighted.proportion(np.zeros(31), w, 0.9)
    assert (found.value, found.low) == (0.0, 0.0)
    assert found.high == pytest.approx(1 - 0.05 ** (1 / 4))
    few = weighted.quantile(np.arange(31.0), w, 0.05, 0.9)
    assert few.low == -np.inf
    assert np.isnan(weighted.mean(np.empty(0), np.empty(0), 0.9).value)
