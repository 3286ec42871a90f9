"""Rank correlations and tornados against closed forms and SciPy; what their intervals hold."""

import numpy as np
import pytest
from scipy.stats import norm, spearmanr, ttest_ind

from lienumba.analysis import sensitivity
from lienumba.analysis.sensitivities.ranks import rank_interval, standard_ranks, tornado
from tests.analysis.sweep_example import named, sweep

TAIL = norm.pdf(norm.ppf(0.9)) / 0.1  # the mean of a standard normal number above its 90 % quantile


def linear(runs, seed=0):
    """Outputs 3 a - 2 b + c of standard normal inputs."""
    x = np.random.default_rng(seed).standard_normal((runs, 3))
    return x, x @ [3.0, -2.0, 1.0]


def test_a_linear_model_of_normal_inputs():
    x, y = linear(40_000)
    found = sensitivity(sweep(named(x), y=y)).sel(output="y")
    pearson = np.array([3.0, -2.0, 1.0]) / 14**0.5
    assert found["rank_correlation"].values == pytest.approx(6 / np.pi * np.arcsin(pearson / 2), abs=0.015)
    assert found["input_low"].values == pytest.approx([norm.ppf(0.1)] * 3, abs=0.03)
    assert found["input_high"].values == pytest.approx([norm.ppf(0.9)] * 3, abs=0.03)
    assert found["low"].values == pytest.approx(np.array([-3.0, 2.0, -1.0]) * TAIL, abs=0.15)
    assert found["high"].values == pytest.approx(np.array([3.0, -2.0, 1.0]) * TAIL, abs=0.15)
    assert found["change"].values == pytest.approx((found["high"] - found["low"]).values, abs=1e-12)
    assert (found["change_low"] < [6 * TAIL, -4 * TAIL, 2 * TAIL]).all()
    assert (found["change_high"] > [6 * TAIL, -4 * TAIL, 2 * TAIL]).all()
    assert float(found["mean"]) == pytest.approx(y.mean(), abs=1e-12)
    assert float(found["deviation"]) == pytest.approx(14**0.5, rel=0.02)


def test_rank_correlations_are_those_of_scipy():
    rng = np.random.default_rng(1)
    for x in (rng.standard_normal(50), rng.integers(0, 4, 50).astype(float)):
        y = np.round(x + rng.standard_normal(50), 1)  # with equal ones
        assert standard_ranks(x) @ standard_ranks(y) == pytest.approx(spearmanr(x, y).statistic, abs=1e-12)


@pytest.mark.parametrize("noise", [0.0, 0.3, 3.0])
def test_a_tornado_holds_what_it_says_however_strong_the_input_is(noise):
    """Welch's interval, which takes the ends of the tenths for known, holds 82 % of an input that is alone."""
    held = 0
    for seed in range(500):
        x, other = np.random.default_rng(seed).standard_normal((2, 200))
        found = tornado(x, x + noise * other)
        held += found["change_low"] <= 2 * TAIL <= found["change_high"]
    assert 0.92 < held / 500 < 0.985


def test_the_interval_of_a_tornado_without_effect_is_that_of_welch():
    rng = np.random.default_rng(2)
    x, y = rng.permutation(20_000).astype(float), rng.standard_normal(20_000)
    found = tornado(x, y)
    theirs = ttest_ind(y[x >= 18_000], y[x < 2000], equal_var=False).confidence_interval(0.95)
    assert (found["change_low"], found["change_high"]) == pytest.approx((theirs.low, theirs.high), abs=0.003)


def test_intervals_hold_what_they_say():
    held = []
    truth = 6 / np.pi * np.arcsin(3 / 14**0.5 / 2)
    for seed in range(400):
        x, y = linear(60, seed)
        low, high = rank_interval(spearmanr(x[:, 0], y).statistic, 60)
        found = tornado(x[:, 2], y)  # which has less effect than the others' noise
        held.append((low < truth < high, found["change_low"] < 2 * TAIL * 0.97 < found["change_high"]))
    assert np.mean(held, axis=0) == pytest.approx([0.95, 0.95], abs=0.03)


def test_a_discrete_input_has_its_lowest_and_highest_values():
    x = np.repeat([1.0, 2.0, 3.0], 20)
    found = tornado(x, x**2 + np.tile([-0.5, 0.5], 30))
    assert (found["low"], found["high"], found["change"]) == (1.0, 9.0, 8.0)
    assert tornado(np.array([0.0] * 99 + [1.0]), np.arange(100.0)) == {}


def test_few_runs_have_wide_intervals():
    x = np.arange(4.0)
    low, high = rank_interval(0.8, 4)
    assert low < -0.8
    assert high > 0.99
    assert rank_interval(1.0, 10) == (1.0, 1.0)
    found = tornado(x, x)
    assert found["change"] == 3.0
    assert np.isnan(found["change_low"])


def test_failures_are_left_out_and_are_an_output():
    x, y = linear(400)
    status = np.where(x[:, 1] > 0.8, 1, np.where(x[:, 0] > 2, 9, 0))  # an event is no failure
    found = sensitivity(sweep(named(x), status, y=np.where(status == 1, 1e9, y)))
    assert list(found["output"].values) == ["y", "failed"]
    failed = int((status == 1).sum())
    assert (found.attrs["runs"], found.attrs["failed"]) == (400, failed)
    assert list(found["runs"].values) == [400 - failed, 400]
    kept = status != 1
    ranks = found["rank_correlation"]
    assert float(ranks.sel(output="y", input="b")) == pytest.approx(spearmanr(x[kept, 1], y[kept]).statistic, abs=1e-12)
    of_failed = found.sel(output="failed")
    assert float(of_failed["mean"]) == pytest.approx(failed / 400)
    assert (of_failed["low"].sel(input="b"), of_failed["high"].sel(input="b")) == (0.0, 1.0)
    assert float(ranks.sel(output="failed", input="b")) == pytest.approx(spearmanr(x[:, 1], ~kept).statistic, abs=1e-12)
    assert abs(float(of_failed["change"].sel(input="c"))) < 0.3


def test_the_nominal_run_is_no_sample():
    x, y = linear(50)
    with_it = sweep(named(np.vstack([[9.0] * 3, x])), labels=np.arange(-1, 50), y=np.concatenate([[1e6], y]))
    without = sweep(named(x), y=y)
    assert sensitivity(with_it).drop_attrs().identical(sensitivity(without).drop_attrs())
