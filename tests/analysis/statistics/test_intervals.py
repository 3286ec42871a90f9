"""Confidence intervals of means and quantiles: closed forms, their coverage, and what too few runs can say."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import lienumba
from lienumba.analysis import mean_interval, proportion_interval, quantile_interval
from lienumba.engine.stopping import interval
from lienumba.scenario.schema.sweep import Stop

TRIALS = 4000


def series(values, **labels):
    values = np.asarray(values, dtype=float)
    dims = ("run", "time")[: values.ndim]
    coordinates = {name: np.arange(size) for name, size in zip(dims, values.shape, strict=True)} | labels
    return xr.DataArray(values, coordinates, dims, "tip", {"units": "m", "long_name": "position of a point"})


# ---------------------------------------------------------------- values
def test_means_are_those_of_scipy_over_the_runs_that_are_there(monkeypatch):
    monkeypatch.setattr("lienumba.analysis.statistics.blockwise.BLOCK_BYTES", 100)
    x = np.random.default_rng(1).normal(size=(12, 5))
    x[3, 2:] = np.nan
    found = mean_interval(series(x, run=np.arange(-1, 11)), confidence=0.9)
    for time in range(5):
        own = x[1:, time][~np.isnan(x[1:, time])]
        low, high = stats.ttest_1samp(own, 0.0).confidence_interval(0.9)
        values = [float(found[name][time]) for name in ("mean", "low", "high", "deviation", "count")]
        assert values == pytest.approx([own.mean(), low, high, own.std(ddof=1), len(own)], rel=1e-12)
    assert int(found.runs) == 11
    assert found["mean"].attrs == {"units": "m", "long_name": "mean of position of a point"}


def test_quantiles_are_those_of_numpy_and_their_ends_are_values():
    x = np.random.default_rng(2).exponential(size=(200, 3))
    x[150:, 1] = np.nan
    found = quantile_interval(series(x), [0.05, 0.5, 0.95])
    assert found.value.dims == ("time", "quantile")
    for time, size in enumerate((200, 150, 200)):
        own = np.sort(x[:size, time])
        assert found.value.values[time] == pytest.approx(np.quantile(own, [0.05, 0.5, 0.95]), rel=1e-14)
        assert np.isin(found.low.values[time], own).all()
        assert np.isin(found.high.values[time], own).all()
        assert int(found["count"][time]) == size
    one = quantile_interval(series(x), 0.5)
    assert one.identical(found.isel(quantile=1))


@pytest.mark.parametrize("statistic", ["mean", "quantile"])
@pytest.mark.parametrize("never", [0, 1, 40])
def test_sweeps_stop_by_the_same_intervals(statistic, never):
    """Margins of what never happens are infinite, on either side."""
    x = np.random.default_rng(3).normal(size=333)
    x[:never], x[50 : 50 + never // 2] = np.inf, -np.inf
    rule = Stop(variable="x", statistic=statistic, probability=0.9 if statistic == "quantile" else None, width=1.0)
    known = interval(x, rule)
    found = mean_interval(series(x)) if statistic == "mean" else quantile_interval(series(x), 0.9)
    values = [float(found[name]) for name in ("mean" if statistic == "mean" else "value", "low", "high")]
    assert values == pytest.approx([known.value, known.low, known.high], rel=1e-13)


def test_the_interval_of_a_median_is_the_known_one():
    """Of 10 values from the second to the ninth: 97.9 % (from the third to the eighth it were 89 %)."""
    found = quantile_interval(series(np.arange(10.0)), 0.5)
    assert (float(found.low), float(found.high)) == (1.0, 8.0)


# ---------------------------------------------------------------- coverage
@pytest.mark.parametrize("runs", [5, 40])
def test_means_of_normal_values_lie_within(runs):
    x = np.random.default_rng(runs).normal(size=(runs, TRIALS)) + 3.0
    found = mean_interval(series(x), confidence=0.9)
    covered = ((found.low <= 3.0) & (found.high >= 3.0)).mean()
    assert float(covered) == pytest.approx(0.9, abs=4 * (0.09 / TRIALS) ** 0.5)


@pytest.mark.parametrize(("runs", "q"), [(30, 0.5), (100, 0.95), (300, 0.997)])
def test_quantiles_lie_within_at_least_as_often_as_promised(runs, q):
    x = np.random.default_rng(runs).standard_cauchy((runs, TRIALS))
    found, truth = quantile_interval(series(x), q, confidence=0.9), stats.cauchy.ppf(q)
    below, above = (found.low > truth).mean(), (found.high < truth).mean()
    assert float(max(below, above)) < 0.05 + 4 * (0.05 * 0.95 / TRIALS) ** 0.5


@pytest.mark.parametrize(("runs", "p"), [(20, 0.5), (50, 0.02), (400, 0.99)])
def test_proportions_lie_within_at_least_as_often_as_promised(runs, p):
    x = np.random.default_rng(runs).uniform(size=(runs, TRIALS)) < p
    found = proportion_interval(series(x), confidence=0.9)
    below, above = (found.low > p).mean(), (found.high < p).mean()
    assert float(max(below, above)) < 0.05 + 4 * (0.05 * 0.95 / TRIALS) ** 0.5


def test_no_failure_in_2000_runs_is_no_proof():
    """The upper end is the p at which none in 2,000 has a probability of 2.5 %."""
    found = proportion_interval(series(np.zeros(2000)) > 1.0)
    assert (float(found.proportion), float(found.low)) == (0.0, 0.0)
    assert float(found.high) == pytest.approx(1.0 - 0.025 ** (1 / 2000), rel=1e-12)
    every = proportion_interval(series(np.ones(2000)))
    assert (float(every.low), float(every.high)) == (pytest.approx(0.025 ** (1 / 2000), rel=1e-12), 1.0)
    nothing = proportion_interval(series([np.nan]))
    assert (float(nothing.low), float(nothing.high), int(nothing["count"])) == (0.0, 1.0, 0)


def test_proportions_are_those_of_scipy():
    x = np.arange(60).reshape(20, 3) % 7 == 0
    found = proportion_interval(series(x), confidence=0.9)
    for k in range(3):
        own = stats.binomtest(int(x[:, k].sum()), 20).proportion_ci(0.9, method="exact")
        assert (float(found.low[k]), float(found.high[k])) == pytest.approx((own.low, own.high), rel=1e-12)


# ---------------------------------------------------------------- too few
@pytest.mark.parametrize(("runs", "known"), [(59, False), (71, False), (72, True), (120, True)])
def test_an_end_that_too_few_runs_can_tell_is_infinite(runs, known):
    """0.95^72 < 0.025: from then on the largest of so many is above the quantile for 97.5 % sure."""
    found = quantile_interval(series(np.arange(runs)), 0.95)
    assert np.isfinite(float(found.high)) == known
    assert np.isfinite(float(found.low))


@pytest.mark.parametrize("values", [[], [np.nan, np.nan], [2.0], [2.0, np.nan]])
def test_one_run_or_none_has_no_interval(values):
    known = [x for x in values if x == x]
    mean, median = mean_interval(series(values)), quantile_interval(series(values), 0.5)
    for found, name in ((mean, "mean"), (median, "value")):
        assert float(found[name]) == known[0] if known else np.isnan(found[name])
        assert (float(found.low), float(found.high)) == (-np.inf, np.inf)
        assert int(found["count"]) == len(known)
        assert int(found.runs) == len(values)
    assert np.isnan(mean.deviation)


def test_failed_runs_may_rank_behind_all_others():
    x = np.append(np.arange(98.0), [np.nan] * 2)
    left_out, worst = (quantile_interval(y, [0.5, 0.99]) for y in (series(x), series(x).fillna(np.inf)))
    assert left_out.value.values.tolist() == pytest.approx([48.5, 96.03])
    assert worst.value.values.tolist() == [49.5, np.inf]
    assert int(worst["count"]) == 100


# ---------------------------------------------------------------- bad input
@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda x: mean_interval(x, confidence=95), "confidence = 95: must be above 0 and below 1, such as 0.95"),
        (lambda x: quantile_interval(x, 1.0), "q = 1.0: must be above 0 and below 1"),
        (lambda x: quantile_interval(x, [0.5, "a"]), 'q = "a": must be above 0 and below 1'),
        (lambda x: quantile_interval(x, None), "q = None: must be above 0 and below 1"),
        (lambda x: quantile_interval(x, [0.1, [0.5, 0.9]]), "q = [0.5, 0.9]: must be above 0 and below 1"),
        (
            lambda x: quantile_interval(x.expand_dims("quantile"), 0.5),
            'the variable tip has a dimension "quantile", which the result needs; rename it',
        ),
        (lambda x: quantile_interval(x, []), "q = []: asks for no quantile; give numbers between 0 and 1"),
        (lambda x: mean_interval(x > 1.0), "position of a point is true and false: ask for lienumba.analysis.proport"),
        (proportion_interval, "2 is among the values of position of a point: a proportion is of true and false"),
        (lambda x: mean_interval(x, dim="runs"), '"runs" is no dimension of the variable tip; the nearest known'),
        (lambda x: mean_interval(x.values), "an object of type ndarray has no numbers to compare; give one"),
        (lambda x: mean_interval(x.astype(str)), "the variable tip of type <U32 has no numbers to compare"),
    ],
)
def test_bad_input_is_told(call, words):
    with pytest.raises(lienumba.ScenarioError) as error:
        call(series([1.0, 2.0]))
    assert words in str(error.value)
